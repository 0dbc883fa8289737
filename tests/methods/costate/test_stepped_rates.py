"""Braking rates that depend on the speed: trips of the survey on which points once broke them."""

import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip

#: 0.8 km up 17 ‰, which slow the train down more than its brakes may: the envelope is a run that coasts, and what pulls
#: beyond it finds no brakes that bring it back.
CLIMB = 1795378265
#: A dynamic brake that passes the rate as the train slows down: the last row of a cell made up for what all lacked.
DYNAMIC_BRAKE = 1795377964


@pytest.mark.parametrize("seed", [CLIMB, DYNAMIC_BRAKE])
def test_points_keep_to_braking_rates(seed):
    trip = proof_trip(seed)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    assert all(verdict.ok for verdict in result.verify())
