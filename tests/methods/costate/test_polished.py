"""Points of surveys that were too dear: next to nothing is left of what a polish saved. Each is named by its cause."""

import pytest

import tgvdp
from benchmarks.proof.descents import descent_trip
from benchmarks.proof.survey import gain_pct
from benchmarks.proof.trips import proof_trip

#: How a trip is drawn, its seed, points of the front, the point, and what it could save in percent.
CASES = {
    "held short of a summit from which a limit is coasted to": (proof_trip, 1795403613, 12, 1, 0.077),
    "a drag that takes the speed within a cell": (descent_trip, 1108, 10, 2, 0.154),
    "the same, on a summit": (proof_trip, 1799000464, 12, 10, 0.174),
    "speeds that are held come to from far": (descent_trip, 1035, 10, 9, 0.065),
    "above the curve of the dynamic brake to a stop": (descent_trip, 1119, 10, 6, 0.437),
    "the same, below its corner": (descent_trip, 1003, 10, 4, 0.074),
    "friction along the curve of the dynamic brake": (descent_trip, 1073, 10, 6, 0.084),
    "braked before the limit of a descent was reached": (descent_trip, 1071, 10, 1, 0.081),
}
_LEFT_PCT = 0.03


@pytest.mark.parametrize("name", CASES)
def test_a_polish_saves_next_to_nothing(name):
    draw, seed, points, index, saved_pct = CASES[name]
    trip = draw(seed)
    result = tgvdp.search(trip.train, trip.track, points=points, **trip.options)
    profiles = [result.profile(i) for i in range(index + 1)]
    assert gain_pct(result, profiles, index) <= min(_LEFT_PCT, 0.5 * saved_pct)


def test_a_train_does_not_pass_a_drop_of_traction_that_holds_it():
    """One row of 186 m led to a speed that it could not reach: the replay was 5 ms off."""
    trip = proof_trip(1799000034)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    replayed_ms = [
        10.0 * verdict.time_error_pct * time_s
        for verdict, time_s in zip(result.verify(), result.front.time_s, strict=True)
    ]
    assert max(map(abs, replayed_ms)) <= 1.0


def test_brakes_in_full_end_on_the_envelope_by_all_of_their_rows():
    """Rows in which the comfort limit begins to bind brake a little less; the last one alone made up for it."""
    trip = proof_trip(1802000342)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    assert all(verdict.ok for verdict in result.verify())
