"""The benchmark of solvers on instances: every run is kept when it ends, tables and pictures are made of what is kept.

`tgvdp.bench.run.run_benchmark` is the door. A run is one call of a solver on an instance with a seed of its own; a
sampler makes many attempts (reads, shots) in a run. An attempt succeeds when its decoded schedule satisfies all
constraints of the instance and reaches the certified optimum.
"""
