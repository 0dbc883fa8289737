"""Points of time and energy that each formulation reaches, against the true front of the same trip.

A binary instance is a trip of constant accelerations without resistance. Driven in more or fewer steps of the same Δt
it takes more or less time; each formulation then spends what the replay of its optimum says. The same trip, as a train
without resistance on a level line, has a continuous front, which the search of the main program finds; in closed form
it is the three-phase run. Energies are what traction puts in, without regeneration, in J per kg of train.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.api import search
from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance, Instance
from tgvdp.formulations.problem.three_phase import three_phase_run
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve

#: Steps of the trip, as parts of those of the instance, and how many different ones.
_LONGEST = 1.6
_POINTS = 14
#: Largest instance that is driven in several numbers of steps.
MOST_STEPS = 30
#: Reads and sweeps of the heuristic.
_BUDGET = Allowance(reads=10, sweeps=1000)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reached:
    """Points of one formulation: its name, (n,) running times in s and (n,) energies in J/kg."""

    name: str
    time_s: Floats
    energy_j_per_kg: Floats


@dataclass(frozen=True)
class Comparison:
    """The front of a trip and what formulations reach.

    Attributes
    ----------
    instance : BinaryInstance
    front, closed : Reached
        By the search of the continuous problem, and the three-phase run.
    points : list of Reached
    """

    instance: BinaryInstance
    front: Reached
    closed: Reached
    points: list[Reached]

    def rows(self) -> list[dict[str, Any]]:
        """One row per point, with the least energy of its time, which is that of the three-phase run."""
        least = dict(zip(self.closed.time_s.tolist(), self.closed.energy_j_per_kg.tolist(), strict=True))
        return [
            {
                "Problem": self.instance.id, "formulation": one.name, "time_s": time_s, "energy_j_per_kg": energy,
                "least_j_per_kg": least.get(time_s),
            }
            for one in (self.closed, *self.points)
            for time_s, energy in zip(one.time_s.tolist(), one.energy_j_per_kg.tolist(), strict=True)
        ]  # fmt: skip


def comparison(instances: Sequence[Instance]) -> Comparison | None:
    """Compare on the largest binary instance of at most `MOST_STEPS` steps with one cap and an exact distance."""
    fitting = [
        one
        for one in instances
        if isinstance(one, BinaryInstance)
        and one.steps <= MOST_STEPS
        and len(set(one.cap_units[:-1])) == 1
        and one.distance_range[0] == one.distance_range[1] > 0
    ]
    return compare(max(fitting, key=lambda one: (one.steps, one.id))) if fitting else None


def compare(instance: BinaryInstance) -> Comparison | None:
    """Compare on one instance, which has one cap and an exact distance; None where its distance is out of reach."""
    cap = instance.cap_units[0]
    counts = sorted(set(np.linspace(1, _LONGEST * instance.steps, 4 * _POINTS).round().astype(int).tolist()))
    trips = [_in_steps(instance, count, cap) for count in counts]
    possible = [trip for trip in trips if _solved(replace(trip, model="constant"), "dp") is not None]
    if len(possible) < 2:
        return None
    chosen = [possible[i] for i in sorted(set(np.linspace(0, len(possible) - 1, _POINTS).round().astype(int).tolist()))]
    points = [
        _reached(f"binary, {model} (exact)", [replace(trip, model=model) for trip in chosen], "dp")
        for model in ("constant", "kinetic", "efficiency")
    ]
    if instance.acc_units == instance.dec_units:
        points.append(
            _reached(
                f"kinetic (unary by sa, {_BUDGET.reads} reads of {_BUDGET.sweeps} sweeps)",
                [replace(trip, model="kinetic") for trip in chosen],
                "sa",
            )
        )
    times = np.array([trip.steps * trip.dt_s for trip in chosen])
    return Comparison(instance, _front(instance, cap, times), _closed(instance, cap, times), points)


def _in_steps(instance: BinaryInstance, steps: int, cap: int) -> BinaryInstance:
    top = cap if instance.model != "efficiency" else max(cap, 1)
    return replace(
        instance, steps=steps, cap_units=(cap,) * steps, alpha=0.0, eta0=1.0, deta=0.5 / top, lambda_uniform=None
    )


def _solved(trip: BinaryInstance, solver: str) -> float | None:
    """Energy of traction, J/kg, that the replay of a feasible solution says; None where there is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        try:
            solution = solve(trip, solver, allowance=_BUDGET)
        except InfeasibleError:
            return None
    return float(solution.replay["energy"]) if solution.feasible and solution.replay["feasible"] else None


def _reached(name: str, trips: Sequence[BinaryInstance], solver: str) -> Reached:
    found = [(trip.steps * trip.dt_s, energy) for trip in trips if (energy := _solved(trip, solver)) is not None]
    times, energies = np.array(found, dtype=np.float64).reshape(-1, 2).T
    return Reached(name, times, energies)


def _accelerations(instance: BinaryInstance) -> tuple[float, float, float]:
    """Acceleration and deceleration in m/s², and the distance in m."""
    per_unit = instance.dv_mps / instance.dt_s
    distance_m = instance.distance_range[0] * instance.dv_mps * instance.dt_s
    return instance.acc_units * per_unit, instance.dec_units * per_unit, distance_m


def _front(instance: BinaryInstance, cap: int, time_s: Floats) -> Reached:
    """The front by the search: a train of 1 kg without resistance on a level line."""
    acceleration, deceleration, distance_m = _accelerations(instance)
    train = Train(
        mass_kg=1.0, traction=EffortCurve.from_caps(acceleration), friction_brake_n=deceleration,
        max_speed_mps=cap * instance.dv_mps, name="no resistance",
    )  # fmt: skip
    track = Track(length_m=distance_m, speed_limits=((0.0, cap * instance.dv_mps),), name="level")  # type: ignore[arg-type]
    result = search(train, track, max_time_s=float(time_s[-1]), points=40)
    return Reached("true front (search)", result.front.time_s, result.front.energy_j)


def _closed(instance: BinaryInstance, cap: int, time_s: Floats) -> Reached:
    acceleration, deceleration, distance_m = _accelerations(instance)
    found = []
    for time in time_s.tolist():
        try:
            run = three_phase_run(distance_m, time, acceleration, deceleration, cap * instance.dv_mps)
        except (InfeasibleError, InputError):
            continue
        found.append((time, run.energy_j()))
    times, energies = np.array(found, dtype=np.float64).reshape(-1, 2).T
    return Reached("three phases, closed form", times, energies)
