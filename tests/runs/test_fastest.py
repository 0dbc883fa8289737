"""The fastest run: published optima, an independent simulation, odd lines, and impossible trips."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.fronts import front_to
from tests.helpers.trips import commuter, reference_cases, reference_trip, trip_on
from tests.helpers.twins.running import fastest_s
from tests.helpers.twins.trips import level_trip, random_trip
from tgvdp.errors import InfeasibleError
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import Cell, Rows, room_for_rows
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import kernel_train
from tgvdp.referee.replay import replay
from tgvdp.runs.braking_point import braked_along, braked_w, braking_curve, drive_then_brake
from tgvdp.runs.fastest import fastest_run
from tgvdp.units import joule_to_kwh

#: Random trips that once failed, by what was wrong.
REGRESSIONS = {
    "last row to standstill too long": [24, 27, 35, 134, 345, 471],
    "balancing speed": [28, 37, 564, 574],
    "row over a drop of the effort": [13, 193, 254, 428],
    "held at the limit on a climb": [72, 86, 232, 239, 260, 393],
    "the brakes cannot hold the limit": [592],
    "replay stiff on rows of many kilometres": [75, 186, 271, 467],
}


def test_meets_every_reference(shared):
    rows = reference_cases(shared)
    assert len(rows) > 10
    for row in rows:
        profile = fastest_run(reference_trip(shared, row))
        assert profile.duration_s == pytest.approx(float(row["T_min_s"]), rel=5e-5), row
        assert joule_to_kwh(profile.total_energy_j) == pytest.approx(float(row["E_flatout_kWh"]), rel=1e-3), row


SIMULATED = {
    "level": trip_on([(0, 40)]),
    "limits": trip_on([(0, 30), (2000, 12), (2200, 40), (7000, 25), (9900, 8)]),
    "hills": trip_on([(0, 40)], [(0, 0), (1500, 20), (4000, -30), (7000, 5)]),
    "moving ends": trip_on([(0, 40), (5000, 20)], start_speed_mps=25.0, end_speed_mps=18.0),
    "comfort": trip_on([(0, 30), (4000, 20)], train=commuter(max_acceleration_mps2=0.4, max_deceleration_mps2=0.5)),
    "part of a line": trip_on([(0, 20), (3000, 35)], [(0, 5), (6000, -8)], origin_m=1234.5, destination_m=8765.4),
    "climb that slows it down": trip_on([(0, 40)], [(0, 0), (4000, 35), (7000, 0)], length_m=9000),
}


@pytest.mark.parametrize("name", SIMULATED)
def test_agrees_with_a_plain_simulation(name):
    trip = SIMULATED[name]
    profile = fastest_run(trip)
    assert replay(trip, profile).ok
    assert profile.duration_s == pytest.approx(fastest_s(trip, 2.0), rel=1e-3)


def test_constant_forces_have_a_closed_form():
    """1 m/s² up to the limit, held, 2 m/s² down: T = v/a + v/b + (L − v²/2a − v²/2b)/v."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=2.0)
    profile = fastest_run(level_trip(train, 100.0, limit_mps=6.0))
    assert profile.duration_s == pytest.approx(6.0 + 3.0 + (100.0 - 18.0 - 9.0) / 6.0, rel=1e-12)
    assert profile.total_energy_j == pytest.approx(18.0, rel=1e-12)
    # A section shorter than the way to the limit: v² = 2·L·ab/(a + b).
    profile = fastest_run(level_trip(train, 12.0, limit_mps=6.0))
    top = math.sqrt(2.0 * 12.0 * 2.0 / 3.0)
    assert profile.speed_mps.max() == pytest.approx(top, rel=1e-9)
    assert profile.duration_s == pytest.approx(top + top / 2.0, rel=1e-9)


#: The shape of the seed's train: polynomials with a drop between them.
POLYNOMIALS = EffortCurve(
    (
        EffortPiece(0.0, c0_n=3.0e5, c1=-2.0e3),
        EffortPiece(14.0, c0_n=2.9e5, c1=-6.0e3, c2=40.0),
        EffortPiece(33.0, c0_n=2.1e5, c1=-4.5e3, c2=27.0, c3=0.02),
    )
)
ODD = {
    "one cell, one metre": trip_on([(0, 30)], length_m=1.0),
    "a thousand kilometres": trip_on([(0, 40)], length_m=1e6),
    "no limit at all": trip_on([(0, 500)], train=commuter(max_speed_mps=math.inf), length_m=3e4),
    "no limit, no resistance": trip_on(
        [(0, 1e3)],
        train=Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0),
        length_m=1e4,
    ),
    "dozens of limits in 100 m": trip_on([(i * 2.5, 5.0 + (7 * i) % 11) for i in range(40)], length_m=100.0),
    "gradient changes every metre": trip_on(
        [(0, 30)], [(i, 40.0 * math.sin(1.3 * i)) for i in range(400)], length_m=400.0
    ),
    "limit breaks at both stops": trip_on([(0, 10), (5000, 30)], origin_m=5000.0, destination_m=10e3),
    "section shorter than braking": trip_on([(0, 40), (50, 10)], length_m=120.0, start_speed_mps=13.0),
    "start at the cap": trip_on([(0, 40)], length_m=2000.0, start_speed_mps=40.0, end_speed_mps=40.0),
    "crawl": trip_on([(0, 0.01)], length_m=50.0),
    "tiny drop": trip_on([(0, 40), (5000, 39.999999), (5000.001, 40)]),
    "polynomial efforts with drops": trip_on([(0, 50)], train=commuter(traction=POLYNOMIALS, max_speed_mps=50.0)),
    "polynomial efforts, hills": trip_on(
        [(0, 50)], [(0, 30), (2000, -30), (5000, 37)], train=commuter(traction=POLYNOMIALS, max_speed_mps=50.0)
    ),
    "a gram": trip_on(
        [(0, 1)],
        train=Train(mass_kg=1e-3, traction=EffortCurve.from_caps(1e-3, 1e-3), friction_brake_n=1e-3),
        length_m=2.0,
    ),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_lines(name):
    trip = ODD[name]
    profile = fastest_run(trip)
    verdict = replay(trip, profile)
    assert verdict.ok, verdict
    assert (np.diff(profile.position_m) > 0.0).all()
    assert (np.diff(profile.time_s) > 0.0).all()
    assert profile.speed_mps[0] == pytest.approx(trip.start_speed_mps)
    assert profile.speed_mps[-1] == pytest.approx(trip.end_speed_mps)


WEAK = EffortCurve.from_caps(2.5e4)
IMPOSSIBLE = {
    "cannot start on a climb": (trip_on([(0, 30)], [(0, 20)], train=commuter(traction=WEAK)), "stalls at 0 m"),
    "stalls on a climb": (
        trip_on([(0, 30)], [(0, 0), (4000, 35)], train=commuter(traction=WEAK)),
        "stalls at 4000 m",
    ),
    "cannot brake on a descent": (
        trip_on(
            [(0, 30)],
            [(0, 0), (4000, -35)],
            train=commuter(braking=EffortCurve.from_caps(0.0), friction_brake_n=5e4),
        ),
        "brakes of train commuter cannot hold it at 4000 m",
    ),
    "start above the limit": (trip_on([(0, 10)], start_speed_mps=11.0), "start speed 39.6 km/h is above the limit"),
    "start too fast for what follows": (
        trip_on([(0, 40), (100, 5)], start_speed_mps=35.0),
        "start speed 126 km/h is too high",
    ),
    "too fast to stop": (trip_on([(0, 40)], length_m=50.0, start_speed_mps=30.0), "start speed 108 km/h is too high"),
    "end above the limit": (trip_on([(0, 30), (9000, 10)], end_speed_mps=12.0), "end speed 43.2 km/h is above"),
    "end speed out of reach": (trip_on([(0, 40)], length_m=100.0, end_speed_mps=30.0), "cannot be reached"),
    "end above the train's top speed": (
        trip_on([(0, 60)], end_speed_mps=50.0),
        "end speed 180 km/h is above the limit there, 158.4 km/h",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_impossible_trips_say_why(name):
    trip, why = IMPOSSIBLE[name]
    with pytest.raises(InfeasibleError) as caught:
        fastest_run(trip)
    message = str(caught.value)
    assert why in message
    assert "\n" not in message
    assert len(message) < 160


@pytest.mark.parametrize("name", REGRESSIONS)
def test_once_failing_trips(name):
    for seed in REGRESSIONS[name]:
        trip = random_trip(seed)
        verdict = replay(trip, fastest_run(trip))
        assert verdict.ok, (seed, verdict)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.integers(10_000, 10**9))
def test_random_trips_replay_or_say_why_not(seed):
    trip = random_trip(seed)
    if trip is None:
        return
    try:
        profile = fastest_run(trip)
    except InfeasibleError:
        return
    verdict = replay(trip, profile)
    assert verdict.ok, verdict
    assert (np.diff(profile.position_m) > 0.0).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 10**9), st.floats(1.0, 1.5))
def test_a_relaxed_limit_never_takes_longer(seed, factor):
    trip = random_trip(seed)
    if trip is None:
        return
    track = trip.track
    limits = tuple((row.position_m, row.speed_mps * factor) for row in track.speed_limits)
    relaxed = Track(length_m=track.length_m, speed_limits=limits, gradients=track.gradients)
    try:
        before = fastest_run(trip).duration_s
    except InfeasibleError:
        return
    ends = {name: getattr(trip, name) for name in ("origin_m", "destination_m", "start_speed_mps", "end_speed_mps")}
    after = fastest_run(Trip(train=trip.train, track=relaxed, **ends)).duration_s
    assert after <= before * (1.0 + 1e-4)


@pytest.mark.parametrize("rates", [(), ((0.0, 0.7), (20.0, 0.6))])
def test_a_dynamic_brake_that_fades_to_nothing_at_standstill(rates):
    """Its effort begins at 0 N: friction, or what keeps the rate, brings the train to a stand."""
    train = commuter(braking=EffortCurve.from_points([(0, 0), (5, 1.2e5), (40, 6e4)]), braking_rates=rates)
    trip = trip_on([(0, 30)], [(0, 0), (6000, -10)], train=train)
    profile = fastest_run(trip)
    assert replay(trip, profile).ok
    if not rates:
        assert profile.duration_s == pytest.approx(fastest_s(trip, 0.2), rel=1.5e-4)


@pytest.mark.nojit
def test_a_march_with_little_room_gets_more(monkeypatch):
    trip = trip_on([(0, 12), (300, 20), (700, 8)], [(0, 0), (200, 15)], length_m=900)
    expected = fastest_run(trip)
    monkeypatch.setattr("tgvdp.runs.fastest._SCRATCH", 4)
    found = fastest_run(trip)
    assert np.array_equal(found.position_m, expected.position_m)
    assert np.array_equal(found.speed_mps, expected.speed_mps)


def test_a_line_of_many_cells_does_not_need_all_the_rows_that_its_run_might_take(monkeypatch):
    """A high-speed train on 450 km with a gradient every 200 m was refused before its run was tried."""
    changes = [(10.0 * k, k % 2) for k in range(500)]
    trip = trip_on([(0, 40)], changes, length_m=5000)
    expected = front_to(trip, 0.1, 3)[1]
    for module in ("physics.cell", "runs.fastest", "methods.costate.room"):
        monkeypatch.setattr(f"tgvdp.{module}.MOST_ROWS", 8000)
    monkeypatch.delattr("tgvdp.methods.costate.room._threads.room", raising=False)
    assert front_to(trip, 0.1, 3)[1].energy_j == pytest.approx(expected.energy_j, rel=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("room", [*range(2, 40, 3), 4000])
def test_rows_of_a_cell_stay_within_their_room(room):
    train = kernel_train(commuter())
    cell = Cell(0.0, 800.0, 800.0, 0.0, 0.0, 400.0)
    rows, scratch = room_for_rows(room + 1, "test"), room_for_rows(room, "test: march")
    rows.x[-1] = rows.w[-1] = -7.0
    taken = Rows(rows.x[:room], rows.w[:room])
    taken.x[0] = taken.w[0] = 0.0
    n = drive_then_brake(train, TRACTION, BRAKING, cell, 0.0, 0.0, scratch, taken, 1)
    assert n == -1 or (n <= room and taken.x[n - 1] == 800.0)
    assert (rows.x[-1], rows.w[-1]) == (-7.0, -7.0)


@pytest.mark.nojit
@pytest.mark.parametrize("brakes", [BRAKING, DYNAMIC])
@pytest.mark.parametrize("regime", [TRACTION, COASTING])
def test_rows_of_driving_and_braking_advance(regime, brakes):
    """The row of the braking curve in which the two meet begins where the driven rows end, or not at all."""
    rng = np.random.default_rng(regime + 10 * brakes)
    train = kernel_train(commuter())
    scratch, rows = room_for_rows(400, "test: march"), room_for_rows(400, "test")
    for _ in range(40):
        length_m, grade_n, end_w = 10.0 ** rng.uniform(0.0, 3.3), rng.uniform(-5e3, 2e4), rng.uniform(0.0, 150.0)
        cell = Cell(0.0, length_m, length_m, grade_n, 5.0, rng.uniform(end_w + 1.0, 500.0))
        first_w = braked_w(train, brakes, cell, end_w, length_m * rng.uniform(0.0, 1.0), scratch)
        for start_w in (first_w, rng.uniform(0.5 * first_w, first_w)):
            rows.x[0], rows.w[0] = 0.0, start_w
            n = drive_then_brake(train, regime, brakes, cell, start_w, end_w, scratch, rows, 1)
            assert (np.diff(rows.x[:n]) > 0.0).all()
            assert (rows.x[n - 1], rows.w[n - 1]) == (length_m, end_w)


@pytest.mark.nojit
@pytest.mark.parametrize("brakes", [BRAKING, DYNAMIC])
@pytest.mark.parametrize("limit_w", [200.0, 1e4])  # which braking comes to within the cell, or does not
def test_a_braking_curve_is_read_where_braking_would_begin(brakes, limit_w):
    train = kernel_train(commuter())
    cell = Cell(0.0, 800.0, 800.0, -2e3, 5.0, limit_w)
    scratch, rows = room_for_rows(400, "test: march"), room_for_rows(400, "test")
    curve = braking_curve(train, brakes, cell, 25.0, rows)
    assert curve.start_w == pytest.approx(braked_w(train, brakes, cell, 25.0, 800.0, scratch), rel=1e-13)
    assert (curve.limited_m < 800.0) == (curve.start_w == limit_w)
    for x in (0.0, 1e-7, *np.linspace(1.0, 800.0, 97), rows.x[3], np.nextafter(rows.x[3], 0.0)):
        read = braked_along(train, brakes, cell, 25.0, x, curve, rows)
        assert read == pytest.approx(braked_w(train, brakes, cell, 25.0, x, scratch), rel=1e-13)
