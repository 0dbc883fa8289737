"""The study of random windows between stops on random lines: ``python -m benchmarks.windows``, or ``make windows``.

`case` draws a train, a line and a timetable, `grid` finds the cheapest path of an explicit grid that keeps the windows
and knows nothing of multipliers, `study` puts what a journey returns beside it, and `tables` sums it up.
"""
