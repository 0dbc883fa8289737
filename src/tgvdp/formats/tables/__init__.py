"""Tables with units in their headers, as CSV or Excel: lines, and effort curves for native trains.

`sheets` and `workbook` make rows of `cells` of a file, `headers` finds the header and its units, `roles` tells what a
column means, `table` what stands in it; `parts` joins sheets, `line` and `effort` make a track or a curve of the rows.
Start at `reader`.
"""
