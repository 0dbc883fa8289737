"""Trials of solvers on instances, behind `tgvdp bench` (docs/benchmark.md): every run is kept when it ends (`store`).

`spec` says what to run, `execute` runs it, `reference` knows the certified optima, `rows` and `statistics` judge,
`trip_points`, `demand_points` and `landscape` look closer, `output` writes tables and pictures.
"""
