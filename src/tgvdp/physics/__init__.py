"""Forces, the one arc function, and the independent replay. Kernels take arrays, scalars and named tuples in SI."""
