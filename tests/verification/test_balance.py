"""The balance of energy: honest profiles keep it, and each forged term breaks it."""

from dataclasses import replace

import pytest

from tests.helpers.trips import HILLS
from tests.helpers.twins.trips import random_trip
from tgvdp.errors import InfeasibleError
from tgvdp.runs.fastest import fastest_run
from tgvdp.verification.balance import balance_error


def test_random_profiles_keep_it():
    checked = 0
    for seed in range(60):
        trip = random_trip(seed)
        try:
            profile = None if trip is None else fastest_run(trip)
        except InfeasibleError:
            continue
        plain = trip is not None and trip.convention.mass_model == "point" and not trip.convention.tunnels
        if plain and trip.convention.curves == "none":
            assert balance_error(trip, profile) < 1e-9, seed
            checked += 1
    assert checked > 20


@pytest.mark.parametrize(
    "change",
    [{"davis_a_n": 3.01e3}, {"davis_b_n_per_mps": 31.0}, {"davis_c_n_per_mps2": 6.01}, {"rotating_mass_factor": 1.061}],
)
def test_another_train_breaks_it(change):
    profile = fastest_run(HILLS)
    assert balance_error(HILLS, profile) < 1e-12
    assert balance_error(replace(HILLS, train=replace(HILLS.train, **change)), profile) > 1e-6


def test_forged_effort_and_height_break_it():
    profile = fastest_run(HILLS)
    assert balance_error(HILLS, replace(profile, force_n=profile.force_n * 1.001)) > 1e-5
    lower = replace(
        HILLS, track=replace(HILLS.track, gradients=((0.0, 0.0), (2000.0, 11.9), (4000.0, -9.0), (8000.0, 3.0)))
    )
    assert balance_error(lower, profile) > 1e-5
