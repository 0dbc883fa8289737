"""Random trips: four kinds of trains as they run, and contrived ones. Each is named by its seed.

All have a run by their making: what a train must climb, brake for or roll through is drawn from what it can. What is
refused here, or ends in an error, is a fault.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, NeutralSection, SpeedLimit, Track
from tgvdp.model.train import BrakingRate, Train
from tgvdp.units import KMH_PER_MPS

_MPS_PER_KMH = 1.0 / KMH_PER_MPS
#: Effort of a climbing train that its gradients may ask for, and of its brakes on the way down, as shares.
_CLIMBING, _DESCENDING = 0.75, 0.7
#: Speed at which a train must still climb, m/s, or this share of its top speed.
_CLIMBING_MPS, _CLIMBING_SHARE = 12.0, 0.35


class Kind(NamedTuple):
    """Ranges of one kind of train and line: (least, most), drawn evenly; the length of the line by its logarithm."""

    mass_t: tuple[float, float]
    start_mps2: tuple[float, float]
    corner_kmh: tuple[float, float]
    top_kmh: tuple[float, float]
    rolling_permil: tuple[float, float]
    davis_b: tuple[float, float]
    davis_c: tuple[float, float]
    brake_mps2: tuple[float, float]
    comfort_mps2: tuple[float, float]
    length_km: tuple[float, float]
    slow_kmh: float
    limit_every_km: tuple[float, float]


KINDS = {
    "metro": Kind(
        (100, 300), (0.7, 1.3), (25, 50), (65, 110), (1.0, 2.5), (20, 120), (3, 10), (0.5, 1.3), (0.8, 1.3),
        (0.5, 15), 35, (0.2, 2),
    ),
    "regional": Kind(
        (80, 400), (0.4, 1.1), (35, 80), (100, 200), (0.8, 2.0), (20, 150), (4, 11), (0.4, 1.1), (0.5, 1.0),
        (2, 100), 50, (0.3, 8),
    ),
    "high-speed": Kind(
        (350, 950), (0.3, 0.7), (80, 160), (200, 360), (0.6, 1.2), (40, 280), (5, 11), (0.35, 1.0), (0.4, 0.7),
        (15, 300), 80, (1, 25),
    ),
    "freight": Kind(
        (500, 3000), (0.08, 0.3), (20, 60), (70, 120), (0.9, 2.2), (40, 450), (12, 50), (0.3, 0.6), (0.25, 0.6),
        (5, 300), 40, (0.5, 20),
    ),
    "contrived": Kind(
        (0.1, 10000), (0.15, 2.5), (5, 200), (30, 500), (0.0, 6.0), (0, 400), (0, 60), (0.2, 3.0), (0.2, 3.0),
        (0.5, 300), 10, (0.05, 30),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class ProofTrip:
    """A trip of the survey: what `tgvdp.search` takes, and what it is called in the tables."""

    seed: int
    kind: str
    feature: str
    train: Train
    track: Track
    options: dict[str, Any]


def proof_trip(seed: int) -> ProofTrip:
    """Draw the trip of a seed."""
    rng = np.random.default_rng([seed, 0x70726F6F66])
    name = str(rng.choice(list(KINDS)))
    kind = KINDS[name]
    train, shape, brakes = random_train(rng, name, kind)
    track = _track(rng, name, kind, train)
    supply = ""
    if rng.random() < 0.25:
        at_m = np.sort(rng.uniform(0.1, 0.9, rng.integers(1, 5))) * track.length_m
        track = replace(track, neutral_sections=neutral_sections(rng, train, track, at_m))
        supply = " neutral" if track.neutral_sections else ""
    energy = str(rng.choice(["wheel", "pantograph"]))
    options = {"energy": energy} | end_speeds(rng, train, track)
    return ProofTrip(seed, name, f"{shape}, {brakes}, {energy}{supply}", train, track, options)


def even(rng: np.random.Generator, span: tuple[float, float]) -> float:
    """A number of a range."""
    return float(rng.uniform(*span))


def random_train(rng: np.random.Generator, name: str, kind: Kind) -> tuple[Train, str, str]:
    mass_kg = 1e3 * even(rng, kind.mass_t)
    if name == "contrived":
        mass_kg = float(10 ** rng.uniform(2.0, 7.0))
    factor = float(rng.uniform(1.03, 1.12))
    top_mps = even(rng, kind.top_kmh) * _MPS_PER_KMH
    force_n = mass_kg * factor * even(rng, kind.start_mps2)
    corner_mps = min(even(rng, kind.corner_kmh) * _MPS_PER_KMH, 0.9 * top_mps)
    shape = str(rng.choice(list(SHAPES)))
    traction = SHAPES[shape](rng, force_n, corner_mps, top_mps)
    # Resistance leaves something to climb with at the speed that matters for it.
    most_n = 0.3 * traction.effort_n(_climbing_mps(top_mps))
    rolling_n = min(mass_kg * GRAVITY_MPS2 * even(rng, kind.rolling_permil) / 1e3, most_n)
    absent = name == "contrived" and rng.random() < 0.2
    brakes, words = _brakes(rng, mass_kg * factor * even(rng, kind.brake_mps2), traction, top_mps)
    train = Train(
        mass_kg=mass_kg,
        traction=traction,
        rotating_mass_factor=factor,
        davis_a_n=0.0 if absent else rolling_n,
        davis_b_n_per_mps=0.0 if absent else min(even(rng, kind.davis_b), 0.1 * most_n / top_mps),
        davis_c_n_per_mps2=0.0 if absent else min(even(rng, kind.davis_c), most_n / _climbing_mps(top_mps) ** 2),
        max_speed_mps=top_mps,
        max_acceleration_mps2=math.inf if rng.random() < 0.5 else even(rng, kind.comfort_mps2),
        max_deceleration_mps2=math.inf if rng.random() < 0.5 else even(rng, kind.comfort_mps2),
        traction_efficiency=float(rng.uniform(0.75, 0.92)),
        regeneration_efficiency=float(rng.choice([0.0, 0.5, 0.8, 0.9])),
        auxiliary_power_w=mass_kg * float(rng.choice([0.0, 0.1, 0.5, 1.5])),
        **brakes,
    )
    return train, shape, words


def _climbing_mps(top_mps: float) -> float:
    return min(_CLIMBING_MPS, _CLIMBING_SHARE * top_mps)


def _caps(_: np.random.Generator, force_n: float, corner_mps: float, __: float) -> EffortCurve:
    return EffortCurve.from_caps(force_n, force_n * corner_mps)


def _table(_: np.random.Generator, force_n: float, corner_mps: float, top_mps: float) -> EffortCurve:
    """A droop to the corner, then constant power, as a table every 5 km/h."""
    speeds_mps = np.arange(0.0, top_mps + 10.0, 5.0 * _MPS_PER_KMH)
    droop = 1.0 - 0.15 * np.minimum(speeds_mps / corner_mps, 1.0)
    efforts_n = force_n * np.minimum(droop, 0.85 * corner_mps / np.maximum(speeds_mps, 1e-3))
    return EffortCurve.from_points(list(zip(speeds_mps, efforts_n, strict=True)))


def _weak(rng: np.random.Generator, force_n: float, corner_mps: float, top_mps: float) -> EffortCurve:
    """Constant force, constant power, then field weakening: effort falls by the square of the speed."""
    weak_mps = corner_mps * rng.uniform(1.5, 3.0)
    speeds_mps = np.append([0.0], np.linspace(corner_mps, max(top_mps, corner_mps) + 10.0, 60))
    shares = np.ones_like(speeds_mps)
    shares[1:] = corner_mps / speeds_mps[1:] * np.minimum(1.0, weak_mps / speeds_mps[1:])
    return EffortCurve.from_points(list(zip(speeds_mps, force_n * shares, strict=True)))


def _gears(rng: np.random.Generator, force_n: float, corner_mps: float, top_mps: float) -> EffortCurve:
    """Constant power with drops of 3 to 25 % from gear to gear."""
    changes_mps = np.sort(rng.uniform(0.15, 0.9, rng.integers(1, 5))) * top_mps
    ends_mps = [0.0, *changes_mps, top_mps + 10.0]
    rows, share = [], 1.0
    for low_mps, high_mps in pairwise(ends_mps):
        for speed_mps in np.linspace(low_mps, high_mps, 5):
            rows.append((speed_mps, share * force_n * min(1.0, corner_mps / max(speed_mps, 1e-3))))
        share *= rng.uniform(0.75, 0.97)
    return EffortCurve.from_points(rows)


def _force(_: np.random.Generator, force_n: float, __: float, ___: float) -> EffortCurve:
    return EffortCurve.from_caps(force_n)


SHAPES = {"caps": _caps, "table": _table, "weak": _weak, "gears": _gears, "force": _force}


def _brakes(
    rng: np.random.Generator, brake_n: float, traction: EffortCurve, top_mps: float
) -> tuple[dict[str, Any], str]:
    """Brakes that can hold ``brake_n`` together, whatever the speed, and what they are called."""
    kind = str(rng.choice(["friction", "dynamic", "strong dynamic", "rate", "stepped rates"]))
    force_n = traction.effort_n(0.0)
    weaker = EffortCurve.from_caps(min(0.8 * force_n, brake_n), 0.9 * force_n * 0.3 * top_mps)
    if kind == "friction":
        return {"friction_brake_n": brake_n}, kind
    if kind == "dynamic":
        return {"friction_brake_n": brake_n, "braking": weaker}, kind
    if kind == "strong dynamic":
        strong = EffortCurve.from_caps(brake_n, brake_n * 0.5 * top_mps)
        return {"friction_brake_n": 0.6 * brake_n, "braking": strong}, kind
    rates = [BrakingRate(0.0, float(rng.uniform(0.3, 1.2)))]
    if kind == "stepped rates":
        for low, high in ((0.1, 0.3), (0.35, 0.6), (0.65, 0.9)):
            if rng.random() < 0.7:
                rate = float(np.clip(rates[0].deceleration_mps2 * 10 ** rng.uniform(-0.6, 0.5), 0.15, 2.5))
                rates.append(BrakingRate(float(rng.uniform(low, high) * top_mps), rate))
    return {"friction_brake_n": brake_n, "braking": weaker, "braking_rates": tuple(rates)}, kind


def _track(rng: np.random.Generator, name: str, kind: Kind, train: Train) -> Track:
    length_m = 1e3 * float(np.exp(rng.uniform(*np.log(kind.length_km))))
    top_mps = train.max_speed_mps
    limits = random_limits(rng, kind, top_mps, length_m)
    if name == "contrived" and rng.random() < 0.3:
        limits = limits[:1]
    return Track(
        length_m=length_m, speed_limits=tuple(limits), gradients=_gradients(rng, train, length_m, name == "contrived")
    )


def random_limits(rng: np.random.Generator, kind: Kind, top_mps: float, length_m: float) -> list[SpeedLimit]:
    """Speed limits along a line, of which four in ten are the train's own."""
    limits, x_m = [], 0.0
    while x_m < length_m:
        slow = rng.random() < 0.6
        kmh = max(5.0 * round(rng.uniform(kind.slow_kmh, top_mps / _MPS_PER_KMH) / 5.0), 10.0)
        limits.append(SpeedLimit(x_m, kmh * _MPS_PER_KMH if slow else top_mps))
        x_m += 1e3 * even(rng, kind.limit_every_km)
    return limits


def _gradients(rng: np.random.Generator, train: Train, length_m: float, contrived: bool) -> tuple[Gradient, ...]:
    """Gradients that wander, or in contrived lines jump, within what the train can climb and hold."""
    steep = float(rng.choice([0.0, 5.0, 12.0, 25.0, 40.0]))
    if steep == 0.0:
        return ()
    up = min(steep, climbable_permil(train))
    down = min(steep, holdable_permil(train))
    every_m = float(rng.choice([150.0, 400.0, 1000.0, 2500.0]))
    rows, x_m, permil = [], 0.0, 0.0
    while x_m < length_m:
        wander = rng.uniform(-down, up) if contrived else 0.5 * permil + rng.normal(0.0, 0.5 * steep)
        permil = 0.0 if rng.random() < 0.15 else float(np.clip(wander, -down, up))
        rows.append(Gradient(x_m, round(permil, 2)))
        x_m += every_m if contrived else float(rng.exponential(every_m)) + 20.0
    return tuple(rows)


def climbable_permil(train: Train) -> float:
    """Gradient that a share of the effort holds at the speed at which a train must still climb, ‰."""
    speed_mps = _climbing_mps(train.max_speed_mps)
    spare_n = _CLIMBING * train.traction.effort_n(speed_mps) - train.resistance_n(speed_mps)
    return float(max(1e3 * spare_n / (train.mass_kg * GRAVITY_MPS2), 0.0))


def holdable_permil(train: Train) -> float:
    """Gradient that a share of the friction brake holds, ‰."""
    return _DESCENDING * 1e3 * train.friction_brake_n / (train.mass_kg * GRAVITY_MPS2)


def _net_mps2(train: Train, track: Track) -> tuple[float, float]:
    """Acceleration and deceleration that remain on the steepest gradients of a line, at the climbing speed, m/s²."""
    permil = [row.gradient_permil for row in track.gradients] or [0.0]
    speed_mps = _climbing_mps(train.max_speed_mps)
    pull_n = train.traction.effort_n(speed_mps) - train.resistance_n(speed_mps)
    weight_n = train.mass_kg * GRAVITY_MPS2 / 1e3
    rises = (pull_n - weight_n * max(permil)) / train.inertia_kg
    falls = (train.friction_brake_n + weight_n * min(permil)) / train.inertia_kg
    if train.braking_rates:
        falls = min(row.deceleration_mps2 for row in train.braking_rates)
    return min(rises, train.max_acceleration_mps2), min(falls, train.max_deceleration_mps2)


def end_speeds(rng: np.random.Generator, train: Train, track: Track) -> dict[str, float]:
    """Speeds at the ends: one from which the train can brake for what follows, and one that it can reach."""
    rises, falls = _net_mps2(train, track)
    found = {}
    if rng.random() < 0.25:
        braked = [row.speed_mps**2 + 2.0 * falls * row.position_m for row in track.speed_limits]
        most_mps = math.sqrt(min(*braked, 2.0 * falls * track.length_m, train.max_speed_mps**2))
        found["start_speed_mps"] = most_mps * float(rng.uniform(0.1, 0.9))
    if rng.random() < 0.25:
        reached = 0.5 * 2.0 * rises * (track.length_m - track.speed_limits[-1].position_m)
        most_mps = min(math.sqrt(reached), track.speed_limits[-1].speed_mps, _climbing_mps(train.max_speed_mps))
        found["end_speed_mps"] = most_mps * float(rng.uniform(0.1, 0.9))
    return found


def neutral_sections(
    rng: np.random.Generator, train: Train, track: Track, at_m: NDArray[np.float64]
) -> tuple[NeutralSection, ...]:
    """Sections from increasing positions on that a train rolls through at a speed that it has reached before."""
    rises, _ = _net_mps2(train, track)
    slowest_mps = min([row.speed_mps for row in track.speed_limits])
    speed_mps = min(slowest_mps, _climbing_mps(train.max_speed_mps))
    permil = max([row.gradient_permil for row in track.gradients] or [0.0])
    loss_mps2 = train.resistance_n(speed_mps) / train.inertia_kg + GRAVITY_MPS2 * max(permil, 0.0) / 1e3
    reached_m = speed_mps**2 / (2.0 * rises)
    rolled_m = 0.3 * speed_mps**2 / (2.0 * loss_mps2) if loss_mps2 > 0.0 else math.inf
    sections: list[NeutralSection] = []
    for x_m in at_m:
        length_m = min(float(rng.choice([30.0, 100.0, 200.0, 400.0])), 0.03 * track.length_m, rolled_m)
        before_m = sections[-1].position_m + sections[-1].length_m if sections else 0.0
        if x_m > before_m + 1.5 * reached_m:
            sections.append(NeutralSection(float(x_m), length_m, bool(rng.random() < 0.5)))
    return tuple(sections)
