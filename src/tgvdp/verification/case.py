"""One thing that is verified: two numbers, and in how many digits they agree.

Digits are the log relative error −log₁₀|x − c|/|c| (McCullough, The American Statistician 52, 1998, section 3).
"""

import math
from typing import NamedTuple

#: What float64 can tell.
MOST_DIGITS = 15.0


class Case(NamedTuple):
    """Two numbers that shall agree.

    Attributes
    ----------
    part, name : str
        What is verified, with the unit of the numbers.
    found, expected : float
    error : float
        Their difference, relative to a scale.
    least_digits : float
        Digits that must agree.
    """

    part: str
    name: str
    found: float
    expected: float
    error: float
    least_digits: float

    @property
    def digits(self) -> float:
        """Log relative error; 0 where nothing agrees, or where a number is none."""
        if not math.isfinite(self.error):
            return 0.0
        return min(MOST_DIGITS, max(0.0, -math.log10(max(self.error, 1e-300))))

    @property
    def ok(self) -> bool:
        """Whether as many digits agree as must."""
        return self.digits >= self.least_digits


def equal(part: str, name: str, found: float, expected: float, least_digits: float, scale: float | None = None) -> Case:
    """Two numbers that shall be equal; their difference is a share of ``scale``, by default the expected one, or 1."""
    error = abs(found - expected) / (scale or abs(expected) or 1.0)
    return Case(part, name, float(found), float(expected), float(error), least_digits)


def at_most(part: str, name: str, found: float, most: float, least_digits: float, scale: float | None = None) -> Case:
    """A number that shall not be above another."""
    error = max(0.0, found - most) / (scale or abs(most) or 1.0)
    return Case(part, name, float(found), float(most), float(error), least_digits)
