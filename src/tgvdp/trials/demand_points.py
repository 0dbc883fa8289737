"""Points of time and energy of the demand formulation, against the continuous optimum of the same run.

A demand instance is driven in more or fewer steps of the same Δt; each exact optimum of the model is replayed by fine
steps. Its coarse step makes it cover another distance than it claims, so that each point is compared with a run of its
own: the search of the main program finds the least work of traction for the same train, the distance that the demands
really cover, the same time and the same speed at the end. The train of the search may brake fully down to standstill,
where the electrodynamic brake of the curves fades.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tgvdp.api import search
from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.formulations.problem.alstom import braking_n, traction_n
from tgvdp.formulations.problem.instances import DemandInstance, Instance
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.solvers.registry import solve
from tgvdp.trials.trip_points import Floats
from tgvdp.units import KMH_PER_MPS

#: Largest instance that is driven in several numbers of steps, which go up to this multiple of its own.
MOST_STEPS = 12
_LONGEST = 1.7


@dataclass(frozen=True)
class DemandComparison:
    """What the demand model claims, what its demands do, and what was possible.

    Attributes
    ----------
    instance : DemandInstance
    time_s : (n,) float64
        Running times.
    claimed_j, driven_j, optimal_j : (n,) float64
        Work of traction: by the model's own steps, by fine steps, and of the continuous optimum of the same distance,
        time and end speed as the fine steps.
    distance_off : (n,) float64
        Distance by fine steps over that of the model's steps, less 1.
    """

    instance: DemandInstance
    time_s: Floats
    claimed_j: Floats
    driven_j: Floats
    optimal_j: Floats
    distance_off: Floats

    def rows(self) -> list[dict[str, Any]]:
        """One row per running time."""
        columns = ("time_s", "claimed_j", "driven_j", "optimal_j", "distance_off")
        values = zip(*(getattr(self, name).tolist() for name in columns), strict=True)
        return [{"Problem": self.instance.id, **dict(zip(columns, row, strict=True))} for row in values]


def demand_comparison(instances: Sequence[Instance]) -> DemandComparison | None:
    """Compare on the largest demand instance with notches and at most `MOST_STEPS` steps; None where there is none."""
    fitting = [one for one in instances if isinstance(one, DemandInstance) and one.levels and one.steps <= MOST_STEPS]
    return compare_demand(max(fitting, key=lambda one: (one.steps, one.id))) if fitting else None


def compare_demand(instance: DemandInstance) -> DemandComparison | None:
    """Compare on one instance; None where no number of steps has a proved optimum."""
    train = _train(instance)
    rows = []
    for steps in range(2, round(_LONGEST * instance.steps) + 1):
        try:
            solution = solve(replace(instance, steps=steps), "dp")
        except (InfeasibleError, BudgetExceededError):
            continue
        if not solution.optimal:
            continue
        own, fine = solution.replay, solution.replay["fine"]
        time_s = steps * instance.dt_s
        track = Track(length_m=fine["distance_m"], speed_limits=(SpeedLimit(0.0, instance.vmax_mps),), name=instance.id)
        try:
            best = search(train, track, end_speed_mps=fine["end_speed_error_mps"], at_s=[time_s])
        except InfeasibleError:  # the demands go faster than the limit between the ends of their steps
            continue
        off = fine["distance_m"] / own["distance_m"] - 1.0
        rows.append((time_s, own["mechanical_j"], fine["mechanical_j"], float(best.front.energy_j[-1]), off))
    if not rows:
        return None
    return DemandComparison(instance, *np.array(rows, dtype=np.float64).T)


def _train(instance: DemandInstance) -> Train:
    """The instance's train: curves by the km/h, and friction that makes up for the fading brake."""
    speed_mps = np.append(np.arange(0.0, instance.vmax_mps * KMH_PER_MPS, 1.0) / KMH_PER_MPS, instance.vmax_mps)
    a, b, c = instance.davis
    return Train(
        mass_kg=instance.mass_kg,
        rotating_mass_factor=instance.rotating_factor,
        davis_a_n=a,
        davis_b_n_per_mps=b,
        davis_c_n_per_mps2=c,
        traction=EffortCurve.from_points(zip(speed_mps.tolist(), traction_n(speed_mps).tolist(), strict=True)),
        friction_brake_n=float(braking_n(speed_mps).max()),
        max_speed_mps=instance.vmax_mps,
        name=instance.id,
    )
