"""Runs sampled every so many metres: exact where v² is linear, and of the same energy."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.report_case import make_result, railway_trip, toy_trip
from tgvdp.errors import InputError
from tgvdp.runs.profile import joined
from tgvdp.runs.samples import gradient_at, limit_at, passing_s, rows_of, sample_count, sampled


@pytest.fixture(scope="module")
def case():
    result = make_result(railway_trip(), [24.0, 20.0])
    return result.trip, result.fastest.profile


@pytest.mark.parametrize("every_m", [1.0, 7.3, 100.0, 1000.0, 3999.0, 4000.0, 9000.0])
def test_samples_are_exact_in_speed_and_time(case, every_m):
    trip, profile = case
    table = sampled(trip, profile, every_m)
    assert len(table.position_m) == sample_count(trip, every_m)
    steps = np.diff(table.position_m)
    assert steps[:-1] == pytest.approx(every_m)
    assert 0.0 < steps[-1] <= every_m * (1 + 1e-9)
    assert (table.position_m[0], table.position_m[-1]) == (trip.origin_m, trip.destination_m)
    w = np.interp(table.position_m, profile.position_m, profile.speed_mps**2)
    assert table.speed_mps**2 == pytest.approx(w, abs=1e-9)
    # Time by the closed form 2·d/(v0 + v1) from the row before: an independent way.
    row = np.searchsorted(profile.position_m, table.position_m, side="right") - 1
    d = table.position_m - profile.position_m[row]
    total = table.speed_mps + profile.speed_mps[row]
    assert table.time_s == pytest.approx(profile.time_s[row] + np.divide(2 * d, total, out=0 * d, where=total > 0))


def test_a_position_is_passed_when_samples_are_there(case):
    trip, profile = case
    table = sampled(trip, profile, 7.3)
    passed = [passing_s(profile, at_m) for at_m in table.position_m.tolist()]
    assert all(arrival_s == departure_s for arrival_s, departure_s in passed)
    assert [arrival_s for arrival_s, _ in passed] == pytest.approx(table.time_s.tolist(), abs=1e-9)


def test_a_stop_is_left_later_than_it_is_reached(case):
    _, profile = case
    back = replace(profile, position_m=profile.position_m + profile.position_m[-1] - profile.position_m[0])
    both = joined([profile, back], np.array([0.0, profile.duration_s + 30.0]))
    assert passing_s(both, float(back.position_m[0])) == pytest.approx((profile.duration_s, profile.duration_s + 30.0))


def test_energy_is_that_of_the_profile_at_its_rows_and_its_end(case):
    trip, profile = case
    table = sampled(trip, profile, 100.0)
    at_rows = np.isin(table.position_m, profile.position_m)
    assert at_rows.sum() > 10
    assert table.energy_j[at_rows] == pytest.approx(
        np.interp(table.position_m[at_rows], profile.position_m, profile.energy_j)
    )
    assert table.energy_j[-1] == pytest.approx(profile.total_energy_j, rel=1e-12)
    assert np.diff(table.energy_j).min() > -1e-6


@pytest.mark.parametrize("energy", ["wheel", "pantograph", "alstom-map"])
def test_energy_between_rows_is_work(energy):
    """Where resistance is constant, the effort of a row is, and its work is force times distance."""
    train = replace(tgvdp.load_train("alstom-emu"), davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0)
    result = tgvdp.search(train, "flat-100km", destination_m=5000.0, energy=energy, points=3)
    profile = result.profile(1)
    table = sampled(result.trip, profile, 10.0)
    assert table.energy_j[-1] == pytest.approx(profile.total_energy_j, rel=1e-12)
    fine = sampled(result.trip, profile, 5.0)
    assert fine.energy_j[:-1:2] == pytest.approx(table.energy_j[:-1], rel=1e-5, abs=1.0)
    if energy == "wheel":
        row = np.searchsorted(profile.position_m, table.position_m, side="right") - 1
        d = table.position_m - profile.position_m[row]
        work_j = profile.energy_j[row] + np.maximum(profile.force_n[row], 0.0) * d
        assert table.energy_j == pytest.approx(work_j, rel=1e-6, abs=10.0)


def test_limit_and_gradient_are_those_of_the_line(case):
    trip, profile = case
    positions = np.array([1000.0, 1999.0, 2000.0, 3000.0, 4499.0, 4500.0, 5000.0])
    assert limit_at(trip, positions).tolist() == [30.0, 30.0, 40.0, 40.0, 40.0, 25.0, 25.0]
    assert gradient_at(trip, positions).tolist() == [0.0, 0.0, 10.0, -5.0, -5.0, -5.0, -5.0]
    assert gradient_at(toy_trip(), np.array([0.0, 2.0])).tolist() == [0.0, 0.0]
    assert rows_of(trip, profile).force_n is profile.force_n


@pytest.mark.parametrize("every_m", [0.0, -1.0, float("nan"), 1e-4])
def test_distances_out_of_range(case, every_m):
    trip, profile = case
    with pytest.raises(InputError, match="samples: "):
        sampled(trip, profile, every_m)


@pytest.mark.parametrize("every_m", [7.3, 100.0, 1000.0])
def test_efforts_are_means_up_to_the_next_sample(case, every_m):
    trip, profile = case
    table, steps_m = sampled(trip, profile, every_m), np.diff(profile.position_m)
    work_j = np.concatenate(([0.0], np.cumsum(profile.force_n[:-1] * steps_m)))
    between_j = np.diff(np.interp(table.position_m, profile.position_m, work_j))
    assert table.force_n[:-1] * np.diff(table.position_m) == pytest.approx(between_j, rel=1e-3, abs=1e-4 * work_j.max())
    assert table.force_n[:-1].max() <= trip.train.traction_limit.effort_n(0.0) * (1.0 + 1e-9)
