"""Trials of solvers on instances, behind `tgvdp bench` (docs/quantum-benchmark.md): finished runs are kept (`store`).

`spec` says what to run, `execute` runs it, `reference` knows the certified optima, `rows` and `statistics` judge runs,
`ensembles` families of instances, `trip_points`, `demand_points` and `landscape` look closer, `output` writes tables
and pictures, with `pivot` and `panels`.
"""
