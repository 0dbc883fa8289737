"""Probabilities of success with their uncertainty, and the time to a solution.

TTS99 is the effort after which at least one attempt has succeeded with probability 99 %: n·t, n = ln(0.01)/ln(1 − p)
attempts of duration t each, and one attempt where p ≥ 0.99 (QOBLIB, arXiv 2504.03832; Rønnow et al., Science 345,
420, 2014).
"""

import math
from collections.abc import Callable

import numpy as np

#: Of the intervals.
LEVEL = 0.95
_CONFIDENCE = 0.99


def proportion_interval(successes: int, attempts: int, level: float = LEVEL) -> tuple[float, float]:
    """Interval of a probability by Clopper and Pearson (Biometrika 26, 404, 1934): it covers no less than it says.

    Parameters
    ----------
    successes, attempts : int
        0 ≤ successes ≤ attempts, attempts ≥ 1.
    level : float
    """
    tail = 0.5 * (1.0 - level)
    low = 0.0 if successes == 0 else _root(lambda p: 1.0 - _at_most(successes - 1, attempts, p), tail)
    high = 1.0 if successes == attempts else _root(lambda p: -_at_most(successes, attempts, p), -tail)
    return low, high


def attempts_to_success(p: float) -> float:
    """Attempts until one has succeeded with probability 99 %; infinite where p = 0, and at least one."""
    if p <= 0.0:
        return math.inf
    return 1.0 if p >= _CONFIDENCE else max(1.0, math.log(1.0 - _CONFIDENCE) / math.log1p(-p))


def _at_most(successes: int, attempts: int, p: float) -> float:
    """P(X ≤ successes) of a binomial distribution, summed from its largest term."""
    if p <= 0.0:
        return 1.0
    if p >= 1.0:
        return 1.0 if successes >= attempts else 0.0
    k = np.arange(successes + 1)
    steps = np.log((attempts - k[:-1]) / (k[:-1] + 1.0)) + math.log(p) - math.log1p(-p)
    terms = attempts * math.log1p(-p) + np.concatenate(([0.0], np.cumsum(steps)))
    largest = float(terms.max())
    return float(min(1.0, math.exp(largest) * np.exp(terms - largest).sum()))


def _root(rising: Callable[[float], float], value: float) -> float:
    """The p of [0, 1] at which a rising function takes a value, by bisection in as many halvings as doubles have bits.

    Small probabilities are found relative to their size: the bisection goes on until both ends are neighbours.
    """
    low, high = 0.0, 1.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high or high - low < 1e-12 * high:
            return middle
        low, high = (middle, high) if rising(middle) < value else (low, middle)
