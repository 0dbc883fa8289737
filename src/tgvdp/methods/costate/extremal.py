"""A pilot: a multiplier that was solved and driven, and what two of them say of the front between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.interpolate import cubic_energy_j, cubic_price


@dataclass(frozen=True, eq=False)
class Pilot:
    """A solved multiplier: price λ in J/s, its switching speeds, running time in s and energy in J.

    Those of the front method are (K + 1, 3), see `costate.switching_speeds`; the refinement keeps squared speeds of the
    run itself, (K + 1,).
    """

    price: float
    switch: NDArray[np.float64]
    time_s: float
    energy_j: float

    def cost_j(self, price: float) -> float:
        """Cost E + λT of this run at a multiplier in J/s."""
        return self.energy_j + price * self.time_s


def ends_of(first: Pilot, second: Pilot) -> NDArray[np.float64]:
    """Running time, energy and price of two pilots, (6,)."""
    return np.array([first.time_s, first.energy_j, first.price, second.time_s, second.energy_j, second.price])


def blend(first: Pilot, second: Pilot, share: float) -> NDArray[np.float64]:
    """Policy between those of two pilots, for a share of the second one."""
    return first.switch + share * (second.switch - first.switch)


def price_between(first: Pilot, second: Pilot, time_s: float) -> float:
    """Price at a time, J/s: minus the slope of the cubic through two pilots, within their prices."""
    return float(cubic_price(ends_of(first, second).tolist(), time_s))


def energy_between(first: Pilot, second: Pilot, time_s: float) -> float:
    """Energy at a time, J, by the cubic through two pilots, whose slopes are their prices."""
    return float(cubic_energy_j(ends_of(first, second).tolist(), time_s))


def tangent_gap(first: Pilot, second: Pilot) -> float:
    """Largest distance between the chord of two pilots and the tangents through them, J."""
    span = second.time_s - first.time_s
    chord = (first.energy_j - second.energy_j) / span
    if not first.price > chord > second.price:
        return 0.0
    return span * (first.price - chord) * (chord - second.price) / (first.price - second.price)
