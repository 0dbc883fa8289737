"""Tables with units in their headers, as CSV or Excel: lines, and effort curves for native trains.

`sheets` and `workbook` make rows of `cells` of a file, `roles` tells by its header what a column means and its unit,
`table` what stands in it, `line` and `effort` make a track or a curve of the rows. Start at `reader`.
"""
