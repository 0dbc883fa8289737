"""Replay: what a schedule really does. It trusts nothing that an encoding or a solver claims but the controls.

A schedule of the binary model is driven in SI with constant acceleration in each step; one of the demand model on the
true force curves, by the model's own time step and again by fine steps. Both report whether the constraints of the
instance hold, the energy, and the errors of distance and end speed.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from tgvdp.formulations.problem.drive import drive
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance, Instance, SubstationInstance
from tgvdp.formulations.problem.schedule import Schedule
from tgvdp.formulations.problem.substation import replay_substation


def replay(instance: Instance, schedule: Schedule) -> Mapping[str, Any]:
    """Drive a schedule on the physics of its instance.

    Returns
    -------
    mapping
        ``feasible``; ``objective`` recomputed, in the model's unit; ``energy`` with ``energy_unit``; ``distance_m``,
        ``distance_error_m``, ``end_speed_error_mps`` (each signed), ``overspeed_mps``; for the demand model also
        ``fine``, the same figures by fine time steps.
    """
    if isinstance(instance, SubstationInstance):
        return replay_substation(instance, schedule)
    if isinstance(instance, DemandInstance):
        from tgvdp.formulations.problem.demand_replay import replay_demand

        return replay_demand(instance, schedule.controls)
    return replay_binary(instance, schedule)


def replay_binary(instance: BinaryInstance, schedule: Schedule) -> dict[str, Any]:
    """Drive the controls of a binary schedule with constant acceleration u·Δv/Δt in each step.

    ``energy`` is the kinetic energy that traction puts in, less α times what braking takes out, in J/kg, whatever the
    model's objective is.
    """
    run = drive(instance, schedule.controls)
    return {
        "feasible": run.feasible,
        "objective": _objective(instance, run.speeds),
        "energy": sum(max(0.0, gain) + instance.alpha * min(0.0, gain) for gain in run.gains),
        "energy_unit": "J/kg",
        "distance_m": run.distance_m,
        "distance_error_m": run.distance_error_m,
        "end_speed_error_mps": run.speeds[-1],
        "overspeed_mps": run.overspeed_mps,
    }


def _objective(instance: BinaryInstance, speeds: list[float]) -> float:
    """The model's objective from speeds in m/s, without its bits."""
    changes = [after - before for before, after in pairwise(speeds)]
    if instance.model == "constant":
        return sum(u * u if u > 0 else -instance.alpha * u * u for u in changes)
    if instance.model == "kinetic":
        mean = [(before + after) / 2 for before, after in pairwise(speeds)]
        return sum(u * v * (1.0 if u > 0 else instance.alpha) for u, v in zip(changes, mean, strict=True))
    dv = instance.dv_mps
    return sum(instance.eta0 * dv * v - instance.deta * v * v for v in speeds[1:])
