"""An extremal: a multiplier that was solved and driven, and what two of them say of the front between them."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Extremal(NamedTuple):
    """A solved multiplier: λ in J/s, its switching speeds, running time in s and energy in J.

    Those of the front method are (K + 1, 4), see `backward.switching_speeds`; the refinement keeps squared speeds of
    the run itself, (K + 1,). ``passed`` are squared speed, running time and energy at the stations, (K + 1, 3), where
    the front method drove it.
    """

    multiplier: float
    switch: NDArray[np.float64]
    time_s: float
    energy_j: float
    passed: NDArray[np.float64] = np.empty((0, 3))

    @property
    def outcome(self) -> tuple[float, float, float]:
        """Running time, energy and multiplier."""
        return self.time_s, self.energy_j, self.multiplier

    def cost_j(self, multiplier: float) -> float:
        """Cost E + λT of this run at a multiplier in J/s."""
        return self.energy_j + multiplier * self.time_s


class Foretold(NamedTuple):
    """What two extremals say of the optimum that takes a given time.

    Attributes
    ----------
    energy_j : float
        Its energy.
    share : float
        Where ln λ of it lies between those of the two.
    multiplier : float
    """

    energy_j: float
    share: float
    multiplier: float


def foretell(first, second, time_s):
    """Energy, multiplier, and share of the second extremal of the optimum that takes a time between two of them.

    The least E + λ·(T − t) is concave in λ, and largest, the least energy at the time t, at the multiplier of that
    time. Between two extremals it is a Hermite cubic in ln λ, for its slope is λ·(T − t). (Over the time energy may
    have a vertical tangent, next to the fastest run; over the multiplier nothing is steep.)

    ``first`` and ``second`` are running times, energies and multipliers of extremals. If the first multiplier is
    infinite, all is that of the second.
    """
    first_s, first_j, first_multiplier = first[0], first[1], first[2]
    second_s, second_j, second_multiplier = second[0], second[1], second[2]
    late = max(second_s - time_s, 0.0)
    h1 = second_j + second_multiplier * late
    if math.isinf(first_multiplier):
        return Foretold(h1, 1.0, second_multiplier)
    early = min(first_s - time_s, 0.0)
    h0 = first_j + first_multiplier * early
    span = math.log(second_multiplier / first_multiplier)
    g0 = span * first_multiplier * early
    g1 = span * second_multiplier * late
    c2 = 3.0 * (h1 - h0) - 2.0 * g0 - g1
    c3 = 2.0 * (h0 - h1) + g0 + g1
    below = math.sqrt(max(c2 * c2 - 3.0 * c3 * g0, 0.0)) - c2
    u = min(max(g0 / below, 0.0), 1.0) if below > 0.0 else 0.0
    return Foretold(h0 + u * (g0 + u * (c2 + u * c3)), u, first_multiplier * math.exp(u * span))


def between(first: Extremal, second: Extremal, time_s: float) -> Foretold:
    """What two extremals say of the optimum that takes a time between theirs."""
    return foretell(first.outcome, second.outcome, time_s)


def tangent_gap(first: Extremal, second: Extremal) -> float:
    """Largest distance between the chord of two extremals and the tangents through them, J."""
    span = second.time_s - first.time_s
    chord = (first.energy_j - second.energy_j) / span
    if not first.multiplier > chord > second.multiplier:
        return 0.0
    return span * (first.multiplier - chord) * (chord - second.multiplier) / (first.multiplier - second.multiplier)


def foretells(first: Extremal, second: Extremal) -> bool:
    """Whether the running time between two extremals may well be a quadratic in ln λ, as `foretell` takes it to be.

    The energy between them, the integral of λ over the time, says how that bends; if it would have to fall on the way,
    the time rises all but at once somewhere.
    """
    ratio = second.multiplier / first.multiplier
    span = -math.log(ratio)
    mean = (1.0 - ratio) / span
    bent = mean - 2.0 * (mean - ratio) / span  # of T = T0 + (T1 − T0)·(u + bend·u·(1 − u)), λ = λ0·ratio^u
    chord = (first.energy_j - second.energy_j) / (second.time_s - first.time_s)
    return abs(chord / first.multiplier - mean) <= abs(bent)
