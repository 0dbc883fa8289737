"""Whole runs over a line: what a run is, the fastest one, and how a run is made exact.

Knows the `Profile`, row by row; the fastest run and with it the envelope of feasible speeds (`fastest`,
`braking_point`), the same by explicit steps (`stepped`); from means of the resistance to the true one
(`resistance_correction` and its kernels), rows cut where an effort limit jumps (`effort_jumps`), accelerations and
jerk (`comfort`).

Invariants: no run here is chosen by its energy; every row keeps to the efforts and limits. Start reading at
`profile`, then `fastest`.
"""
