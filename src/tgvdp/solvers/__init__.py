"""Solvers of the formulations: exact ones that need nothing more, and others that need the extra `quantum`."""
