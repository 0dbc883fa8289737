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

    def secant(self) -> float:
        """Where the straight line through the ends is 0."""
        return (self.lo * self.f_hi - self.hi * self.f_lo) / (self.f_hi - self.f_lo)

    def narrowed(self, x: float, f: float) -> "Bracket":
        """The bracket with x, where the value is f, for the end on that side."""
        if f <= 0.0:
            return Bracket(x, self.hi, f, self.f_hi * (0.5 if self.side < 0 else 1.0), -1)
        return Bracket(self.lo, x, self.f_lo * (0.5 if self.side > 0 else 1.0), f, 1)


#: The same for kernels, which know no methods.
secant = leaf(Bracket.secant)
narrowed = leaf(Bracket.narrowed)
