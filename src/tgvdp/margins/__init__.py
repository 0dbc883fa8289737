"""Margins: how a planned run is slowed down, whatever that costs, as railways define it today.

Knows the parts of a run between standstills and ends of ranges (`model.margin`), each with the time that it shall take
(`parts`); and three ways of taking it: all speeds by one ratio
(`linear`), a cap on the speed and coasting before it is lost (`economy`), and the least energy of all runs near the
linear one (`uniform`). `curve` holds what they share: squared speeds over the distance, and driving along the line.

Invariants: each part takes its time, and speeds are continuous where parts meet; nothing here knows what the optimum
is, which the margins are compared with elsewhere. Start reading at `side_by_side`.
"""
