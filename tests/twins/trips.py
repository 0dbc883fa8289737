"""Random trips of every kind: named by their seed, so that a failing one becomes a regression test by its number."""

import math

import numpy as np

from tgvdp.errors import InputError
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
