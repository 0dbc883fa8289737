"""What holds for the front of any trip: a named error, or a front that replays and that no plain grid beats."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.fronts import cheapest_above_grid, check_front, feasible_seeds, feasible_trip


@settings(max_examples=60, deadline=None, derandomize=True)
@given(feasible_seeds, st.sampled_from([0.001, 0.05, 0.25, 1.0, 3.0]), st.sampled_from([2, 10, 40]))
def test_every_front_is_sound(seed, margin, points):
    trip = feasible_trip(seed)
    if trip is not None:
        check_front(trip, margin, points)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(feasible_seeds)
def test_no_front_is_worse_than_a_grid(seed):
    trip = feasible_trip(seed)
    if trip is not None and len(trip.track.speed_limits) + len(trip.track.gradients) < 40:
        assert cheapest_above_grid(trip) <= 1e-3


@pytest.mark.slow
@settings(max_examples=300, deadline=None, derandomize=True)
@given(feasible_seeds, st.floats(0.001, 3.0), st.integers(2, 60))
def test_many_fronts_are_sound(seed, margin, points):
    trip = feasible_trip(seed)
    if trip is not None:
        check_front(trip, margin, points)
