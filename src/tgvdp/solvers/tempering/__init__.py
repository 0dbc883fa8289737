"""Parallel tempering of a QUBO: `solve` is the solver, `kernel` the replicas that change places."""
