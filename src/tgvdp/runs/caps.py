"""Caps on speeds: how low they may be."""

import math
from collections.abc import Callable


def lowest_cap_mps(is_possible: Callable[[float], bool], low_mps: float, high_mps: float, factor: float) -> float:
    """The lowest cap that is possible, between one that is not and one that is, m/s, known to a factor above 1."""
    while high_mps > factor * low_mps:
        cap_mps = math.sqrt(low_mps * high_mps)
        if is_possible(cap_mps):
            high_mps = cap_mps
        else:
            low_mps = cap_mps
    return high_mps
