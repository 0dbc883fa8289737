"""A bracket of a root, narrowed by the Illinois rule: regula falsi that halves the value of an end which stays.

Kernels take no functions: each caller has its own loop, evaluates and ends it. (Dowell & Jarratt, *A modified regula
falsi method for computing the root of an equation*, BIT 11, 1971.)
"""

from typing import NamedTuple

from tgvdp._jit import leaf


class Bracket(NamedTuple):
    """Two ends, values that fall and rise away from 0 there, and the end that moved last: −1, 1, or 0 for none."""

    lo: float
    hi: float
    f_lo: float
    f_hi: float
    side: int = 0


@leaf
def secant(bracket):
    """Where the straight line through the ends of a bracket is 0."""
    return (bracket.lo * bracket.f_hi - bracket.hi * bracket.f_lo) / (bracket.f_hi - bracket.f_lo)


@leaf
def narrowed(bracket, x, f):
    """The bracket with its value f at x for the end on that side."""
    if f <= 0.0:
        return Bracket(x, bracket.hi, f, bracket.f_hi * (0.5 if bracket.side < 0 else 1.0), -1)
    return Bracket(bracket.lo, x, bracket.f_lo * (0.5 if bracket.side > 0 else 1.0), f, 1)
