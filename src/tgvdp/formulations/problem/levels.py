"""The binary model as a ladder of whole levels and whole costs, which exact solvers walk over.

From stop to stop, two identities turn each objective into one whole number per step, times an exact factor:
a·Σx = b·Σy, so the constant model is a·(a − α·b)·Σx; and what traction puts in, braking takes out, so the kinetic model
is (1 − α)·Σ x·a·(v + a/2). With a fixed distance D the efficiency model is η0·D − Δη·Σv². Where D has a tolerance,
both its terms count, brought to their common denominator.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import in_model_units
from tgvdp.formulations.problem.instances import BinaryInstance, decimal

#: Largest magnitude of the whole cost of a path: doubles tell all such numbers apart.
LARGEST_COST = 1 << 50
#: Levels above which tables would be too large.
MOST_LEVELS = 1_000_000


@dataclass(frozen=True, eq=False)
class Ladder:
    """Levels are speeds in units of g = gcd(a, b) steps of Δv; a path's height is Σ v_k, its distance in g·Δv·Δt.

    Attributes
    ----------
    caps : (N+1,) int64
        Largest level after each step; 0 at both ends.
    rise, fall : int
        a/g and b/g.
    cost : (3, H+1) int64
        Of accelerating, holding and braking at each level.
    low, high : int
        Range of the height.
    quantum : int
        The cost of every plan from stop to stop is a multiple of it.
    unit, constant : Fraction
        The objective is Δv²·(constant + unit·cost).
    """

    instance: BinaryInstance
    caps: NDArray[np.int64]
    rise: int
    fall: int
    cost: NDArray[np.int64]
    low: int
    high: int
    quantum: int
    unit: Fraction
    constant: Fraction

    @property
    def top(self) -> int:
        """H, the highest level."""
        return int(self.cost.shape[1]) - 1

    def objective(self, cost: int) -> float:
        """Objective of a path of a given cost, in (m/s)²."""
        return in_model_units(self.instance, self.constant + self.unit * cost)


def ladder_of(instance: BinaryInstance) -> Ladder:
    """Make the ladder of an instance.

    Raises
    ------
    InputError
        When the instance has too many levels, or η0 and Δη too many digits for exact arithmetic.
    """
    a, b = instance.acc_units, instance.dec_units
    g = gcd(a, b)
    rise, fall = a // g, b // g
    caps = np.array((0, *instance.cap_units[:-1], 0), dtype=np.int64) // g
    # Any higher, and there is no time to come down again.
    top = min(int(caps.max()), instance.steps * rise * fall // (rise + fall))
    if top > MOST_LEVELS:
        raise InputError(f"{instance.id}: {top} speeds are too many (at most {MOST_LEVELS}): use a coarser Δv")
    least, most = instance.distance_range
    low, high = -(-least // g), most // g
    v = g * np.arange(top + 1, dtype=np.int64)
    cost, unit, constant = _costs(instance, v, g * low if low == high else None)
    quantum = int(np.gcd.reduce(cost, axis=None)) or 1
    if instance.model == "constant":
        quantum *= fall  # rise·Σx = fall·Σy, and rise and fall have no common divisor
    return Ladder(instance, np.minimum(caps, top), rise, fall, cost, low, high, quantum, unit, constant)


def _costs(
    instance: BinaryInstance, v: NDArray[np.int64], distance: int | None
) -> tuple[NDArray[np.int64], Fraction, Fraction]:
    a, b, alpha = instance.acc_units, instance.dec_units, decimal(instance.alpha)
    cost = np.zeros((3, v.size), dtype=np.int64)
    if instance.model == "constant":
        unit = a * (a - alpha * b)
        cost[0] = (unit > 0) - (unit < 0)
        return cost, abs(unit), Fraction(0)
    if instance.model == "kinetic":
        unit = (1 - alpha) / 2
        cost[0] = a * (2 * v + a) if unit else 0
        return cost, unit, Fraction(0)
    eta0, deta = decimal(instance.eta0), decimal(instance.deta)
    arrivals = np.stack((v + a, v, v - b))
    if distance is not None:
        sign = (deta > 0) - (deta < 0)
        _require_exact(instance, int(v[-1] + a) ** 2 * instance.steps)
        return -sign * arrivals * arrivals, abs(deta), eta0 * distance
    unit = Fraction(1, lcm(eta0.denominator, deta.denominator))
    per_speed, per_square = int(eta0 / unit), int(deta / unit)
    fastest = int(v[-1]) + a
    _require_exact(instance, instance.steps * fastest * (abs(per_speed) + abs(per_square) * fastest))
    return per_speed * arrivals - per_square * arrivals * arrivals, unit, Fraction(0)


def _require_exact(instance: BinaryInstance, largest: int) -> None:
    if largest > LARGEST_COST:
        raise InputError(f"{instance.id}: eta0 and deta have too many digits to compare plans exactly: round them")
