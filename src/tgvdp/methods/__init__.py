"""The methods: each finds the front of delay against energy of a trip in its own way.

`costate`, the front of the continuous problem by a costate dynamic program, the default; `phases`, its runs without
those phases that are too short to drive; `extremal`, clean runs of few commands from its runs; `refine`, any energy of
an arc by differential dynamic programming; `grid`, the exact and the best-first search of an explicit graph. `budget`
says what any of them may spend.

Invariants: they check each other (`grid.exact` cannot beat `costate`, `grid.best_first` with all paths equals
`grid.exact`); none of them touches files, prints, or knows the command line.
"""
