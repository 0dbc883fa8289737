"""The survey of random trips: its trips have runs, its polish finds what is too dear and nothing else, its files."""

import csv

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.__main__ import main
from benchmarks.proof.descents import descent_trip
from benchmarks.proof.polish import Polish
from benchmarks.proof.tables import summary
from benchmarks.proof.trips import KINDS, proof_trip
from tests.helpers.trips import HILLS, commuter, trip_on
from tgvdp.api.trip import trip_of
from tgvdp.options.search import SearchOptions
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

SEEDS = range(7000, 7080)


@pytest.fixture(scope="module")
def hills():
    return tgvdp.search(HILLS.train, HILLS.track, points=6)


def test_trips_are_of_all_kinds_the_same_every_time_and_have_a_run():
    trips = [proof_trip(seed) for seed in SEEDS]
    assert {trip.kind for trip in trips} == set(KINDS)
    assert any(trip.track.neutral_sections for trip in trips)
    assert any(len(trip.train.braking_rates) > 1 for trip in trips)
    assert proof_trip(SEEDS[0]) == trips[0] != proof_trip(SEEDS[1])
    for trip in trips:
        options = SearchOptions(**trip.options)
        assert fastest_run(trip_of(trip.train, trip.track, options)).duration_s > 0.0


def test_neutral_sections_lie_on_descents():
    trips = [descent_trip(seed) for seed in SEEDS]
    assert descent_trip(SEEDS[0]) == trips[0] != descent_trip(SEEDS[1])
    assert max(len(trip.track.neutral_sections) for trip in trips) == 4
    for trip in trips:
        starts_m = [row.position_m for row in trip.track.gradients]
        for section in trip.track.neutral_sections:
            assert trip.track.gradients[np.searchsorted(starts_m, section.position_m) - 1].gradient_permil < 0.0
        options = SearchOptions(**trip.options)
        assert fastest_run(trip_of(trip.train, trip.track, options)).duration_s > 0.0


def test_polish_measures_a_run_as_the_package_does(hills):
    for index in range(len(hills.front)):
        profile = hills.profile(index)
        polish = Polish(hills.trip, profile)
        assert polish.time_s == pytest.approx(profile.duration_s, rel=1e-12)
        assert polish.energy_j == pytest.approx(profile.total_energy_j, rel=1e-6)


def test_polish_finds_what_a_spoiled_run_costs_too_much():
    """A wave in the speed of a run that holds it: what the wave costs is found, in a run that the referee passes."""
    train = commuter()
    level = trip_on([(0, 30)], length_m=20e3, train=train)
    result = tgvdp.search(train, level.track, points=6)
    best = result.profile(3)
    x = np.union1d(best.position_m, np.linspace(6e3, 10e3, 81))
    w = np.interp(x, best.position_m, best.speed_mps**2)
    wave = 40.0 * np.sin((x - 6e3) / 4e3 * 6.0 * np.pi) * ((x > 6e3) & (x < 10e3))
    spoiled = profile_of(level, x, w + wave)
    price = result.price_kwh_per_min[3] * 6e4
    gain_j, x_m, w = Polish(level, spoiled).polished(price)
    found = profile_of(level, x_m, w)
    assert replay(level, found).ok
    assert found.duration_s <= spoiled.duration_s * (1.0 + 1e-9)
    assert spoiled.total_energy_j - found.total_energy_j == pytest.approx(gain_j, rel=1e-3)
    same_time_j = best.total_energy_j - price * (spoiled.duration_s - best.duration_s)
    assert found.total_energy_j == pytest.approx(same_time_j, rel=3e-4)


def test_polish_finds_no_run_below_the_certified_bound(hills):
    bounds_j = hills.certify().lower_bound_j
    for index in range(1, len(hills.front)):
        profile = hills.profile(index)
        gain_j, _, _ = Polish(hills.trip, profile).polished(hills.price_kwh_per_min[index] * 6e4)
        assert gain_j <= profile.total_energy_j - bounds_j[index] + 1e-6 * profile.total_energy_j


def test_survey_writes_a_page_and_a_row_per_trip(tmp_path, capsys):
    assert main(["--seeds", "6", "--first", str(SEEDS[0]), "--out", str(tmp_path)]) == 0
    with open(tmp_path / "proof.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["seed"]) for row in rows] == list(SEEDS[:6])
    assert all(row["error"] == "" and float(row["dearer_pct"]) >= 0.0 for row in rows)
    assert f"Seeds {SEEDS[0]} to {SEEDS[5]}" in (tmp_path / "proof.md").read_text(encoding="utf-8")
    assert "dearer > 0.05 %" in capsys.readouterr().out


def test_survey_ends_with_its_minutes_and_counts_errors(tmp_path, monkeypatch):
    monkeypatch.setattr(tgvdp, "search", lambda *_, **__: 1 / 0)
    assert main(["--seeds", "6", "--first", "1", "--minutes", "0", "--out", str(tmp_path)]) == 0
    with open(tmp_path / "proof.csv", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert row["error"].startswith("ZeroDivisionError")
    assert summary([{"kind": "metro", "error": "a"}])[-1] == {"kind": "all", "trips": 1, "errors": 1}
