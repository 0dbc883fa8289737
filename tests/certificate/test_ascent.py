"""Ascent of the certificate's costates: its derivatives, where it ends, and that no bound rises above a run."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.bound_case import filled
from tests.helpers.trips import commuter, trip_on
from tgvdp.certificate import line
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.slopes import BRAKES, BY_P, BY_SLOPE, DYNAMIC, PULL
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.runs.fastest import fastest_run

TRIP = trip_on(
    [(0, 30), (3000, 20)],
    [(0, 0), (2000, 8), (4000, -6)],
    length_m=6000.0,
    start_speed_mps=10.0,
    end_speed_mps=12.0,
)


def test_derivatives_against_differences():
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, 2e5)
    multiplier = 2e5 / problem.train.inertia_kg
    rng = np.random.default_rng(1)
    left = -rng.uniform(0.05, 0.95, len(ledger.left))
    right = np.append(left[1:], -0.3) + 0.01  # jumps down, so that costates at both sides count
    total, slopes = filled(problem, ledger, multiplier, left, right)
    assert total == pytest.approx(problem.evaluate(ledger, multiplier, left, right).total, rel=1e-12)
    for k in range(1, len(left) - 1, 7):
        d = ledger.cells.length_m[k]
        cross = 0.5 * (slopes[k, 0, BY_SLOPE] + slopes[k, 1, BY_SLOPE])
        by_left = 0.5 * d * slopes[k, 0, BY_P] - cross + ledger.caps.node[k]
        step = np.zeros_like(left)
        step[k] = 1e-7
        up, down = (filled(problem, ledger, multiplier, left + sign * step, right)[0] for sign in (1.0, -1.0))
        low, high = sorted((up - total, total - down))
        assert low - 1e-5 <= 1e-7 * by_left <= high + 1e-5


def test_the_slope_steps_down_at_levels_by_the_effort_that_changes():
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, 2e5)
    multiplier = 2e5 / problem.train.inertia_kg
    for level, column in ((-0.5, PULL), (0.0, DYNAMIC)):
        sides = []
        for shift in (-1e-9, 1e-9):
            p = np.full(len(ledger.left), level + shift)
            sides.append(filled(problem, ledger, multiplier, p, p)[1][5:-5])
        below, above = sides
        drop = below[:, 0, BY_P] - above[:, 0, BY_P]
        np.testing.assert_allclose(drop, 2.0 * below[:, 0, column], rtol=1e-5, atol=1e-7)
        assert (below[:, 0, BRAKES] >= below[:, 0, DYNAMIC]).all()


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_ascent_mends_costates_that_are_a_fifth_off_and_never_rises_above_a_run(energy):
    train = commuter(traction_efficiency=0.9, regeneration_efficiency=0.7)
    result = tgvdp.search(train, TRIP.track, start_speed_mps=10.0, end_speed_mps=12.0, points=8, energy=energy)
    problem = BoundingProblem(result.trip)
    point, price = 4, result.price_kwh_per_min[4] * 6e4
    time_s, energy_j = result.front.time_s[point], result.front.energy_j[point]
    profile = result.profile(point)
    multiplier = problem.total(price) / problem.train.inertia_kg
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, price)
    poor = problem.evaluate(ledger, multiplier, 0.8 * ledger.left, 0.8 * ledger.right)
    good = problem.ascended(poor, multiplier, 1e-6 * energy_j)
    poor_pct, good_pct = (
        100.0 * (1.0 - (problem.train.inertia_kg * (found.total - found.error) - price * time_s) / energy_j)
        for found in (poor, good)
    )
    assert poor_pct > 5.0
    assert -1e-4 < good_pct < 0.1


def test_an_ascent_looks_at_the_clock_between_its_steps(monkeypatch):
    """Where time ends it keeps what it has gained; without a break between the steps it gains as much as in one go."""
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, 2e5)
    multiplier = 2e5 / problem.train.inertia_kg
    poor = problem.evaluate(ledger, multiplier, 0.8 * ledger.left, 0.8 * ledger.right)
    whole = problem.ascended(poor, multiplier, 1.0)
    monkeypatch.setattr(line, "_CELLS_AT_ONCE", 1)
    clock = SearchBudget(time_limit_s=math.inf).start()
    assert problem.ascended(poor, multiplier, 1.0, clock).total == whole.total
    looks = iter([False] * 2 + [True])
    monkeypatch.setattr(Clock, "expired", property(lambda clock: next(looks)))
    assert poor.total < problem.ascended(poor, multiplier, 1.0, clock).total < whole.total


def test_an_ascent_that_goes_wrong_leaves_the_bound_as_it_was():
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, 2e5)
    multiplier = 2e5 / problem.train.inertia_kg
    lost = problem.evaluate(ledger, multiplier, np.full_like(ledger.left, math.nan), ledger.right)
    assert problem.ascended(lost, multiplier, 1.0) is lost


def test_an_ascent_ends_where_there_is_enough():
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    start = problem.ledger(profile.position_m, profile.speed_mps**2, 2e5)
    multiplier, size_j = 2e5 / problem.train.inertia_kg, abs(problem.line_j(start))
    start = problem.evaluate(start, multiplier, np.full_like(start.left, -0.2), np.full_like(start.left, -0.2))
    best_j = problem.line_j(problem.ascended(start, multiplier, 1e-7 * size_j))
    enough_j = 0.5 * (problem.line_j(start) + best_j)
    ended_j = problem.line_j(problem.ascended(start, multiplier, 1e-7 * size_j, enough_j=enough_j))
    assert enough_j <= ended_j < best_j
