"""Trains at one substation: what it delivers in each step, and the constraints of all trains together.

Each train is one of the kinetic binary model with steps of one Δv, has its own departure and its own mass m, and
arrives exactly. In units of ½·Δv² per kg of a train of mass 1, a train that accelerates from v to v + 1 draws m·(2v +
1), and one that brakes from v to v − 1 offers m·(2v − 1). What braking offers reaches trains that draw in the same
step, but for the part 1 − α, and is lost where nobody draws. So the substation delivers in step i

    n_i = max(0, drawn_i − α·offered_i) ≤ P,

and the objective is Σ n_i. Alone, each train is solved by a dynamic program over (step, speed, distance); together,
both the limit and what braking feeds couple all of them, and the states of the dynamic program are those of all trains
at once: their number is the product.

Whole numbers again: with α = p/q the deliveries are multiples of 1/q.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.formulations.problem.binary import schedule_of_speeds
from tgvdp.formulations.problem.drive import drive
from tgvdp.formulations.problem.instances import SubstationInstance, decimal
from tgvdp.formulations.problem.schedule import Check, Schedule

Ints: TypeAlias = NDArray[np.int64]

POWER_UNIT = "½·Δv² a step"
#: Part of the limit that sums of floating-point energies may exceed it by.
_ROUNDING = 1e-9


class Shares(NamedTuple):
    """α as p/q."""

    p: int
    q: int


def shares(instance: SubstationInstance) -> Shares:
    """The part of braking energy that others get, in whole numbers."""
    alpha = decimal(instance.alpha)
    return Shares(alpha.numerator, alpha.denominator)


def to_j_per_kg(instance: SubstationInstance, delivered: int) -> float:
    """Σ n_i in units of 1/q of ½·Δv² → J per kg of a train of mass 1, rounded once."""
    return float(Fraction(delivered, 2 * shares(instance).q) * decimal(instance.dv_mps) ** 2)


def joint_speeds(instance: SubstationInstance, speeds: Sequence[ArrayLike]) -> Ints:
    """Speeds of all trains on the substation's clock: each (N_k+1,) in Δv → (K, steps+1) int64.

    Before its start a train stands; after its end it keeps the speed it has, which is 0 where it obeys.
    """
    table = np.zeros((len(instance.trains), instance.steps + 1), dtype=np.int64)
    for row, train, own in zip(table, instance.trains, speeds, strict=True):
        v = np.asarray(own, dtype=np.int64)
        row[train.start : train.start + v.size] = v
        row[train.start + v.size :] = v[-1]
    return table


def delivered(instance: SubstationInstance, table: Ints) -> Ints:
    """q·n_i of each step, without the limit: speeds (K, steps+1) in Δv → (steps,) int64."""
    p, q = shares(instance)
    mass = np.array([[train.mass_units] for train in instance.trains])
    gained = mass * np.diff(table * table, axis=1)
    drawn, offered = np.maximum(gained, 0).sum(0), np.maximum(-gained, 0).sum(0)
    net: Ints = np.maximum(q * drawn - p * offered, 0)
    return net


def substation_schedule(
    instance: SubstationInstance, speeds: Sequence[ArrayLike], extra: tuple[Check, ...] = ()
) -> Schedule:
    """Schedule of all trains, one after the other, each with (N_k+1,) speeds in Δv.

    ``speeds`` and ``controls`` of the schedule are those of the trains in a row, ``distance`` is their sum.
    """
    own = [schedule_of_speeds(train.trip, v) for train, v in zip(instance.trains, speeds, strict=True)]
    net = delivered(instance, joint_speeds(instance, speeds))
    q = shares(instance).q
    over = float(Fraction(max(0, int(net.max()) - q * instance.power_units), q))
    per_train = tuple(
        Check(f"{check.name}, train {number}", check.violation, check.unit)
        for number, one in enumerate(own, start=1)
        for check in one.checks
    )
    return Schedule(
        speeds=tuple(v for one in own for v in one.speeds),
        controls=tuple(u for one in own for u in one.controls),
        distance=sum(one.distance for one in own),
        objective=to_j_per_kg(instance, int(net.sum())),
        checks=(*extra, *per_train, Check("power of the substation", over, POWER_UNIT)),
    )


def split(instance: SubstationInstance, controls: Sequence[float]) -> list[list[float]]:
    """Controls of each train, of the controls of all in a row."""
    parts, start = [], 0
    for train in instance.trains:
        parts.append(list(controls[start : start + train.trip.steps]))
        start += train.trip.steps
    return parts


def replay_substation(instance: SubstationInstance, schedule: Schedule) -> dict[str, Any]:
    """Drive the controls of all trains in SI, step by step, and add up at the substation.

    Of distances and end speeds the worst train's is reported; ``power_over_j_per_kg`` is by how much a step exceeds
    the limit.
    """
    drawn, offered = [0.0] * instance.steps, [0.0] * instance.steps
    driven = []
    for train, controls in zip(instance.trains, split(instance, schedule.controls), strict=True):
        run = drive(train.trip, controls)
        driven.append(run)
        for i, gain in enumerate(run.gains, start=train.start):
            drawn[i] += train.mass_units * max(0.0, gain)
            offered[i] += train.mass_units * max(0.0, -gain)
    net = [max(0.0, one - instance.alpha * other) for one, other in zip(drawn, offered, strict=True)]
    limit = 0.5 * instance.power_units * instance.dv_mps**2
    return {
        "feasible": all(run.feasible for run in driven) and max(net) <= limit * (1.0 + _ROUNDING),
        "objective": sum(net),
        "energy": sum(net),
        "energy_unit": instance.objective_unit,
        "distance_m": sum(run.distance_m for run in driven),
        "distance_error_m": max((run.distance_error_m for run in driven), key=abs),
        "end_speed_error_mps": max((run.speeds[-1] for run in driven), key=abs),
        "overspeed_mps": max(run.overspeed_mps for run in driven),
        "power_over_j_per_kg": max(0.0, max(net) - limit),
    }
