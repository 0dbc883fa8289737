"""The front method against published optima, other units, a plain grid, and trips that once failed."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fronts import cheapest_above_grid, check_front, front_at, front_to
from tests.helpers.trips import commuter, reference_cases, reference_trip, trip_on
from tests.helpers.twins.trips import random_trip
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import EnergyModel
from tgvdp.model.track import Track
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run


def test_meets_every_reference(shared):
    """Energies of independent direct transcription, variant A (wheel energy)."""
    with open(shared / "reference" / "optimum.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["variant"] == "A"]
    for case in reference_cases(shared):
        key = tuple(case[name] for name in ("track", "train", "from_stop_m", "to_stop_m"))
        mine = [row for row in rows if tuple(row[n] for n in ("track", "train", "from_stop_m", "to_stop_m")) == key]
        mine.sort(key=lambda row: float(row["T_s"]))
        found = front_at(reference_trip(shared, case), [float(row["T_s"]) for row in mine])
        metro = "Beijing" in key[1]
        for row, seconds, joules, multiplier in zip(
            mine, found.duration_s, found.energy_j, found.multiplier_j_per_s, strict=True
        ):
            energy_kwh = (joules + multiplier * (seconds - float(row["T_s"]))) / 3.6e6
            above_kwh = energy_kwh - float(row["E_ref_kWh"])
            share = above_kwh / float(row["E_ref_kWh"])
            assert share >= -3e-4, (row, share)
            assert share <= (2e-3 if metro else 1e-3) or (metro and above_kwh <= 0.015), (row, share)


HILLS = trip_on([(0, 35), (6000, 22)], [(0, 0), (2000, 12), (4000, -9), (8000, 3)])


def scaled(trip, metre=1.0, second=1.0, kilogram=1.0):
    """The same trip in other units of length, time and mass."""
    newton = kilogram * metre / second**2
    speed = metre / second
    train = trip.train

    def curve(given):
        return EffortCurve(
            tuple(
                (p.from_mps * speed, p.power_w * newton * speed, p.c0_n * newton, p.c1 * newton / speed,
                 p.c2 * newton / speed**2, p.c3 * newton / speed**3)
                for p in given.pieces
            )
        )  # fmt: skip

    # Gravity keeps its 9.81 m/s²: gradients carry the change of units.
    slope = metre / second**2
    return Trip(
        train=replace(
            train,
            mass_kg=train.mass_kg * kilogram,
            traction=curve(train.traction),
            braking=curve(train.braking),
            friction_brake_n=train.friction_brake_n * newton,
            davis_a_n=train.davis_a_n * newton,
            davis_b_n_per_mps=train.davis_b_n_per_mps * newton / speed,
            davis_c_n_per_mps2=train.davis_c_n_per_mps2 * newton / speed**2,
            max_acceleration_mps2=train.max_acceleration_mps2 * slope,
            max_deceleration_mps2=train.max_deceleration_mps2 * slope,
            max_speed_mps=train.max_speed_mps * speed,
        ),
        track=Track(
            length_m=trip.track.length_m * metre,
            speed_limits=tuple((x * metre, v * speed) for x, v in trip.track.speed_limits),
            gradients=tuple((x * metre, i * slope) for x, i in trip.track.gradients),
        ),
        origin_m=trip.origin_m * metre,
        destination_m=trip.destination_m * metre,
        start_speed_mps=trip.start_speed_mps * speed,
        end_speed_mps=trip.end_speed_mps * speed,
    )


@pytest.mark.parametrize(
    "units", [{"kilogram": 2.0**-20}, {"metre": 2.0**-12, "second": 2.0**-6}, {"metre": 4.0, "second": 4.0}]
)
def test_other_units_give_the_same_front(units):
    """Powers of two change no rounding, so that even the choice of cells must be the same, but where time has another.

    Rows are cut until times are right to half a millisecond, which another unit of time makes longer or shorter; and
    where they are cut, they are driven half as fine before.
    """
    fastest, found = front_to(HILLS, 0.25, 12)
    other_fastest, other = front_to(scaled(HILLS, **units), 0.25, 12)
    second = units.get("second", 1.0)
    joule = units.get("kilogram", 1.0) * (units.get("metre", 1.0) / second) ** 2
    if second == 1.0:
        assert other_fastest.duration_s == pytest.approx(fastest.duration_s, rel=1e-9)
        assert other.duration_s == pytest.approx(found.duration_s, rel=1e-9)
        assert other.energy_j == pytest.approx(found.energy_j * joule, rel=2e-9)
        return
    # Other rows, so that losses that are next to what is allowed are on its other side, and cells are others.
    assert other_fastest.duration_s == pytest.approx(fastest.duration_s * second, rel=1e-5)
    assert other.duration_s == pytest.approx(found.duration_s * second, rel=1e-3)
    later_s = other.duration_s[1:] / second - found.duration_s[1:]
    energy_j = other.energy_j[1:] / joule + found.multiplier_j_per_s[1:] * later_s
    assert energy_j == pytest.approx(found.energy_j[1:], rel=4e-5)


def test_odd_units_give_the_same_front():
    """Pounds, feet and half seconds round differently: branches may fall otherwise, but hardly matter."""
    fastest, found = front_to(HILLS, 0.25, 12)
    other_fastest, other = front_to(scaled(HILLS, metre=3.28084, second=2.0, kilogram=2.20462), 0.25, 12)
    joule = 2.20462 * (3.28084 / 2.0) ** 2
    assert other_fastest.duration_s == pytest.approx(fastest.duration_s * 2.0, rel=1e-9)
    assert other.energy_j == pytest.approx(found.energy_j * joule, rel=3e-4)


SHAPES = {
    "hills": HILLS,
    "steep": trip_on([(0, 35)], [(0, 0), (2000, 30), (3500, -35), (6000, 0)]),
    "limits": trip_on([(0, 30), (2000, 12), (2200, 40), (7000, 25), (9900, 8)]),
    "moving ends": trip_on([(0, 40), (5000, 20)], start_speed_mps=25.0, end_speed_mps=18.0),
    "metro": trip_on([(0, 22), (900, 15)], [(0, 4), (400, -6)], length_m=1500.0),
    "dozens of limits in 100 m": trip_on([(i * 2.5, 5.0 + (7 * i) % 11) for i in range(40)], length_m=100.0),
    "one metre": trip_on([(0, 30)], length_m=1.0),
    "heavy": trip_on([(0, 30)], [(0, 5), (9000, -5)], length_m=20e3, train=commuter(mass_kg=3e6)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_no_plain_grid_is_better(name):
    assert cheapest_above_grid(SHAPES[name]) <= 5e-4


@pytest.mark.parametrize("margin", [0.001, 0.05, 3.0])
@pytest.mark.parametrize("points", [2, 60, 200])
def test_any_margin_and_number_of_points(margin, points):
    fastest, found = check_front(HILLS, margin, points)
    wanted = fastest.duration_s * np.linspace(1.0, 1.0 + margin, points)
    step_s = wanted[1] - wanted[0]
    # The mesh's own fastest run may be slower by its rows; what lies between the two is named, not returned.
    assert all(missed_s <= fastest.duration_s * (1.0 + 1e-5) for missed_s in found.missed_s)
    kept = np.array([not np.isclose(time_s, found.missed_s, rtol=0.0, atol=1e-9).any() for time_s in wanted.tolist()])
    assert len(found.duration_s) == kept.sum()
    assert np.abs(found.duration_s - wanted[kept]).max() <= 0.05 * step_s


def test_running_times_that_are_asked_for():
    fastest = fastest_run(HILLS)
    wanted = fastest.duration_s * np.array([1.03, 1.05, 1.1, 1.5])
    found = optimal_front(HILLS, fastest, wanted, SearchBudget(), tolerance_s=0.05)
    assert np.abs(found.duration_s - wanted).max() <= 0.05


def test_a_thousand_kilometres():
    check_front(trip_on([(0, 44)], [(0, 2), (4e5, -3), (7e5, 1)], length_m=1e6), 0.25, 10)


def test_relaxing_a_limit_never_costs_energy():
    _fastest, found = front_to(HILLS, 0.25, 20)
    limits = tuple((x, v * 1.2) for x, v in HILLS.track.speed_limits)
    relaxed = replace(HILLS, track=Track(length_m=10e3, speed_limits=limits, gradients=HILLS.track.gradients))
    after = front_at(relaxed, found.duration_s[1:])
    assert (after.energy_j <= found.energy_j[1:] * 1.001).all()


#: Random trips whose front was once worse than a plain grid, did not descend, missed its targets or failed.
REGRESSIONS = {
    "worse than a grid, Davis resistance on hills": [8, 41, 72, 212, 254, 260, 347, 348],
    "worse than a grid, drag only": [75, 108, 195, 215, 238, 241, 340, 382],
    "worse than a grid, no resistance": [3, 5, 18, 45, 51, 121, 156, 239, 290, 303],
}


@pytest.mark.parametrize("name", REGRESSIONS)
def test_once_failing_fronts(name):
    # 2e-3: where the optimal runs jump in running time (seed 290) only blends lie between, and these cost a little.
    worse = {seed: gap for seed in REGRESSIONS[name] if (gap := cheapest_above_grid(random_trip(seed))) > 2e-3}
    assert not worse


DESCENDS = [4, 45, 71, 86, 112, 191, 195, 238, 271, 347, 351, 448, 456]
CRASHED = [19, 72, 91, 117, 216, 230, 248, 266, 270]
#: The rows of a point belonged to another run.
OTHER_ROWS = [(556121, 0.001, 2), (239513, 1.0, 40)]


@pytest.mark.parametrize("seed", DESCENDS + CRASHED)
def test_once_failing_points(seed):
    for margin, points in ((0.001, 10), (0.25, 20), (3.0, 10)):
        check_front(random_trip(seed), margin, points)


@pytest.mark.parametrize(("seed", "margin", "points"), OTHER_ROWS)
def test_the_rows_of_a_point_are_its_own(seed, margin, points):
    check_front(random_trip(seed), margin, points)


def test_start_at_the_limit_whose_first_multiplier_is_already_the_thriftiest():
    """The usual multiplier alone gives the thriftiest run here: dearer ones must be found all the same."""
    train = commuter(mass_kg=1e5)
    trip = trip_on([(0, 40)], length_m=5000.0, train=train, start_speed_mps=40.0)
    assert cheapest_above_grid(trip, 0.1) <= 1e-3


@pytest.mark.parametrize("limit_mps", [1e5, 1e7])
def test_a_limit_that_nobody_reaches_changes_nothing(limit_mps):
    fastest = fastest_run(trip_on([(0, 200)], length_m=3000.0))
    assert fastest_run(trip_on([(0, limit_mps)], length_m=3000.0)).duration_s == pytest.approx(
        fastest.duration_s, rel=1e-9
    )


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_marches_with_little_room_get_more(monkeypatch, energy):
    trip = replace(HILLS, energy=EnergyModel(energy))
    expected = front_to(trip, 0.2, 8)[1]
    monkeypatch.setattr("tgvdp.methods.costate.room._MARCH_ROWS", 2)
    found = front_to(trip, 0.2, 8)[1]
    assert np.array_equal(found.duration_s, expected.duration_s)
    assert np.array_equal(found.energy_j, expected.energy_j)
