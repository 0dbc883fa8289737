"""Solvers of mixed-integer programs: HiGHS (`milp`), SCIP (`scip`), constrained quadratic models of dimod (`cqm`)."""
