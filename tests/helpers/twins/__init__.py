"""Slow, readable twins of the kernels in plain Python: what a fast thing must agree with."""
