"""Certificates of random trips: no run that is found by any means lies below, whatever costates were improved."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.twins.trips import random_trip, with_rates
from tgvdp import TgvdpError
from tgvdp.certificate.line import BoundingProblem
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run


def search(trip, **options):
    return tgvdp.search(
        trip.train, trip.track, start_speed_mps=trip.start_speed_mps, end_speed_mps=trip.end_speed_mps, **options
    )


def runs_of(trip, fastest, multipliers):
    """Running times and energies of optimal runs on a fine mesh, and of blends of their policies with full traction."""
    mesh, counters, found = Mesh.of(trip, fastest, 8.0), {"extremals": 0, "runs": 0, "costates": 0}, []
    for multiplier in multipliers * mesh.usual_multiplier:
        policy = mesh.extremal(multiplier, counters).switch
        for share in (0.0, 0.05, 0.4):
            run = mesh.drive(policy + share * (mesh.fast[:, np.newaxis] - policy), counters)
            found.append((run.time_s, run.energy_j))
    return found


@pytest.mark.parametrize("seed", [*range(12), 40, 57])
@pytest.mark.parametrize("rates", [False, True])
def test_no_run_lies_below(seed, rates):
    trip = random_trip(seed)
    if rates:
        trip = with_rates(trip, seed)
    try:
        result = search(trip, points=8)
    except TgvdpError:
        pytest.skip("no such trip")
    certificate = result.certify()
    size_j = np.abs(result.front.energy_j).max()
    assert (result.front.energy_j >= certificate.lower_bound_j - 2e-4 * size_j).all()
    for time_s, energy_j in runs_of(result.trip, result.fastest.profile, np.array([0.3, 1.0, 4.0, 20.0])):
        assert energy_j >= certificate.at(time_s) - 2e-4 * size_j


@pytest.mark.parametrize("seed", range(0, 24, 2))
def test_whatever_an_ascent_starts_from_it_stays_below_every_run(seed):
    trip = random_trip(seed)
    try:
        fastest = fastest_run(trip)
    except TgvdpError:
        pytest.skip("no such trip")
    problem, rng = BoundingProblem(trip), np.random.default_rng(seed)
    x_m, w = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    usual = max(fastest.total_energy_j, fastest.balance.wheel_j) / fastest.duration_s
    for factor in (0.5, 5.0):
        price = factor * usual
        multiplier = problem.total(price) / problem.train.inertia_kg
        ledger = problem.ledger(x_m, w, price)
        costs = [energy_j + price * time_s for time_s, energy_j in runs_of(trip, fastest, np.array([0.5, 2.0, 5.0]))]
        for spread in (0.0, 0.1, 0.6):
            wild = ledger.left + spread * rng.normal(size=len(ledger.left))
            started = problem.evaluate(ledger, multiplier, wild, ledger.right + spread * rng.normal(size=len(wild)))
            ended = problem.ascended(started, multiplier, 1e-6 * min(costs))
            line_j = problem.train.inertia_kg * (ended.total - ended.error)
            assert started.total <= ended.total
            assert line_j <= min(costs) * (1.0 + 1e-4)


@pytest.mark.parametrize("seed", range(0, 40, 3))
@pytest.mark.parametrize("rates", [False, True])
def test_no_run_is_as_fast_as_the_fastest_one(seed, rates):
    """What the bound at its running time rests on: its speeds are those that no run passes."""
    trip = random_trip(seed)
    if rates:
        trip = with_rates(trip, seed)
    try:
        fastest = fastest_run(trip)
    except TgvdpError:
        pytest.skip("no such trip")
    problem = BoundingProblem(trip)
    (ahead_m, ahead_w), (back_m, back_w) = problem._speed_bounds
    x_m = np.unique(np.concatenate((ahead_m, trip.distance_m - back_m, problem.cells.station_m)).clip(0.0))
    x_m = x_m[x_m <= trip.distance_m]
    cell = np.searchsorted(problem.cells.station_m, 0.5 * (x_m[1:] + x_m[:-1]), side="right") - 1
    bound_w = np.minimum(np.interp(x_m, ahead_m, ahead_w), np.interp(trip.distance_m - x_m, back_m, back_w))
    v0, v1 = (np.sqrt(np.minimum(w, problem.cells.limit_w[cell])) for w in (bound_w[:-1], bound_w[1:]))
    least_s = float(np.sum(2.0 * np.diff(x_m) / (v0 + v1)))
    assert least_s <= fastest.duration_s * (1.0 + 1e-6)
    assert fastest.duration_s <= least_s * (1.0 + 2e-4)
