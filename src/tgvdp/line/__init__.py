"""The line as one train meets it, and its cells.

Knows how gradients, curves, tunnels, speed limits and neutral sections of a `Track` act on a given train by the
trip's convention (`resolved`, from `resistance` and `piecewise` functions of the position), and how a trip is cut
into cells of constant resistance, drag, limit and current (`cells`).

Invariants: positions count from the trip's origin and are those of the train's head; nothing here moves a train.
Start reading at `resolved`.
"""
