"""TTOBench tracks: every unit, every field, and what is refused."""

import math

import pytest

from tests.helpers.format_case import TTOBENCH_TRACK, changed, quantity, write_json
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_track
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Tunnel


def track_of(tmp_path, *path_and_value):
    *path, value = path_and_value
    return load_track(write_json(tmp_path / "track.json", changed(TTOBENCH_TRACK, path, value)))


def test_track_in_si(tmp_path):
    track = load_track(write_json(tmp_path / "track.json", TTOBENCH_TRACK))
    assert (track.name, track.length_m, track.altitude_m) == ("toy", 10000.0, 100.0)
    assert track.stops_m == (0.0, 4000.0, 10000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(3000.0, 120 / 3.6))
    assert track.gradients == (Gradient(0.0, 5.0), Gradient(2000.0, -4.0))
    assert track.curves == (Curve(0, math.inf, math.inf), Curve(100, math.inf, -400), Curve(300, 500, 500))
    assert track.tunnels == (Tunnel(7000.0, 1050.0, 40.0),)


@pytest.mark.parametrize("field", ["altitude", "gradients", "curvatures", "tunnels"])
def test_optional_track_fields_mean_level_straight_and_open(tmp_path, field):
    track = track_of(tmp_path, field, ...)
    stored = {"altitude": "altitude_m", "curvatures": "curves"}.get(field, field)
    assert not getattr(track, stored)


def test_track_units_are_read(tmp_path):
    assert track_of(tmp_path, "gradients", "units", "slope", "‰").gradients[0].gradient_permil == 5.0
    assert track_of(tmp_path, "gradients", "units", "slope", "%").gradients[0].gradient_permil == 50.0
    assert track_of(tmp_path, "speed limits", "units", "velocity", "m/s").speed_limits[0].speed_mps == 90.0
    assert track_of(tmp_path, "altitude", quantity(0.5, "km")).altitude_m == 500.0
    in_km = changed(TTOBENCH_TRACK, ["stops"], {"unit": "km", "values": [0, 10]})
    assert load_track(write_json(tmp_path / "km.json", in_km)).length_m == 10000.0


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (["stops", "unit"], "stops.unit: unknown unit 'rad' of length; known: m, km"),
        (["altitude", "unit"], "altitude: unknown unit 'rad' of length"),
        (["speed limits", "units", "velocity"], "speed limits.units.velocity: unknown unit 'rad' of speed"),
        (["speed limits", "units", "position"], "speed limits.units.position: unknown unit 'rad' of length"),
        (["gradients", "units", "slope"], "gradients.units.slope: unknown unit 'rad' of gradient; known: permil, ‰, %"),
        (["curvatures", "units", "radius at end"], "curvatures.units.radius at end: unknown unit 'rad' of length"),
        (["tunnels", "units", "cross section"], "tunnels.units.cross section: unknown unit 'rad' of area; known: m^2"),
    ],
)
def test_unknown_units_of_tracks(tmp_path, path, message):
    with pytest.raises(InputError) as caught:
        track_of(tmp_path, *path, "rad")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["stops"], ..., "missing field 'stops'"),
        (["speed limits"], ..., "missing field 'speed limits'"),
        (["gradient"], {}, "unknown field 'gradient', did you mean 'gradients'?"),
        (["stops", "values"], [0.0], "stops: must begin at 0 and end at the track's length, got [0.0]"),
        (["stops", "values"], [5.0, 10.0], "stops: must begin at 0"),
        (["stops", "values", 1], -4000.0, "stops.values[1]: must increase, got -4000 m after 0 m"),
        (["stops", "values"], [0, 10000, 5000], "stops.values[2]: must increase, got 5000 m after 10000 m"),
        (["stops", "values", 1], "4000", "stops.values[1]: must be a number, got '4000'"),
        (["speed limits", "values"], [], "speed limits.values: must not be empty"),
        (["speed limits", "values", 1, 1], 0, "speed limits.values[1]: velocity must be above 0 km/h, got 0 km/h"),
        (["speed limits", "values", 1, 1], -80, "speed limits.values[1]: velocity must be above 0 km/h, got -80 km/h"),
        (["speed limits", "values", 0, 0], 10, "speed limits.values[0]: position must be 0 m, got 10 m"),
        (["speed limits", "values", 1, 0], 0, "speed limits.values[1]: position must increase, got 0 m after 0 m"),
        (["speed limits", "values", 1, 0], 10000, "position must lie before the last stop at 10000 m, got 10000 m"),
        (["speed limits", "values", 1], [3000], "speed limits.values[1]: must be a list of length 2, got 1 values"),
        (["speed limits", "units", "speed"], "m/s", "speed limits.units: unknown field 'speed'; known: position"),
        (["gradients", "values", 1, 0], -5, "gradients.values[1]: position must increase, got -5 m after 0 m"),
        (
            ["gradients", "values", 1, 1],
            1200,
            "gradients.values[1]: slope must be within ±1000 permil, got 1200 p",
        ),
        (["gradients", "values"], {}, "gradients.values: must be a list, got {}"),
        (["curvatures", "values", 0, 1], "straight", "curvatures.values[0]: radius at start must be a number or 'inf"),
        (["curvatures", "values", 2, 2], 0, "curvatures.values[2]: radius at end must not be 0 m"),
        (
            ["curvatures", "units", "position"],
            "km",
            "curvatures.values[1]: position must lie before the last stop at 10000 m, got 100 km",
        ),
        (
            ["tunnels", "values", 0, 1],
            4000,
            "tunnels.values[0]: must end before the last stop at 10000 m, ends at 11",
        ),
        (["tunnels", "values", 0, 1], -1, "tunnels.values[0]: length must be at least 0 m, got -1 m"),
        (["tunnels", "values", 0, 2], 0, "tunnels.values[0]: cross section must be above 0 m^2, got 0 m^2"),
        (
            ["tunnels"],
            {
                "units": {"position": "km", "length": "m", "cross section": "m^2"},
                "values": [[7, 1050, 40], [8, 100, 40]],
            },
            "tunnels.values[1]: position must not lie before 8.05 km, where the one before it ends, got 8 km",
        ),
        (["altitude", "value"], "high", "altitude.value: must be a number, got 'high'"),
    ],
)
def test_bad_tracks(tmp_path, path, value, message):
    with pytest.raises(InputError) as caught:
        track_of(tmp_path, *path, value)
    assert str(caught.value).startswith(f"{tmp_path / 'track.json'}: ")
    assert message in str(caught.value)


def test_successive_equal_values_are_fine(tmp_path):
    assert len(track_of(tmp_path, "speed limits", "values", [[0, 90], [5, 90]]).speed_limits) == 2


def test_what_is_read_but_not_used_is_said(tmp_path):
    track = track_of(tmp_path, "ETCS braking data", {"M_NVAVADH": 0.5})
    assert "ETCS braking data does not act" in str(describe_file(tmp_path / "track.json"))
    assert track.notes == ("ETCS braking data does not act",)
