"""Probabilities of success with their uncertainty, and the time to a solution.

TTS99 is the effort after which at least one attempt has succeeded with probability 99 %: n·t, n = ln(0.01)/ln(1 − p)
attempts of duration t each, and one attempt where p ≥ 0.99 (QOBLIB, arXiv 2504.03832; Rønnow et al., Science 345,
420, 2014).
"""

import math

from tgvdp.solvers.extras import extra

#: Of the intervals.
LEVEL = 0.95
_CONFIDENCE = 0.99


def proportion_interval(successes: int, attempts: int, level: float = LEVEL) -> tuple[float, float]:
    """Interval of a probability by Clopper and Pearson (Biometrika 26, 404, 1934): it covers no less than it says.

    Its ends are quantiles of the beta distribution: unlike those of ``scipy.stats.binomtest``, which looks for roots to
    2·10⁻¹², exact relative to small probabilities.

    Parameters
    ----------
    successes, attempts : int
        0 ≤ successes ≤ attempts, attempts ≥ 1.
    level : float
    """
    quantile = extra("scipy.special", "an interval of success").betaincinv
    tail, failures = 0.5 * (1.0 - level), attempts - successes
    low = float(quantile(successes, failures + 1, tail)) if successes else 0.0
    high = float(quantile(successes + 1, failures, 1.0 - tail)) if failures else 1.0
    return low, high


def attempts_to_success(p: float) -> float:
    """Attempts until one has succeeded with probability 99 %; infinite where p = 0, and at least one."""
    if p <= 0.0:
        return math.inf
    return 1.0 if p >= _CONFIDENCE else max(1.0, math.log(1.0 - _CONFIDENCE) / math.log1p(-p))
