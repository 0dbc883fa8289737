"""An extremal: a multiplier that was solved and driven, and what two of them say of the front between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.interpolate import cubic_energy_j, cubic_multiplier


@dataclass(frozen=True, eq=False)
class Extremal:
    """A solved multiplier: λ in J/s, its switching speeds, running time in s and energy in J.

    Those of the front method are (K + 1, 4), see `backward.switching_speeds`; the refinement keeps squared speeds of
    the run itself, (K + 1,).
    """

    multiplier: float
    switch: NDArray[np.float64]
    time_s: float
    energy_j: float

    def cost_j(self, multiplier: float) -> float:
        """Cost E + λT of this run at a multiplier in J/s."""
        return self.energy_j + multiplier * self.time_s


def ends_of(first: Extremal, second: Extremal) -> NDArray[np.float64]:
    """Running time, energy and multiplier of two extremals, (6,)."""
    return np.array([first.time_s, first.energy_j, first.multiplier, second.time_s, second.energy_j, second.multiplier])


def blend(first: Extremal, second: Extremal, share: float) -> NDArray[np.float64]:
    """Policy between those of two extremals, for a share of the second one."""
    return first.switch + share * (second.switch - first.switch)


def multiplier_between(first: Extremal, second: Extremal, time_s: float) -> float:
    """Multiplier at a time, J/s: minus the slope of the cubic through two extremals, within their multipliers."""
    return float(cubic_multiplier(ends_of(first, second).tolist(), time_s))


def energy_between(first: Extremal, second: Extremal, time_s: float) -> float:
    """Energy at a time, J, by the cubic through two extremals, whose slopes are their multipliers."""
    return float(cubic_energy_j(ends_of(first, second).tolist(), time_s))


def tangent_gap(first: Extremal, second: Extremal) -> float:
    """Largest distance between the chord of two extremals and the tangents through them, J."""
    span = second.time_s - first.time_s
    chord = (first.energy_j - second.energy_j) / span
    if not first.multiplier > chord > second.multiplier:
        return 0.0
    return span * (first.multiplier - chord) * (chord - second.multiplier) / (first.multiplier - second.multiplier)
