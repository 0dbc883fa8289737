"""Pareto fronts of running time against energy: what a search returns, whatever its method."""
