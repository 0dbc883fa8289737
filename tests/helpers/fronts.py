"""Fronts of the front method in one call, and what every front must be."""

import math

import numpy as np
import pytest
from hypothesis import strategies as st

from tests.helpers.twins.brute_force import least_costs
from tests.helpers.twins.trips import random_trip
from tgvdp.errors import InfeasibleError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of


def counters():
    """What meshes and fronts count in."""
    return {"extremals": 0, "runs": 0, "costates": 0}


def front_at(trip, target_s, tolerance_s=None):
    fastest = fastest_run(trip)
    return optimal_front(trip, fastest, np.asarray(target_s, dtype=float), SearchBudget(), tolerance_s)


def front_to(trip, margin, points):
    fastest = fastest_run(trip)
    targets = fastest.duration_s * np.linspace(1, 1 + margin, points)
    return fastest, optimal_front(trip, fastest, targets, SearchBudget())


def check_front(trip, margin, points):
    """What holds for every front; returns it."""
    fastest, found = front_to(trip, margin, points)
    seconds, joules = found.duration_s, found.energy_j
    assert 1 <= len(seconds) <= points
    assert seconds[0] == pytest.approx(fastest.duration_s, rel=1e-9)
    assert (np.diff(seconds) > 0.0).all()
    scale_j = max(joules[0], 1e-2 * 0.5 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2)
    # A blend may cost this share of energy more than is foretold, next to a jump also more than a faster one.
    assert (np.diff(joules) <= 5e-5 * scale_j).all()
    step_s = fastest.duration_s * margin / (points - 1)
    assert seconds[-1] <= fastest.duration_s * (1.0 + margin) + 0.05 * step_s
    for index in {0, len(seconds) // 2, len(seconds) - 1}:
        profile = profile_of(trip, *found.rows(index))
        verdict = replay(trip, profile)
        assert verdict.ok, (index, verdict)
        # To rounding, but where a train slows down under traction across a drop of it within one row.
        assert profile.duration_s == pytest.approx(seconds[index], rel=1e-9)
        assert profile.total_energy_j == pytest.approx(joules[index], rel=1e-9, abs=1e-9 * scale_j)
    return fastest, found


def cheapest_above_grid(trip, margin=1.0):
    """How far E + λT of the front lies above that of a plain grid at the same time, at worst, as a share of it."""
    fastest, found = check_front(trip, margin, 60)
    scale_j = found.energy_j[0] + 5e-3 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
    prices = scale_j / fastest.duration_s * np.exp([1.5, 0.5, -0.5, -1.5, -3.0])
    worst = -math.inf
    for price, (seconds, joules) in zip(prices, least_costs(trip, fastest, prices), strict=True):
        if seconds <= fastest.duration_s * (1.0 + margin):
            run = front_at(trip, [max(seconds, fastest.duration_s)])
            above_j = run.energy_j[-1] - joules + price * (run.duration_s[-1] - seconds)
            worst = max(worst, above_j / (max(joules, 0.1 * scale_j) + price * seconds))
    return worst


feasible_seeds = st.integers(10_000, 10**9)


def feasible_trip(seed):
    trip = random_trip(seed)
    if trip is None:
        return None
    try:
        fastest_run(trip)
    except InfeasibleError:
        return None
    return trip
