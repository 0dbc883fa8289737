"""The survey of random trips: ``python -m benchmarks.proof``, or ``make proof``.

`trips` draws trips that have a run by their making, `polish` looks for a cheaper run near a given one and shares no
physics with the package, `survey` puts both to what a search returns, and `tables` sums it up.
"""
