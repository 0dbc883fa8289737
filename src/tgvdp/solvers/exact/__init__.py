"""Exact solvers: the dynamic program over a `ladder` of levels and its Lagrangian windows (`lagrange`), brute force,
closed forms, and the search of the demand model under proved bounds. `solve` is their door; `ladder` and
`ladder_paths` are kernels.
"""
