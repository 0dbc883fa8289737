"""The generic refinement: the front for any energy of an arc (docs/refine.md).

Discrete differential dynamic programming (`kernel`) on one `mesh` at a time, from runs of the front method, or of
the `convex_map` of an energy map, made drivable by switching between two efforts (`pulse_and_glide`).

Invariants: each step improves a feasible run; there is no certificate. Start reading at `front`.
"""
