"""Random trips of every kind: named by their seed, so that a failing one becomes a regression test by its number."""

import math
from dataclasses import replace

import numpy as np

from tgvdp.errors import InputError
from tgvdp.model.convention import Convention
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip


def _traction(rng, force_n, corner_mps):
    kind = rng.integers(0, 5)
    if kind == 0:
        return EffortCurve.from_caps(force_n)
    if kind == 1:
        return EffortCurve.from_caps(force_n, force_n * corner_mps)
    if kind == 2:
        middle, end = force_n * rng.uniform(0.5, 1.0), force_n * rng.uniform(0.1, 0.5)
        return EffortCurve.from_points([(0, force_n), (corner_mps, middle), (3 * corner_mps, end), (200, force_n / 10)])
    if kind == 3:  # with two drops
        lower = force_n * rng.uniform(0.3, 0.9)
        return EffortCurve.from_points(
            [
                (0, force_n),
                (corner_mps, force_n),
                (corner_mps, lower),
                (2 * corner_mps, 0.7 * lower),
                (2 * corner_mps, 0.4 * lower),
                (200, 0.3 * lower),
            ]
        )
    return EffortCurve.from_caps(force_n, 2 * force_n * corner_mps)


def random_train(rng):
    """A train of 10 g to 10 000 t: force, power, table or dropping effort; with and without each Davis term."""
    mass = 10 ** rng.uniform(-2, 7) if rng.random() < 0.3 else 10 ** rng.uniform(4, 6.3)
    force = mass * (10 ** rng.uniform(-1, 0.7) if rng.random() < 0.2 else rng.uniform(0.2, 1.3))
    corner = rng.uniform(5, 30)
    traction = _traction(rng, force, corner)
    braking = (
        EffortCurve.from_caps(0.0),
        EffortCurve.from_caps(0.7 * force, force * corner),
        EffortCurve.from_points([(0, 0.5 * force), (corner, 0.9 * force), (200, 0.2 * force)]),
    )[rng.integers(0, 3)]
    friction = mass * rng.uniform(0.2, 1.2)
    a = mass * 10 ** rng.uniform(-3, -1)
    davis = (a, a * rng.uniform(0, 0.05), a * 10 ** rng.uniform(-4, -2.5))
    davis = np.array(davis) * ((0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 1, 1))[rng.integers(0, 4)]
    return Train(
        mass_kg=mass,
        traction=traction,
        braking=braking,
        friction_brake_n=friction,
        rotating_mass_factor=rng.choice([1.0, 1.06, 1.2]),
        davis_a_n=davis[0],
        davis_b_n_per_mps=davis[1],
        davis_c_n_per_mps2=davis[2],
        max_acceleration_mps2=rng.choice([math.inf, math.inf, 0.6]),
        max_deceleration_mps2=rng.choice([math.inf, 0.5, 0.8]),
        max_speed_mps=rng.choice([math.inf, 22.0, 40.0, 83.0]),
    )


def random_trip(seed):
    """A trip of 1 m to 1000 km, up to 40 limits, gradients up to 40 ‰, and speeds at its ends; None if not valid."""
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    length = 10 ** rng.uniform(0, 6) if rng.random() < 0.3 else 10 ** rng.uniform(2.7, 4.7)
    n_limits, n_gradients = rng.choice([0, 1, 3, 10, 40]), rng.choice([0, 0, 1, 5, 30])
    positions = np.sort(rng.uniform(0, length, n_limits))
    limits = [(0.0, rng.uniform(5, 60)), *((x, rng.uniform(3, 60)) for x in positions)]
    steepest = rng.choice([3.0, 10.0, 40.0])
    gradients = []
    if n_gradients:
        gradients = [(0.0, rng.uniform(-steepest, steepest))]
        gradients += [(x, rng.uniform(-steepest, steepest)) for x in np.sort(rng.uniform(0, length, n_gradients - 1))]
    start, end = (0.0 if rng.random() < 0.7 else rng.uniform(0, 20) for _ in range(2))
    try:
        return Trip(
            train=train,
            track=Track(length_m=length, speed_limits=tuple(limits), gradients=tuple(gradients)),
            origin_m=0.0,
            destination_m=length,
            start_speed_mps=start,
            end_speed_mps=end,
        )
    except InputError:
        return None


def level_trip(train, length_m, limit_mps=200.0, **speeds):
    """A level line with one limit."""
    track = Track(length_m=length_m, speed_limits=((0.0, limit_mps),))
    return Trip(train=train, track=track, origin_m=0.0, destination_m=length_m, **speeds)


def with_line(trip, seed, **convention):
    """The same trip with a length, curves, tunnels and neutral sections, under a convention given by its switches."""
    rng = np.random.default_rng([seed, 1])
    length = trip.track.length_m
    scale = trip.train.traction.effort_n(0.0) / trip.train.mass_kg  # stands for how hilly a line this train can run
    curves = []
    radius = math.inf
    for x in (0.0, *np.sort(rng.uniform(0, length, rng.choice([0, 2, 12])))):
        after = rng.choice([-1, 1]) * rng.uniform(200, 3000) / scale if rng.random() < 0.6 else math.inf
        curves.append((x, radius if rng.random() < 0.5 else after, after))
        radius = after
    ends = np.sort(rng.uniform(0, length, 6))
    tunnels = [(a, b - a, area) for a, b, area in zip(ends[::2], ends[1::2], (24.0, 40.0, 24.0), strict=True)]
    gaps = np.sort(rng.uniform(0, length, 2))
    neutral = [(x, 0.01 * rng.random() * (gaps[1] - gaps[0]), bool(rng.random() < 0.5)) for x in gaps]
    neutral = [(x, min(stretch, length - x), lowered) for x, stretch, lowered in neutral]
    c = trip.train.davis_c_n_per_mps2
    train = replace(
        trip.train,
        length_m=rng.choice([0.01, 0.1, 2.0]) * length,
        tunnel_drag=((24.0, c), (40.0, 0.4 * c)),
    )
    sections = tuple(neutral) if rng.random() < 0.5 else ()
    track = replace(trip.track, curves=tuple(curves), tunnels=tuple(tunnels), neutral_sections=sections)
    return replace(trip, train=train, track=track, convention=Convention(name="test", **convention))


SWITCHES = {"mass_model": ("point", "strip"), "limits": ("head", "tail"), "curves": ("none", "800/R", "roeckl")}


def random_switches(seed):
    """One value of each switch."""
    rng = np.random.default_rng([seed, 2])
    chosen = {name: str(rng.choice(values)) for name, values in SWITCHES.items()}
    return chosen | {"tunnels": bool(rng.random() < 0.5)}


def with_rates(trip, seed):
    """The same trip, in two of five cases with braking rates, half of them a table over speed."""
    rng = np.random.default_rng([seed, 3])
    if rng.random() >= 0.4:
        return trip
    rate = rng.uniform(0.2, 1.2)
    rates = [(0.0, rate)]
    if rng.random() < 0.5:
        rates += [(rng.uniform(*span), rate * rng.uniform(0.7, 1.3)) for span in ((3, 20), (21, 50))]
    return replace(trip, train=replace(trip.train, braking_rates=tuple(rates)))


def with_jumping_rates(trip, seed):
    """The same trip with braking rates that jump by up to 25 times."""
    rng = np.random.default_rng([seed, 7])
    rate = rng.uniform(0.2, 1.2)
    rates = [(0.0, rate)]
    for span in ((1, 8), (8.5, 20), (21, 50)):
        if rng.random() < 0.7:
            rates.append((rng.uniform(*span), rate * 10 ** rng.uniform(-0.7, 0.7)))
    return replace(trip, train=replace(trip.train, braking_rates=tuple(rates)))
