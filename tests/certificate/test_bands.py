"""Bounds of potentials with kinks that are curved besides: valid for any costates, and tight where brakes change."""

import math

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.descents import descent_trip
from benchmarks.proof.trips import proof_trip
from tests.helpers.bound_case import costs_of, random_bound
from tests.helpers.brake_case import CUTS_OUT, DROPS, HILLY, LEVEL, metro
from tests.helpers.twins.trips import random_trip
from tgvdp.certificate import sampled
from tgvdp.certificate.banded import banded, bounded, kinks_of
from tgvdp.certificate.bands import Potential
from tgvdp.certificate.interior import Progress
from tgvdp.certificate.line import BoundingProblem
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.energy import EnergyModel
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run

#: Trips of the survey that brake fully through a speed below which rates are larger: gaps were 2.1, 1.4 and 0.55 %.
STEPPED = ((1795390848, 0.1), (1795390904, 0.1), (1795391116, 0.1))
#: Brakes that begin, or rise, at some speed: runs brake in an interval of lower speeds, too; and shares of the usual
#: multiplier. Gaps were 0.6 to 3.3 % with a kink whose sides were raised by turns, and 3 to 7 % without.
RISES = ((0.0, 0.0), (9.5, 0.0), (10.5, 150e3), (14.0, 150e3), (22.0, 95e3))
LOW_RISE = ((0.0, 0.0), (6.0, 0.0), (10.0, 150e3), (14.0, 150e3), (22.0, 95e3))
BEGINS = ((0.0, 0.0), (8.5, 0.0), *((float(v), 8.5 * 150e3 / float(v)) for v in np.linspace(8.5, 22.0, 12)))


def shaken(potential, rng, size):
    """A potential with other costates of all bands, and about as steep at the speed of a run."""
    count, bands = potential.left.shape
    noise = np.repeat(rng.normal(0.0, size, (count // 20 + 1, bands)), 20, axis=0)[:count]
    bow = potential.bow + np.repeat(rng.normal(0.0, 0.1 * size, count // 20 + 1), 20)[: count + 1]
    bow[[0, 1, -2, -1]] = 0.0
    return potential._replace(left=potential.left + noise, right=potential.right + noise, bow=bow)


def same_in_all(found, kinks_w):
    edges = np.concatenate(([0.0], kinks_w, [math.inf]))
    left, right = (side[:, np.newaxis].repeat(len(edges) - 1, axis=1) for side in (found.left, found.right))
    return Potential(edges, left, right, np.zeros(len(found.w)))


@pytest.mark.parametrize("seed", [*range(10), 40, 57])
def test_whatever_the_costates_of_all_bands_no_run_lies_below(seed):
    fastest, problem, price, found, least_j = random_bound(seed)
    rng = np.random.default_rng(seed)
    multiplier = problem.total(price) / problem.train.inertia_kg
    for kinks in (1, 2):
        kinks_w = np.sort(rng.uniform(0.2, 0.9, kinks) * fastest.speed_mps.max()) ** 2
        same = same_in_all(found, kinks_w)
        same_j = problem.line_j(bounded(problem, found, multiplier, same)[0])  # no kink at all
        assert same_j == pytest.approx(problem.line_j(found), abs=2e-3 * least_j)
        assert same_j <= least_j * (1.0 + 1e-6)
        for size in (1e-3, 1e-2, 0.05):
            ledger = bounded(problem, found, multiplier, shaken(same, rng, size))[0]
            assert problem.line_j(ledger) <= least_j * (1.0 + 1e-6)


@pytest.mark.parametrize("track", [LEVEL, HILLY], ids=["level", "hilly"])
@pytest.mark.parametrize("points", [CUTS_OUT, DROPS, RISES, BEGINS], ids=["cuts out", "drops", "rises", "begins"])
def test_no_run_lies_below_the_best_bound_and_it_is_better(points, track):
    trip = tgvdp.search(metro(points), track, points=2, energy="pantograph").trip
    fastest, problem, price = fastest_run(trip), BoundingProblem(trip), 1e5
    least_j = min(costs_of(trip, fastest, problem, price))
    found = problem.ledger(fastest.position_m, fastest.speed_mps**2, price)
    multiplier = problem.total(price) / problem.train.inertia_kg
    best = banded(problem, found, price, 1e-5 * least_j)
    assert problem.line_j(found) < problem.line_j(best) <= least_j * (1.0 + 1e-6)
    same, rng = same_in_all(found, kinks_of(problem, found)), np.random.default_rng(1)
    for size in (1e-3, 1e-2):
        ledger = bounded(problem, found, multiplier, shaken(same, rng, size))[0]
        assert problem.line_j(ledger) <= least_j * (1.0 + 1e-6)


@pytest.mark.parametrize(
    ("points", "track", "share", "most"),
    [
        (RISES, LEVEL, 0.7, 1e-3),
        (RISES, HILLY, 0.3, 3e-3),
        (LOW_RISE, LEVEL, 0.15, 5e-3),
        (BEGINS, LEVEL, 0.15, 5e-4),
    ],
)
def test_gaps_where_the_dynamic_brake_works_in_an_interval(points, track, share, most):
    trip = Trip(
        train=metro(points), track=track, origin_m=0.0, destination_m=track.length_m, energy=EnergyModel("pantograph")
    )
    mesh, problem = Mesh.of(trip, fastest_run(trip)), BoundingProblem(trip)
    multiplier = share * mesh.usual_multiplier
    run = mesh.optimal_run(multiplier, {"extremals": 0, "runs": 0, "costates": 0})
    cost_j, price = run.energy_j + multiplier * run.time_s, multiplier - problem.energy.auxiliary_w
    found = problem.ledger(run.x_m.copy(), run.w.copy(), price, gain_j=1e-5 * cost_j)
    assert problem.line_j(found) < (1.0 - 0.02) * cost_j
    assert (1.0 - most) * cost_j < problem.line_j(banded(problem, found, price, 1e-5 * cost_j)) < cost_j


@pytest.mark.parametrize(
    ("drawn", "multiplier", "fewer_kinks_mps", "all_kinks_mps"),
    [
        (proof_trip(1990222), 1.5e6, [], [9.803, 16.096, 16.944, 25.804]),
        (proof_trip(2010020), 474e3, [2.238, 13.004], [2.238, 8.930, 13.004]),
        (descent_trip(2012003), 20e3, [], [14.586]),
    ],
    ids=["traction drops: a freight train of gears", "rates rise", "the load slows by more than the rate"],
)
def test_kinks_that_take_more_time(drawn, multiplier, fewer_kinks_mps, all_kinks_mps):
    """Below a drop a train pulls with a third more, wherever it is; below a rise it brakes with a third of the rate."""
    trip = tgvdp.search(drawn.train, drawn.track, points=2, **drawn.options).trip
    mesh, problem = Mesh.of(trip, fastest_run(trip)), BoundingProblem(trip)
    run = mesh.optimal_run(multiplier, {"extremals": 0, "runs": 0, "costates": 0})
    cost_j, price = run.energy_j + multiplier * run.time_s, multiplier - problem.energy.auxiliary_w
    found = problem.ledger(run.x_m.copy(), run.w.copy(), price, gain_j=1e-5 * cost_j)
    fewer = banded(problem, found, price, 1e-5 * cost_j, of_all=False)
    assert problem.line_j(fewer) < (1.0 - 1e-3) * cost_j
    assert (fewer is found) == (not fewer_kinks_mps)
    assert (1.0 - 5e-4) * cost_j < problem.line_j(banded(problem, found, price, 1e-5 * cost_j)) < cost_j
    assert np.sqrt(kinks_of(problem, found, of_all=False)) == pytest.approx(fewer_kinks_mps, abs=1e-3)
    assert np.sqrt(kinks_of(problem, found)) == pytest.approx(all_kinks_mps, abs=1e-3)


@pytest.mark.parametrize(("seed", "most_pct"), STEPPED)
def test_gaps_of_trips_whose_rates_drop_with_speed(seed, most_pct):
    trip = proof_trip(seed)
    gap_pct = tgvdp.search(trip.train, trip.track, points=12, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < most_pct


def kinks_mps(problem, found):
    return np.sqrt(kinks_of(problem, found)).tolist()


def test_there_are_kinks_only_where_efforts_jump():
    trip = proof_trip(1795390848)
    result = tgvdp.search(trip.train, trip.track, points=4, **trip.options)
    problem, profile = BoundingProblem(result.trip), result.profile(2)
    found = problem.ledger(profile.position_m, profile.speed_mps**2, 3e6)
    assert kinks_mps(problem, found) == pytest.approx([6.89525223, 16.08323111])
    level = BoundingProblem(random_trip(1))
    fastest = fastest_run(level.trip)
    found = level.ledger(fastest.position_m - level.trip.origin_m, fastest.speed_mps**2, 1e5)
    assert kinks_mps(level, found) == []
    assert banded(level, found, 1e5, 1.0) is found


@pytest.mark.parametrize(
    ("points", "at_mps"), [(CUTS_OUT, [2.2]), (DROPS, [15.4]), (RISES, [9.5, 10.5]), (LOW_RISE, [6.0, 10.0])]
)
def test_where_the_dynamic_brake_begins_jumps_and_has_risen(points, at_mps):
    trip = tgvdp.search(metro(points), LEVEL, points=2, energy="pantograph").trip
    fastest, problem = fastest_run(trip), BoundingProblem(trip)
    found = problem.ledger(fastest.position_m, fastest.speed_mps**2, 1e5)
    assert kinks_mps(problem, found) == pytest.approx(at_mps)


def test_no_step_is_begun_that_would_not_end_in_time(monkeypatch):
    """Of 4 s each two steps end within 10 s; the third one was begun at 8 s."""
    trip = tgvdp.search(metro(RISES), LEVEL, points=2, energy="pantograph").trip
    fastest, problem = fastest_run(trip), BoundingProblem(trip)
    found = problem.ledger(fastest.position_m, fastest.speed_mps**2, 1e5)
    now_s = [0.0]

    def slow(*asked):
        now_s[0] += 4.0
        return Progress(1, False)

    monkeypatch.setattr(sampled, "improve", slow)
    monkeypatch.setattr(Clock, "elapsed_s", property(lambda clock: now_s[0]))
    banded(problem, found, 1e5, 1.0, Clock(0.0, 10.0))
    assert now_s == [8.0]
