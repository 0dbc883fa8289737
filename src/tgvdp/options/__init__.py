"""What can be asked of a search, declared once.

`search` declares every option of a search as one field of `SearchOptions`; `option` says what a declaration holds;
`texts` reads what people write: quantities with units, targets.

All that offers or checks options derives from these declarations and lists none itself: the command line and its help,
the table ``run`` of the native format, the checks of `tgvdp.search`, the options in a result. Whoever adds an option
adds a field there, and its argument to `tgvdp.search` (a test compares the two).

Invariants: no numpy, so that ``--help`` stays quick; values are in SI once they are arguments, and in the unit that
people use before. Start reading at `search`.
"""
