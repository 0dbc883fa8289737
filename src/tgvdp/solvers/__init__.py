"""Solvers of the formulations, each by its name in `registry` (docs/solvers.md).

`exact` proves optima, `programs` hands mixed-integer programs to HiGHS, SCIP and CQM samplers, `samplers` and
`tempering` draw strings of a QUBO, `circuit` runs QAOA. `allowance` is what a solver may spend, `extras` loads optional
packages when a solver runs, `exchange` writes files of other programs.

Invariant: every solver ends in a `Solution` that has been replayed. Start reading at `registry`.
"""
