"""Trips of the survey whose gaps came of the certificate, not of their runs: each stands for one cause."""

import math

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.trips import commuter, trip_on
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.line_maker import least_cost_j
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run

#: Next to its costate the minimum of a cell jumps from one speed to another: steps of the ascent must end there.
KINKS = (1795378258, 1795377782)
#: The costates are the best ones, so that ascent is in vain, and the cells too long.
LONG_CELLS = (1795378401, 1795377884)
#: Drag slows the train so much that a costate from the start of coasting means nothing at its end: it was −10³³, and
#: there were no lines where time is cheap (12.7 %).
SLOWED = (1909000075,)


@pytest.mark.parametrize("seed", [*KINKS, *LONG_CELLS, *SLOWED])
def test_gaps_of_trips_that_the_ascent_had_left_open(seed):
    trip = proof_trip(seed)
    gap_pct = tgvdp.search(trip.train, trip.track, points=12, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < 0.05


def test_lines_between_points_that_runs_of_multipliers_jump_over():
    """The run of a multiplier costs more than points of the front: its line cannot be as high, and others must help."""
    trip = proof_trip(1795378594)
    gap_pct = tgvdp.search(trip.train, trip.track, points=12, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < 0.2


@pytest.mark.parametrize("price_j_per_s", [1e3, 1e5])
def test_a_limit_that_brakes_keep_is_a_phase_however_cheap_time_is(price_j_per_s):
    """It was taken for coasting where time is cheap, and the costate before it grew without bound."""
    trip = trip_on([(0, 30)], [(0, 0), (6000, -25), (9000, 0)], length_m=14e3)
    fastest = fastest_run(trip)
    ledger = BoundingProblem(trip).ledger(fastest.position_m, fastest.speed_mps**2, price_j_per_s)
    middle_m = 0.5 * (ledger.cells.station_m[1:] + ledger.cells.station_m[:-1])
    held = (middle_m > 6500.0) & (middle_m < 8500.0)
    np.testing.assert_allclose(ledger.w[1:][held], 900.0, rtol=1e-6)
    assert (ledger.right[held] == 0.0).all()


def test_ascent_from_anywhere_ends_next_to_ascent_from_costates_of_a_run():
    """Kinks are in the way of either: of levels, of speed bounds, of speeds at which brakes take more power."""
    train = commuter(traction_efficiency=0.85, regeneration_efficiency=0.8)
    track = trip_on([(0, 40), (9000, 25)], [(0, 0), (3000, -22), (7000, 9)], length_m=12e3).track
    result = tgvdp.search(train, track, points=6, energy="pantograph")
    problem, profile = BoundingProblem(result.trip), result.profile(3)
    price = float(result.price_kwh_per_min[3]) * 6e4
    multiplier, size_j = problem.total(price) / train.inertia_kg, result.front.energy_j[3]
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, price)
    flat = np.full_like(ledger.left, -0.2)
    good, other = (
        problem.ascended(start, multiplier, 1e-6 * size_j).total * train.inertia_kg
        for start in (ledger, problem.evaluate(ledger, multiplier, flat, flat))
    )
    assert abs(good - other) < 1e-3 * size_j


def test_an_ascent_goes_on_while_it_gains():
    """The costates are broken to begin with: they take hundreds of steps, and 60 left 2.9 % of the energy."""
    drawn = proof_trip(1795390847)
    trip = Trip(train=drawn.train, track=drawn.track, origin_m=0.0, destination_m=drawn.track.length_m)
    fastest, multiplier_j_per_s = fastest_run(trip), 3730.0
    counts = {"extremals": 0, "runs": 0, "costates": 0}
    run = Mesh.of(trip, fastest, 4.0).optimal_run(multiplier_j_per_s, counts)
    cost_j = run.energy_j + run.multiplier * run.time_s
    clock = SearchBudget(time_limit_s=math.inf).start()
    bound_j = least_cost_j(trip, fastest, multiplier_j_per_s, run.energy_j, clock)
    assert 0.0 <= cost_j - bound_j < 0.005 * run.energy_j
