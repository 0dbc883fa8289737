"""Samplers of a QUBO: `annealing` and its relatives, D-Wave's machines (`cloud`), the baseline (`coin_tosses`).

`sampling` turns samples into one replayed solution; `embedding` counts qubits of an annealer.
"""
