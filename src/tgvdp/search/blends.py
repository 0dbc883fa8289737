"""Between two pilots: blends of their policies, and what their (T, E, slope −λ) say of the front there."""

import numpy as np
from numpy.typing import NDArray

from tgvdp.search.pilots import Pilot, Sample


def blend(first: Pilot, second: Pilot, share: float) -> NDArray[np.float64]:
    """Squared switching speeds between those of two pilots, (K + 1,)."""
    return first.switch + share * (second.switch - first.switch)


def first_share(samples: list[Sample], at: int, time_s: float) -> float:
    """Share to try for a running time between the samples ``at − 1`` and ``at``: by those two and one more, if any."""
    (u0, t0), (u1, t1) = samples[at - 1], samples[at]
    if not t0 < time_s < t1:
        return u0 if time_s <= t0 else u1
    straight = u0 + (u1 - u0) * (time_s - t0) / (t1 - t0)
    if len(samples) == 2:
        return straight
    u2, t2 = samples[at - 2] if at > 1 else samples[at + 1]
    bend = ((u2 - u1) / (t2 - t1) - (u1 - u0) / (t1 - t0)) / (t2 - t0)
    bent = straight + bend * (time_s - t0) * (time_s - t1)
    return bent if u0 < bent < u1 else straight


def unit(share: float) -> float:
    """The share, or the nearer end of [0, 1]."""
    return min(max(share, 0.0), 1.0)


def slope(first: Pilot, second: Pilot, time_s: float) -> float:
    """Price at a time: minus the slope of the cubic, within the prices of the two pilots."""
    span = second.time_s - first.time_s
    u = unit((time_s - first.time_s) / span)
    chord = (first.energy_j - second.energy_j) / span
    bends = (1.0 - 4.0 * u + 3.0 * u * u) * first.price + (3.0 * u * u - 2.0 * u) * second.price
    return min(max(6.0 * u * (1.0 - u) * chord + bends, second.price), first.price)


def tangent_gap(first: Pilot, second: Pilot) -> float:
    """Largest distance between the chord of two pilots and the tangents through them, J."""
    span = second.time_s - first.time_s
    chord = (first.energy_j - second.energy_j) / span
    if not first.price > chord > second.price:
        return 0.0
    return span * (first.price - chord) * (chord - second.price) / (first.price - second.price)


def cubic(first: Pilot, second: Pilot, time_s: float) -> float:
    """Energy at a time by the Hermite cubic through two pilots, whose slopes are their prices."""
    span = second.time_s - first.time_s
    u = (time_s - first.time_s) / span
    value = (1.0 + 2.0 * u) * (1.0 - u) ** 2 * first.energy_j + u * u * (3.0 - 2.0 * u) * second.energy_j
    return value - span * (u * (1.0 - u) ** 2 * first.price - u * u * (1.0 - u) * second.price)
