"""Bounds with a kink of the potential at one speed: valid for any costates, and tight where braking rates drop."""

import math

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.bound_case import costs_of, random_bound
from tests.helpers.brake_case import CUTS_OUT, DROPS, HILLY, LEVEL, metro
from tests.helpers.twins.trips import random_trip
from tgvdp.certificate.kinked import _Kinked, _kinks, _standing_w, kinked
from tgvdp.certificate.line import BoundingProblem
from tgvdp.runs.fastest import fastest_run

#: Trips of the survey that brake fully through a speed below which rates are larger: gaps were 2.1, 1.4 and 0.55 %.
STEPPED = ((1795390848, 0.6), (1795390904, 0.45), (1795391116, 0.3))


@pytest.mark.parametrize("seed", [*range(10), 40, 57])
def test_whatever_the_costates_on_both_sides_no_run_lies_below(seed):
    fastest, problem, price, found, least_j = random_bound(seed)
    rng = np.random.default_rng(seed)
    multiplier = problem.total(price) / problem.train.inertia_kg
    for kink_v in rng.uniform(0.2, 0.9, 3) * fastest.speed_mps.max():
        assert kink_v**2 > _standing_w(found)
        bound = _Kinked(problem, found, multiplier, kink_v**2, False, 1e-6 * least_j, None)
        same_j = problem.line_j(bound._together())  # the same costates on both sides: no kink
        assert same_j == pytest.approx(problem.line_j(found), abs=2e-3 * least_j)
        assert same_j - 1e-9 * least_j <= problem.line_j(bound.raised()) <= least_j * (1.0 + 1e-6)
        for half in ("_lower", "_upper"):
            noise = np.repeat(rng.normal(0.0, 0.05, len(found.left) // 20 + 1), 20)[: len(found.left)]
            one = getattr(bound, half)
            setattr(bound, half, bound._half(one.side, one.left + noise, one.right + noise))
            assert problem.line_j(bound._together()) <= least_j * (1.0 + 1e-6)


@pytest.mark.parametrize("track", [LEVEL, HILLY], ids=["level", "hilly"])
@pytest.mark.parametrize("points", [CUTS_OUT, DROPS], ids=["cuts out", "drops"])
def test_no_run_lies_below_where_the_dynamic_brake_jumps(points, track):
    trip = tgvdp.search(metro(points), track, points=2, energy="pantograph").trip
    fastest, problem, price = fastest_run(trip), BoundingProblem(trip), 1e5
    least_j = min(costs_of(trip, fastest, problem, price))
    found = problem.ledger(fastest.position_m, fastest.speed_mps**2, price)
    ((kink_w, cuts_out),) = _kinks(problem, found)
    assert (math.sqrt(kink_w), cuts_out) == (pytest.approx(points[2][0]), points is CUTS_OUT)
    multiplier = problem.total(price) / problem.train.inertia_kg
    bound = _Kinked(problem, found, multiplier, kink_w, cuts_out, 1e-6 * least_j, None)
    assert problem.line_j(found) < problem.line_j(bound.raised()) <= least_j * (1.0 + 1e-6)
    rng, count = np.random.default_rng(1), len(found.left)
    for half in ("_lower", "_upper"):
        one, noise = getattr(bound, half), np.repeat(rng.normal(0.0, 0.05, count // 20 + 1), 20)[:count]
        setattr(bound, half, bound._half(one.side, one.left + noise, one.right + noise))
        assert problem.line_j(bound._together()) <= least_j * (1.0 + 1e-6)


@pytest.mark.parametrize(("seed", "most_pct"), STEPPED)
def test_gaps_of_trips_whose_rates_drop_with_speed(seed, most_pct):
    trip = proof_trip(seed)
    gap_pct = tgvdp.search(trip.train, trip.track, points=12, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < most_pct


def test_there_are_kinks_only_where_rates_drop():
    trip = proof_trip(1795390848)
    result = tgvdp.search(trip.train, trip.track, points=4, **trip.options)
    problem, profile = BoundingProblem(result.trip), result.profile(2)
    found = problem.ledger(profile.position_m, profile.speed_mps**2, 3e6)
    assert list(_kinks(problem, found)) == [(pytest.approx(16.08323111**2), False)]
    level = BoundingProblem(random_trip(1))
    fastest = fastest_run(level.trip)
    found = level.ledger(fastest.position_m - level.trip.origin_m, fastest.speed_mps**2, 1e5)
    assert kinked(level, found, 1e5, 1.0) is found
