"""The explicit grid: stations, speeds, arcs that obey all limits, and profiles that keep what the grid claims."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.grid_case import all_paths, points_of, toy_trip
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formats import load_track, load_train
from tgvdp.line.cells import breaks_of, cells_of
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.arcs import long_arc
from tgvdp.methods.grid.exact import exact_front
from tgvdp.methods.grid.grid import build_grid
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import OK, OVER_EFFORT_AT_POINT, OVER_LIMIT, OVER_TRACTION
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import kernel_train
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

BUDGET = SearchBudget(20_000_000, 30.0)


def frictionless(**changes):
    return Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0, **changes)


def tram(limits, length_m=1000.0, **trip):
    train = Train(mass_kg=1000.0, traction=EffortCurve.from_caps(800.0, 16e3), friction_brake_n=800.0)
    ends = {"origin_m": 0.0, "destination_m": length_m}
    return Trip(train=train, track=Track(length_m=length_m, speed_limits=limits), **(ends | trip))


def drive_on(trip, w0, w1):
    cells = cells_of(trip)
    return long_arc(
        kernel_train(trip.train), energy_tables(trip.train, trip.energy), cells, 0, len(cells.length_m), w0, w1
    )


@pytest.mark.nojit
def test_an_arc_of_a_unit_mass_has_its_closed_form():
    trip = Trip(
        train=frictionless(), track=Track(length_m=2.0, speed_limits=((0.0, 9.0),)), origin_m=0.0, destination_m=2.0
    )
    status, duration_s, energy_j = drive_on(trip, 0.0, 4.0)  # full effort: a = 1, v = 2 after 2 m and 2 s
    assert (status, duration_s, energy_j) == (OK, pytest.approx(2.0, rel=1e-14), pytest.approx(2.0, rel=1e-14))
    assert drive_on(trip, 4.0, 0.0)[:2] == (OK, pytest.approx(2.0, rel=1e-14))
    assert drive_on(trip, 4.0, 0.0)[2] == 0.0
    assert drive_on(trip, 0.0, 4.0 * (1.0 + 1e-6))[0] == OVER_EFFORT_AT_POINT


@pytest.mark.nojit
def test_limits_inside_an_arc_hold():
    track = Track(length_m=2.0, speed_limits=((0.0, 2.0), (0.5, 0.9), (1.0, 2.0)))
    trip = Trip(train=frictionless(), track=track, origin_m=0.0, destination_m=2.0)
    assert drive_on(trip, 0.8, 0.8)[0] == OK
    assert drive_on(trip, 0.82, 0.82)[0] == OVER_LIMIT
    assert drive_on(trip, 0.6, 1.0)[0] == OK  # 0.8 at the end of the slow cell
    assert drive_on(trip, 0.7, 1.2)[0] == OVER_LIMIT


@pytest.mark.nojit
def test_a_power_limit_holds_at_every_point_of_a_long_arc():
    """Mean effort fits, but not at the fast end: constant acceleration asks for most power there."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(10.0, 1.0), friction_brake_n=1.0)
    trip = Trip(train=train, track=Track(length_m=2.0, speed_limits=((0.0, 9.0),)), origin_m=0.0, destination_m=2.0)
    top = 1.0
    while drive_on(trip, 1.0, top)[0] == OK:
        top += 1e-3
    status = drive_on(trip, 1.0, top)[0]
    assert status in (OVER_EFFORT_AT_POINT, OVER_TRACTION)
    assert 0.5 * (top - 1.0) / 2.0 * math.sqrt(top) == pytest.approx(1.0, rel=2e-3)  # m·a·v = P


def test_energy_counts_positive_effort_only_within_an_arc():
    """Effort changes sign inside the arc: its positive part is the integral, not the net work."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(5.0), davis_c_n_per_mps2=1.0, friction_brake_n=5.0)
    trip = Trip(train=train, track=Track(length_m=1.0, speed_limits=((0.0, 9.0),)), origin_m=0.0, destination_m=1.0)
    status, _, energy_j = drive_on(trip, 1.0, 0.2)  # a = -0.4, effort w - 0.4 with w = 1 - 0.8·x: zero at x = 0.75
    assert status == OK
    assert energy_j == pytest.approx(0.6 * 0.75 / 2.0, rel=1e-12)


def test_stations_and_speeds():
    limits = ((0.0, 20.0), (95.0, 10.0), (405.0, 15.0), (990.0, 20.0))
    trip = tram(limits, start_speed_mps=3.3)
    grid = build_grid(trip, segment_m=100.0, speeds=10)
    assert np.all(np.diff(grid.station_m) <= 100.0 * (1.0 + 1e-9))
    assert np.all(np.isin([95.0, 405.0], grid.station_m))
    assert 990.0 not in grid.station_m  # closer than half a segment to the end
    assert np.all(np.isin([0.0, 3.3, 10.0, 15.0], grid.level_mps))
    assert np.all(np.diff(grid.level_mps) > 0.0)
    speed = grid.level_mps[grid.level]
    at_end = grid.graph.layer == len(grid.station_m) - 1
    assert np.all(speed[~at_end] > 0.0)
    assert speed[0] == 3.3
    assert speed[-1] == 0.0
    assert grid.level_mps[-1] == pytest.approx(fastest_run(trip).speed_mps.max(), rel=1e-12)
    slow = (grid.station_m[grid.graph.layer] >= 95.0) & (grid.station_m[grid.graph.layer] <= 405.0)
    assert speed[slow].max() == 10.0


def test_every_node_lies_on_a_path():
    graph = build_grid(toy_trip(gradients=((0.0, 40.0), (1.0, -60.0))), segment_m=0.2, speeds=8).graph
    assert np.all(np.diff(graph.arc_ptr)[:-1] > 0)
    assert np.all(np.diff(graph.incoming().arc_ptr)[1:] > 0)


def test_stations_snap_to_breaks_that_rounding_moved():
    gradients = tuple((0.1 * k, 5.0 * (-1) ** k) for k in range(20))
    trip = toy_trip(gradients=gradients)
    grid = build_grid(trip, segment_m=0.1, speeds=6)
    assert np.min(np.diff(cells_of(trip, grid.station_m).station_m)) > 1e-6
    assert np.min(np.diff(breaks_of(trip))) > 1e-6


def check_profiles(grid, found, indices):
    for index in indices:
        x_m, w = found.rows(index)
        assert np.all(np.diff(x_m) > 0.0)
        profile = profile_of(grid.trip, x_m, w)
        assert profile.duration_s == pytest.approx(found.duration_s[index], rel=1e-9)
        assert profile.total_energy_j == pytest.approx(found.energy_j[index], rel=1e-6, abs=1e-9)
        verdict = replay(grid.trip, profile)
        assert verdict.ok, verdict


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_profiles_keep_what_the_grid_claims(scale):
    """The same problem at two scales: lengths and mass × 1000, gradients ÷ 1000; speeds and forces as they are."""
    limits = ((0.0, 1.0), (1.2, 0.6))
    gradients = ((0.0, 0.0), (0.4, 25.0), (0.95, -50.0))
    limits = tuple((x * scale, limit) for x, limit in limits)
    gradients = tuple((x * scale, gradient / scale) for x, gradient in gradients)
    trip = toy_trip(2.0 * scale, limits, gradients, mass_kg=scale)
    grid = build_grid(trip, speeds=20)
    found = exact_front(grid, 1.5 * fastest_run(trip).duration_s, BUDGET)
    assert len(found) > 20
    check_profiles(grid, found, np.linspace(0, len(found) - 1, 7).astype(int))


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.floats(0.3, 1.2), min_size=1, max_size=4),
    st.lists(st.floats(-60.0, 60.0), min_size=1, max_size=5),
    st.integers(6, 14),
)
def test_any_toy_line_gives_sound_profiles_or_a_named_error(limits, gradients, speeds):
    trip = toy_trip(
        limits=tuple((2.0 * k / len(limits), v) for k, v in enumerate(limits)),
        gradients=tuple((2.0 * k / len(gradients), g) for k, g in enumerate(gradients)),
    )
    try:
        grid = build_grid(trip, segment_m=0.25, speeds=speeds)
    except InfeasibleError as error:
        assert "try more speeds" in str(error)
        return
    found = exact_front(grid, 1e6, BUDGET)
    check_profiles(grid, found, [0, len(found) - 1])
    assert found.duration_s[0] >= fastest_run(trip).duration_s * (1.0 - 1e-9)


def test_more_speeds_never_worsen_the_front():
    trip = toy_trip()
    few, many = (exact_front(build_grid(trip, 0.25, speeds), 10.0, BUDGET) for speeds in (5, 10))
    for time, energy in points_of(few):
        assert np.min(many.energy_j[many.duration_s <= time]) <= energy


def test_where_the_grid_ends_is_told():
    with pytest.raises(InfeasibleError, match=r"station 1 of 40, at 0.05 m.*effort; try more speeds"):
        build_grid(toy_trip(), segment_m=0.05, speeds=1)
    with pytest.raises(InfeasibleError, match="stalls"):  # 200 ‰ on a unit mass: 1.96 N against 1 N
        build_grid(toy_trip(gradients=((0.0, 0.0), (0.3, 200.0), (1.9, 0.0))), segment_m=0.25, speeds=10)
    with pytest.raises(InfeasibleError, match="start speed"):
        build_grid(toy_trip(start_speed_mps=1.5), segment_m=0.25, speeds=10)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"segment_m": 0.0}, "segment_m"),
        ({"segment_m": -5.0}, "segment_m"),
        ({"segment_m": math.nan}, "segment_m"),
        ({"segment_m": 1e-9}, "at least"),
        ({"speeds": 0}, "speeds"),
        ({"speeds": 2.5}, "speeds"),
        ({"speeds": 10**6}, "speeds"),
    ],
)
def test_wrong_options_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        build_grid(toy_trip(), **options)


def test_the_time_limit_holds_while_the_grid_is_built():
    with pytest.raises(BudgetExceededError, match="time limit"):
        build_grid(toy_trip(), 0.01, 400, SearchBudget(time_limit_s=1e-3))


def test_blocked_arcs_are_counted():
    grid = build_grid(toy_trip(), segment_m=0.25, speeds=10)
    assert grid.blocked.sum() > 0
    assert grid.blocked[-1] == 0
    assert len(all_paths(build_grid(toy_trip(), 1.0, 4).graph)) > 0


def test_a_limit_break_at_a_stop_is_harmless():
    limits = (SpeedLimit(0.0, 10.0), SpeedLimit(500.0, 20.0))
    assert build_grid(tram(limits, origin_m=500.0), 50.0, 10).level_mps[-1] > 10.0
    grid = build_grid(tram(limits, destination_m=500.0), 50.0, 10)
    assert grid.level_mps[-1] == 10.0


def test_a_real_line_replays(shared):
    trip = Trip(
        train=load_train(str(shared / "ttobench/trains/CH_Stadler_KISS_SBB.json")),
        track=load_track(str(shared / "ttobench/tracks/CH_StGallen_Wil.json")),
        origin_m=0.0,
        destination_m=29556.1,
    )
    grid = build_grid(trip, segment_m=1000.0, speeds=30)
    found = exact_front(grid, 1.3 * fastest_run(trip).duration_s, BUDGET)
    check_profiles(grid, found, np.linspace(0, len(found) - 1, 6).astype(int))
