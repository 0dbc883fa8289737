"""Train, Track and Trip check themselves, whatever they are built from."""

import math
import pickle

import numpy as np
import pytest

from tgvdp.errors import InputError
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track, Tunnel
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip

CAPS = EffortCurve.from_caps(100e3, 2e6)


def a_train(**changes):
    return Train(**{"mass_kg": 1e5, "traction": CAPS, "max_speed_mps": 40.0, "name": "test"} | changes)


def a_track(**changes):
    return Track(**{"length_m": 1000.0, "speed_limits": [(0.0, 30.0)], "name": "test"} | changes)


@pytest.mark.parametrize(
    "field",
    [
        "mass_kg",
        "friction_brake_n",
        "rotating_mass_factor",
        "length_m",
        "davis_a_n",
        "davis_b_n_per_mps",
        "davis_c_n_per_mps2",
        "max_acceleration_mps2",
        "max_deceleration_mps2",
        "max_speed_mps",
        "traction_efficiency",
        "regeneration_efficiency",
    ],
)
@pytest.mark.parametrize("value", [math.nan, -math.inf, -1.0, "12", None, True, 1e300, 10**400])
def test_train_rejects_bad_numbers_by_field_name(field, value):
    with pytest.raises(InputError, match=f"train test: {field} must be") as caught:
        a_train(**{field: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("field", ["mass_kg", "max_acceleration_mps2", "max_speed_mps", "traction_efficiency"])
def test_train_rejects_zero_where_it_makes_no_sense(field):
    with pytest.raises(InputError, match=f"{field} must be above 0"):
        a_train(**{field: 0.0})


def test_train_rejects_efficiency_above_one_and_an_inertia_below_the_mass():
    with pytest.raises(InputError, match="traction_efficiency must be at most 1, got 90"):
        a_train(traction_efficiency=90.0)
    with pytest.raises(InputError, match=r"rotating_mass_factor must be at least 1 -, got 0\.06"):
        a_train(rotating_mass_factor=0.06)


def test_train_needs_traction_at_standstill():
    with pytest.raises(InputError, match="traction must be above 0 N at standstill"):
        a_train(traction=EffortCurve.from_caps(0.0))
    with pytest.raises(InputError, match="traction must be an EffortCurve"):
        a_train(traction=100e3)


def test_train_looks_for_negative_effort_up_to_its_top_speed_only():
    falling = EffortCurve(((0.0, 0.0, 1000.0, -20.0),))  # 0 N at 50 m/s
    assert a_train(traction=falling, max_speed_mps=50.0).traction.effort_n(50.0) == 0.0
    with pytest.raises(InputError, match="traction: effort must be at least 0 N, got -20 N at 51 m/s"):
        a_train(traction=falling, max_speed_mps=51.0)


def test_numbers_of_any_kind_become_floats():
    train = a_train(mass_kg=np.int64(7), length_m=np.float32(2.5), max_speed_mps=np.array(40)[()])
    assert (train.mass_kg, train.length_m) == (7.0, 2.5)
    assert type(train.mass_kg) is type(train.length_m) is type(train.max_speed_mps) is float
    track = a_track(length_m=2000, speed_limits=[[0, 30]], gradients=np.array([[0, 5], [500, -5]]), stops_m=[0, 2000])
    assert type(track.length_m) is type(track.speed_limits[0].speed_mps) is type(track.stops_m[0]) is float
    assert track.gradients == (Gradient(0.0, 5.0), Gradient(500.0, -5.0))
    trip = Trip(train=train, track=track, origin_m=0, destination_m=2000)
    assert type(trip.origin_m) is float


def test_models_are_frozen_hashable_and_travel_to_other_processes():
    train, track = a_train(), a_track()
    with pytest.raises(AttributeError):
        train.mass_kg = 1.0
    assert hash(train) == hash(a_train())
    assert pickle.loads(pickle.dumps(track)) == track
    again = pickle.loads(pickle.dumps(train))
    assert again == train
    assert np.array_equal(again.traction.table, train.traction.table)


def test_a_toy_scale_is_legal():
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0)
    track = Track(length_m=2.0, speed_limits=((0.0, 1.0),))
    assert Trip(train=train, track=track, origin_m=0.0, destination_m=2.0).distance_m == 2.0
    assert train.inertia_kg == 1.0
    assert train.resistance_n(3.0) == 0.0


def test_resistance_is_the_davis_formula():
    train = a_train(davis_a_n=1000.0, davis_b_n_per_mps=20.0, davis_c_n_per_mps2=3.0, rotating_mass_factor=1.1)
    assert train.resistance_n(10.0) == 1000.0 + 200.0 + 300.0
    assert train.inertia_kg == pytest.approx(1.1e5)


@pytest.mark.parametrize("name", ["", " ", "two\nlines", "\x1b[31mred", "x" * 501, None, 5])
def test_names_and_notes_are_single_printable_lines(name):
    for build in (a_train, a_track):
        with pytest.raises(InputError, match="name must be one line"):
            build(name=name)
        with pytest.raises(InputError, match="notes"):
            build(notes=(name,))
    with pytest.raises(InputError, match="notes must be a list"):
        a_train(notes="just text")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"length_m": 0.0}, "length_m must be above 0 m"),
        ({"length_m": math.inf}, "length_m must be finite"),
        ({"altitude_m": math.nan}, "altitude_m must be finite"),
        ({"speed_limits": ()}, "speed_limits must not be empty"),
        ({"speed_limits": [(0.0, 0.0)]}, r"speed_limits\[0\].speed must be above 0 m/s, got 0 m/s"),
        ({"speed_limits": [(0.0, -5.0)]}, r"speed_limits\[0\].speed must be above 0 m/s, got -5 m/s"),
        ({"speed_limits": [(5.0, 10.0)]}, "speed_limits must start at 0 m, got 5 m"),
        ({"speed_limits": [(0.0, 10.0), (-5.0, 9.0)]}, r"speed_limits\[1\].position must be at least 0 m, got -5 m"),
        ({"speed_limits": [(0.0, 10.0), (9.0, 9.0), (8.0, 9.0)]}, r"\[2\].position must increase, got 8 m after 9 m"),
        ({"speed_limits": [(0.0, 10.0), (9.0, 9.0), (9.0, 8.0)]}, r"\[2\].position must increase"),
        ({"speed_limits": [(0.0, 10.0), (1000.0, 9.0)]}, r"\[1\].position must be below the line's length 1000 m"),
        ({"speed_limits": [(0.0,)]}, r"speed_limits\[0\] must be \(position_m, speed_mps\), got 1 values"),
        ({"speed_limits": [5.0]}, r"speed_limits\[0\] must be \(position_m, speed_mps\), got 5.0"),
        ({"speed_limits": "fast"}, "speed_limits must be a list of"),
        ({"speed_limits": [("0", 10.0)]}, r"speed_limits\[0\].position must be a number in m, got '0'"),
        ({"gradients": [(0.0, math.nan)]}, r"gradients\[0\].gradient must be finite"),
        ({"gradients": [(0.0, 1000.0)]}, r"gradients\[0\].gradient must be within ±1000 ‰"),
        ({"gradients": [(1.0, 3.0)]}, "gradients must start at 0 m"),
        ({"curves": [(0.0, 0.0, 300.0)]}, r"curves\[0\].radius must not be 0 m"),
        ({"curves": [(0.0, math.nan, 300.0)]}, r"curves\[0\].radius must be finite"),
        ({"stops_m": (0.0, 1000.1)}, r"stops\[1\] must be within the line's 1000 m, got 1000.1 m"),
        ({"stops_m": (5.0, 5.0)}, r"stops\[1\] must increase, got 5 m after 5 m"),
        ({"stops_m": (-5.0, 5.0)}, r"stops\[0\] must be at least 0 m"),
        ({"stops_m": 5.0}, "stops must be a list of positions"),
        ({"tunnels": [(100.0, 50.0, 0.0)]}, r"tunnels\[0\].cross_section must be above 0 m²"),
        ({"tunnels": [(100.0, -50.0, 40.0)]}, r"tunnels\[0\].length must be at least 0 m"),
        ({"tunnels": [(100.0, 950.0, 40.0)]}, r"tunnels\[0\] must end within the line's 1000 m, ends at 1050 m"),
        ({"tunnels": [(100.0, 50.0, 40.0), (149.0, 5.0, 40.0)]}, r"tunnels\[1\].position must not lie before the end"),
    ],
)
def test_track_says_what_is_wrong(changes, message):
    with pytest.raises(InputError, match=message):
        a_track(**changes)


def test_track_stores_rows_as_named_tuples_and_fills_in_its_ends_as_stops():
    track = a_track(curves=[(0, math.inf, -300), (10, -300, 500)], tunnels=[(1, 2, 40)])
    assert track.stops_m == (0.0, 1000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 30.0),)
    assert track.curves[1] == Curve(10.0, -300.0, 500.0)
    assert track.tunnels == (Tunnel(1.0, 2.0, 40.0),)


def test_tunnels_that_meet_in_decimals_do_not_overlap_in_binary():
    # 0.1 + 0.2 > 0.3 in float64, and so is the end of the second tunnel past the line's end.
    track = Track(length_m=0.3, speed_limits=((0.0, 1.0),), tunnels=((0.0, 0.1, 40.0), (0.1, 0.2, 24.0)))
    assert len(track.tunnels) == 2
    meeting = ((0.0, 0.1, 40.0), (0.1, 0.2, 24.0), (0.3, 0.1, 40.0))
    assert len(Track(length_m=1.0, speed_limits=((0.0, 1.0),), tunnels=meeting).tunnels) == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"origin_m": -1.0}, "origin_m must be at least 0 m, got -1 m"),
        ({"origin_m": math.nan}, "origin_m must be finite"),
        ({"destination_m": 1000.5}, "destination must lie within the line's 1000 m, got 1000.5 m"),
        ({"origin_m": 500.0, "destination_m": 400.0}, "destination must lie after the origin, got 400 m after 500 m"),
        ({"origin_m": 500.0, "destination_m": 500.0}, "destination must lie after the origin"),
        ({"start_speed_mps": -1.0}, "start_speed_mps must be at least 0 m/s"),
        ({"end_speed_mps": math.inf}, "end_speed_mps must be finite"),
    ],
)
def test_trip_says_what_is_wrong(changes, message):
    with pytest.raises(InputError, match=message):
        Trip(**{"train": a_train(), "track": a_track(), "origin_m": 0.0, "destination_m": 1000.0} | changes)
