"""From a real trip to an instance: a train on a line as the binary or the demand model, and what that leaves out.

Both models count time in N equal steps of the running time. Of the binary model the equal steps of acceleration and
braking are those with which three phases (`three_phase`) of the same distance and top speed take the fastest running
time; gradients, limits by place and the fading of traction count as far as they make that longer, and not beyond.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from tgvdp.errors import InfeasibleError
from tgvdp.formulations.problem.alstom import TOP_KMH, braking_n, traction_n
from tgvdp.formulations.problem.instances import Model
from tgvdp.model.trip import Trip
from tgvdp.units import JOULE_PER_KWH, KILO, KMH_PER_MPS, counted

#: Of the demand model, as in the built-in instances: notches, tolerances, and the least P_max that creates no energy.
_NOTCHES = 2
_DISTANCE_TOLERANCE = 0.02
_END_SPEED_MPS = 1.5
_P_MAX_W = 9.8e6


class Reference(NamedTuple):
    """What the search found about a trip.

    Attributes
    ----------
    fastest_s, top_mps : float
        Running time and top speed of the fastest run.
    running_time_s, energy_j : float
        Running time of the instance, and the least energy at the wheel that the trip takes in it.
    """

    fastest_s: float
    top_mps: float
    running_time_s: float
    energy_j: float


class TripInstance(NamedTuple):
    """An instance as the tree of its JSON file, which `parse_instance` reads, and what it leaves out."""

    tree: dict[str, Any]
    losses: tuple[str, ...]


def binary_of_trip(trip: Trip, reference: Reference, steps: int, model: Model) -> TripInstance:
    """Write a trip as the binary model; the distance is met exactly, by the size of Δv.

    ``alpha`` is what of the energy at the wheel comes back to it: traction times regeneration efficiency where the trip
    counts energy at the pantograph, nothing at the wheel.

    Raises
    ------
    InfeasibleError
        When no plan of so many steps covers the distance.
    """
    dt_s = reference.running_time_s / steps
    slow_s = reference.fastest_s - trip.distance_m / reference.top_mps
    acceleration = reference.top_mps / slow_s
    distance_units = max(1, round(trip.distance_m / (acceleration * dt_s * dt_s)))
    dv_mps = trip.distance_m / (distance_units * dt_s)
    cap = math.floor(reference.top_mps / dv_mps * (1.0 + 1e-9))
    farthest = sum(min(k, steps - k, cap) for k in range(steps))
    if farthest < distance_units:
        raise InfeasibleError(
            f"{_name(trip, steps)}: {counted(steps, 'step')} of {dt_s:.4g} s at ±{dv_mps:.4g} m/s cover {farthest} of "
            f"{distance_units} Δv·Δt: take more steps or a longer running time"
        )
    params = {
        "kind": "binary", "model": model, "N": steps, "dt_s": dt_s, "dv_mps": dv_mps, "acc_units": 1, "dec_units": 1,
        "cap_units": cap, "D_units": distance_units, "alpha": _alpha(trip),
    }  # fmt: skip
    if model == "efficiency":  # η falls to a half at the top speed
        params |= {"alpha": 0.0, "eta0": 1.0, "deta": 0.5 / cap}
    losses = (
        f"traction and braking by speed: every step changes the speed by {dv_mps:.4g} m/s in {dt_s:.4g} s "
        f"({dv_mps / dt_s:.3g} m/s²) or not at all",
        *_resistance(trip, reference),
        *_slopes(trip),
        *_places(trip, reference.top_mps * KMH_PER_MPS),
    )
    return TripInstance({"id": _name(trip, steps), "params": params, "notes": list(losses)}, losses)


def demand_of_trip(trip: Trip, reference: Reference, steps: int) -> TripInstance:
    """Write a trip as the demand model, with mass, resistance, gradients and curves of the train and the line.

    Raises
    ------
    InfeasibleError
        When the mean speed lies beyond the force curves.
    """
    train = trip.train
    top_kmh = min(reference.top_mps * KMH_PER_MPS, TOP_KMH)
    mean_kmh = trip.distance_m / reference.running_time_s * KMH_PER_MPS
    if mean_kmh >= top_kmh:
        raise InfeasibleError(
            f"{_name(trip, steps)}: a mean of {mean_kmh:.4g} km/h is beyond the force curves of the demand model, "
            f"which end at {TOP_KMH:g} km/h: take a longer running time"
        )
    params: dict[str, Any] = {
        "kind": "demand", "N": steps, "dt_s": reference.running_time_s / steps, "notches": _NOTCHES,
        "mass_kg": train.mass_kg, "rot": train.rotating_mass_factor,
        "davis_SI": [train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2], "vmax_kmh": top_kmh,
        "D_m": trip.distance_m, "tol_m": _DISTANCE_TOLERANCE * trip.distance_m, "v_end_max_mps": _END_SPEED_MPS,
        "P_max_W": _P_MAX_W, "cost_ref_kmh": TOP_KMH, "alpha": _alpha(trip),
    }  # fmt: skip
    gradients = _within(trip, [(row.position_m, row.gradient_permil) for row in trip.track.gradients])
    curves = _within(trip, [(row.position_m, _radius_m(*row[1:])) for row in trip.track.curves])
    if any(permil for _, permil in gradients):
        params["gradients_permil"] = gradients
    if any(radius is not None for _, radius in curves):
        params["curves_m"] = curves
    middle = 0.5 * top_kmh / KMH_PER_MPS
    losses = (
        "efforts of the train: those of the demand formulation stand for them, traction "
        f"{float(traction_n(0.0)) / KILO:.0f} kN for {train.traction_limit.effort_n(0.0) / KILO:.0f} kN at standstill "
        f"and {float(traction_n(middle)) / KILO:.0f} kN for {train.traction_limit.effort_n(middle) / KILO:.0f} kN at "
        f"{0.5 * top_kmh:.0f} km/h, braking {float(braking_n(middle)) / KILO:.0f} kN there and none at standstill",
        f"{100.0 * _DISTANCE_TOLERANCE:.0f} % of the distance, and the last {_END_SPEED_MPS:g} m/s: demands of ±1/2 and"
        " ±1 meet neither exactly",
        "energy of the train: the cost map stands for it",
        *([] if top_kmh < TOP_KMH else [f"speeds above {TOP_KMH:g} km/h, where the curves end"]),
        *_places(trip, top_kmh),
    )
    return TripInstance({"id": _name(trip, steps), "params": params, "notes": list(losses)}, losses)


def _name(trip: Trip, steps: int) -> str:
    return f"{trip.train.name} on {trip.track.name}, {counted(steps, 'step')}"


def _alpha(trip: Trip) -> float:
    train = trip.train
    return train.traction_efficiency * train.regeneration_efficiency if trip.energy.kind == "pantograph" else 0.0


def _within(trip: Trip, rows: Sequence[tuple[float, Any]]) -> list[tuple[float, Any]]:
    """Rows of a property of the line from the origin to the destination, by the distance from the origin."""
    inside = [(at - trip.origin_m, value) for at, value in rows if trip.origin_m < at < trip.destination_m]
    before = [(0.0, value) for at, value in rows if at <= trip.origin_m]
    return before[-1:] + inside


def _radius_m(start_m: float, end_m: float) -> float | None:
    """Radius of the mean curvature of a stretch; None where it is straight."""
    curvature = 0.5 * (abs(1.0 / start_m) + abs(1.0 / end_m))
    return 1.0 / curvature if curvature else None


def _resistance(trip: Trip, reference: Reference) -> Iterator[str]:
    mean_mps = trip.distance_m / reference.running_time_s
    work_j = trip.train.resistance_n(mean_mps) * trip.distance_m
    if work_j:
        yield (
            f"running resistance: about {work_j / JOULE_PER_KWH:.3g} kWh at the mean speed, where the best run takes "
            f"{reference.energy_j / JOULE_PER_KWH:.3g} kWh at the wheel"
        )


def _slopes(trip: Trip) -> Iterator[str]:
    permil = [
        value for _, value in _within(trip, [(row.position_m, row.gradient_permil) for row in trip.track.gradients])
    ]
    if any(permil):
        yield f"gradients, {min(permil):+.3g} to {max(permil):+.3g} ‰"
    radii = [radius for row in trip.track.curves if (radius := _radius_m(*row[1:])) is not None]
    if radii:
        yield f"curves, radii from {min(radii):.4g} m on"


def _places(trip: Trip, top_kmh: float) -> Iterator[str]:
    """What holds at places of the line, which models with steps of time do not know."""
    track = trip.track
    limits = _within(trip, [(row.position_m, row.speed_mps * KMH_PER_MPS) for row in track.speed_limits])
    least_kmh = min(limit for _, limit in limits)
    if least_kmh < top_kmh * (1.0 - 1e-9):
        yield f"speed limits by place, from {least_kmh:.4g} km/h on: {top_kmh:.4g} km/h hold everywhere"
    for what, rows in (("tunnels", track.tunnels), ("neutral sections", track.neutral_sections)):
        count = sum(
            trip.origin_m < row.position_m + row.length_m and row.position_m < trip.destination_m for row in rows
        )
        if count:
            yield f"{what}: {count}"
    passed = sum(trip.origin_m < stop < trip.destination_m for stop in track.stops_m)
    if passed:
        yield f"stops on the way, which are passed: {passed}"
    if trip.energy.kind == "pantograph" and trip.train.auxiliary_power_w:
        yield f"auxiliary power: {trip.train.auxiliary_power_w / KILO:.4g} kW"
