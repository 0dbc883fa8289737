"""Tables with units in their headers, as CSV or Excel: lines, and effort curves for native trains.

`sheets` makes rows of cells of a file, `columns` tells which column means what and in which unit, `line` and `effort`
make a track or a curve of the rows. Start at `reader`.
"""
