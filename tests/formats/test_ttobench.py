"""TTOBench tracks and trains: every unit, every field, and what is refused."""

import json
import math
from dataclasses import replace

import pytest

from tests.helpers.format_case import TTOBENCH_TRACK, TTOBENCH_TRAIN, TTOBENCH_TRAIN_14, changed, quantity, write_json
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_track, load_train
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Tunnel
from tgvdp.model.train import BrakingRate, TunnelDrag

TRACKS = [
    "00_reference",
    "00_reference_with_tunnels",
    "00_var_gradient_minus_5",
    "00_var_gradient_plus_10",
    "00_var_speed_limit_100",
    "00_var_speed_limit_wind",
    "CH_StGallen_Wil",
    "CN_Songjiazhuang_Yizhuang",
]
TRAINS = ["CH_Stadler_KISS_SBB", "CN_Beijing_Subway"]


def train_of(tmp_path, *path_and_value):
    *path, value = path_and_value
    return load_train(write_json(tmp_path / "train.json", changed(TTOBENCH_TRAIN, path, value)))


def track_of(tmp_path, *path_and_value):
    *path, value = path_and_value
    return load_track(write_json(tmp_path / "track.json", changed(TTOBENCH_TRACK, path, value)))


def test_train_in_si(tmp_path):
    train = load_train(write_json(tmp_path / "train.json", TTOBENCH_TRAIN))
    assert train.name == "toy"
    assert (train.mass_kg, train.length_m, train.rotating_mass_factor) == (200e3, 150.0, 1.06)
    assert train.max_speed_mps == 40.0
    assert (train.max_acceleration_mps2, train.max_deceleration_mps2) == (1.0, math.inf)
    assert (train.davis_a_n, train.davis_b_n_per_mps) == (2000.0, pytest.approx(36.0))
    assert train.davis_c_n_per_mps2 == pytest.approx(6.48)
    assert [train.traction.effort_n(v) for v in (0, 20, 40)] == pytest.approx([200e3, 200e3, 100e3])
    assert [train.braking.effort_n(v) for v in (0, 20, 40)] == pytest.approx([150e3, 150e3, 75e3])
    assert train.friction_brake_n == 100e3
    assert (train.traction_efficiency, train.regeneration_efficiency) == (0.9, 0.0)


@pytest.mark.parametrize("version", ["TTOBench v9.0", "TTOBench v1.6", "TTOBench v1.10", "TTOBench v11.5", ""])
def test_other_versions_of_the_library_are_refused(tmp_path, version):
    for make in (train_of, track_of):
        with pytest.raises(InputError) as refused:
            make(tmp_path, "metadata", "library version", version)
        told = f"json: metadata.library version: must be TTOBench v1.1 to v1.5, got {version!r}"
        assert str(refused.value).endswith(told)
    assert track_of(tmp_path, "metadata", "library version", "TTOBench v1.1").name == "toy"


def test_track_in_si(tmp_path):
    track = load_track(write_json(tmp_path / "track.json", TTOBENCH_TRACK))
    assert (track.name, track.length_m, track.altitude_m) == ("toy", 10000.0, 100.0)
    assert track.stops_m == (0.0, 4000.0, 10000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(3000.0, 120 / 3.6))
    assert track.gradients == (Gradient(0.0, 5.0), Gradient(2000.0, -4.0))
    assert track.curves == (Curve(0, math.inf, math.inf), Curve(100, math.inf, -400), Curve(300, 500, 500))
    assert track.tunnels == (Tunnel(7000.0, 1050.0, 40.0),)


@pytest.mark.parametrize("field", ["length", "rho", "max pn braking force", "max acceleration", "efficiency traction"])
def test_optional_train_fields_have_neutral_defaults(tmp_path, field):
    train = train_of(tmp_path, field, ...)
    defaults = {
        "length": train.length_m == 0.0,
        "rho": train.rotating_mass_factor == 1.0,
        "max pn braking force": train.friction_brake_n == 0.0,
        "max acceleration": train.max_acceleration_mps2 == math.inf,
        "efficiency traction": train.traction_efficiency == 1.0,
    }
    assert defaults[field]


@pytest.mark.parametrize("field", ["altitude", "gradients", "curvatures", "tunnels"])
def test_optional_track_fields_mean_level_straight_and_open(tmp_path, field):
    track = track_of(tmp_path, field, ...)
    stored = {"altitude": "altitude_m", "curvatures": "curves"}.get(field, field)
    assert not getattr(track, stored)


@pytest.mark.parametrize(
    ("field", "value", "unit", "attribute", "expected"),
    [
        ("mass", 200_000, "kg", "mass_kg", 200e3),
        ("mass", 0.2, "t", "mass_kg", 200.0),
        ("max speed", 40, "m/s", "max_speed_mps", 40.0),
        ("max speed", 90, "km/h", "max_speed_mps", 25.0),
        ("length", 0.15, "km", "length_m", 150.0),
        ("max acceleration", 0.5, "m/s²", "max_acceleration_mps2", 0.5),
        ("max pn braking force", 5, "N", "friction_brake_n", 5.0),
        ("rolling resistance r0", 1770, "N", "davis_a_n", 1770.0),
        ("rolling resistance r1", 2, "N/(m/s)", "davis_b_n_per_mps", 2.0),
        ("rolling resistance r1", 2, "kN/(m/s)", "davis_b_n_per_mps", 2000.0),
        ("rolling resistance r1", 10, "N/(km/h)", "davis_b_n_per_mps", 36.0),
        ("rolling resistance r1", 1, "kN/(km/h)", "davis_b_n_per_mps", 3600.0),
        ("rolling resistance r2", 6, "N/(m/s)^2", "davis_c_n_per_mps2", 6.0),
        ("rolling resistance r2", 6, "N/(m/s)²", "davis_c_n_per_mps2", 6.0),
        ("rolling resistance r2", 2, "kN/(m/s)^2", "davis_c_n_per_mps2", 2000.0),
        ("rolling resistance r2", 1, "N/(km/h)^2", "davis_c_n_per_mps2", 12.96),
        ("rolling resistance r2", 1, "kN/(km/h)^2", "davis_c_n_per_mps2", 12960.0),
        ("efficiency traction", 0.9, "-", "traction_efficiency", 0.9),
        ("efficiency reg brake", 80, "%", "regeneration_efficiency", 0.8),
        ("rho", 10, "%", "rotating_mass_factor", 1.1),
        ("rho", 0, "%", "rotating_mass_factor", 1.0),
        ("rho", 1.06, "-", "rotating_mass_factor", 1.06),
        ("rho", 0.06, "-", "rotating_mass_factor", 1.06),
        ("rho", 1.5, "-", "rotating_mass_factor", 1.5),
    ],
)
def test_every_unit_is_read(tmp_path, field, value, unit, attribute, expected):
    assert getattr(train_of(tmp_path, field, quantity(value, unit)), attribute) == pytest.approx(expected, rel=1e-15)


def test_power_in_each_unit(tmp_path):
    for value, unit in ((4e6, "W"), (4e3, "kW"), (4, "MW")):
        assert train_of(tmp_path, "max traction power", quantity(value, unit)).traction.effort_n(40.0) == 1e5


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
        (["mass", "unit"], "mass: unknown unit 'furlong' of mass; known: kg, t"),
        (["max traction power", "unit"], "max traction power: unknown unit 'furlong' of power; known: W, kW, MW"),
        (["rho", "unit"], "rho: unknown unit 'furlong' of ratio; known: -, %"),
        (["rolling resistance r2", "unit"], "rolling resistance r2: unknown unit 'furlong' of force per squared speed"),
        (["num seats", "unit"], None),
    ],
)
def test_unknown_units_of_trains(tmp_path, path, message):
    if message is None:
        train_of(tmp_path, *path, "furlong")  # seats are not used, so neither is their unit
        return
    with pytest.raises(InputError, match=r"train.json: ") as caught:
        train_of(tmp_path, *path, "furlong")
    assert message in str(caught.value)


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
        (["mass"], ..., "missing field 'mass'"),
        (["mass", "unit"], ..., "mass: missing field 'unit'"),
        (["metadata"], ..., "missing field 'metadata'"),
        (["metadata", "id"], ..., "metadata: missing field 'id'"),
        (["max speed"], ..., "missing field 'max speed'"),
        (["max spead"], quantity(1, "m/s"), "unknown field 'max spead', did you mean 'max speed'?"),
        (["mass", "valeu"], 1, "mass: unknown field 'valeu', did you mean 'value'?"),
        (["colour"], "red", "unknown field 'colour'"),
        (["mass", "value"], "200", "mass.value: must be a number, got '200'"),
        (["mass", "value"], None, "mass.value: must be a number, got null"),
        (["mass", "value"], True, "mass.value: must be a number, got True"),
        (["mass", "unit"], 5, "mass.unit: must be text, got 5"),
        (["mass"], 200, "mass: must be a table, got 200"),
        (["mass", "value"], -5, "mass: must be above 0 t, got -5 t"),
        (["mass", "value"], 0, "mass: must be above 0 t, got 0 t"),
        (["max speed", "value"], 0, "max speed: must be above 0 km/h, got 0 km/h"),
        (["max traction force", "value"], 0, "max traction force: must be above 0 kN, got 0 kN"),
        (["max pn braking force", "value"], -1, "max pn braking force: must be at least 0 kN, got -1 kN"),
        (["rolling resistance r2", "value"], -1, "rolling resistance r2: must be at least 0 kN/(km/h)^2, got -1"),
        (["max acceleration", "value"], 0, "max acceleration: must be above 0 m/s^2"),
        (["rho", "value"], 106, "rho: must be 0..50 %, or 0..0.5 or 1..1.5 without unit, got 106 %"),
        (["rho"], quantity(0.7, "-"), "rho: must be 0..50 %"),
        (["rho"], quantity(-0.1, "-"), "rho: must be"),
        (["efficiency traction", "value"], 120, "efficiency traction: must be at most 100 %, got 120 %"),
        (["efficiency traction"], quantity(1.1, "-"), "efficiency traction: must be at most 1 -, got 1.1 -"),
        (["metadata", "id"], "two\nlines", "name must be one line of printable text"),
    ],
)
def test_bad_trains(tmp_path, path, value, message):
    with pytest.raises(InputError) as caught:
        train_of(tmp_path, *path, value)
    assert str(caught.value).startswith(f"{tmp_path / 'train.json'}: ")
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


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


def test_a_train_without_electric_brake(tmp_path):
    train = train_of(tmp_path, "max reg braking power", quantity(0, "kW"))
    assert train.braking.effort_n(10.0) == 0.0


def test_what_is_read_but_not_used_is_said(tmp_path):
    track = track_of(tmp_path, "ETCS braking data", {"M_NVAVADH": 0.5})
    assert "ETCS braking data does not act" in str(describe_file(tmp_path / "track.json"))
    assert track.notes == ("ETCS braking data does not act",)


def train_14(tmp_path, *path_and_value, part=""):
    *path, value = path_and_value or ["metadata", "id", "toy"]
    return load_train(f"{write_json(tmp_path / 'train.json', changed(TTOBENCH_TRAIN_14, path, value))}{part}")


def test_tunnel_resistance_by_cross_section(tmp_path):
    assert train_14(tmp_path).tunnel_drag == (
        TunnelDrag(22.5, pytest.approx(0.0011 * 12960)),
        TunnelDrag(40.0, pytest.approx(0.0005 * 12960)),
    )
    train = train_14(tmp_path, "tunnel resistance", "units", "coefficient", "kg/m")
    assert train.tunnel_drag[0] == TunnelDrag(22.5, 0.0011)


def test_etcs_data_do_not_act_unless_the_service_brake_is_asked_for(tmp_path):
    silent = train_14(tmp_path)
    assert silent.braking_rates == ()
    assert silent.notes == ("ETCS braking data does not act; FILE#A_brake_service brakes by its service brake",)
    asked = train_14(tmp_path, part="#A_brake_service")
    assert asked.braking_rates == (BrakingRate(0.0, 0.7), BrakingRate(20.0, 0.6))
    assert "the rest of it does not act" in asked.notes[0]
    assert replace(asked, braking_rates=()) == silent == train_14(tmp_path, part="#train")
    assert "0.6 to 0.7 m/s²" in str(describe_file(f"{tmp_path / 'train.json'}#A_brake_service"))
    with pytest.raises(InputError, match=r"holds no train 'A_brake', did you mean 'A_brake_service'\?"):
        train_14(tmp_path, part="#A_brake")
    with pytest.raises(InputError, match="holds no train 'A_brake_service'"):
        load_train(f"{write_json(tmp_path / 'plain.json', TTOBENCH_TRAIN)}#A_brake_service")


ETCS = "ETCS braking data"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (
            ["tunnel resistance"],
            {"40": quantity(1, "kN")},
            "tunnel resistance: unknown field '40'; known: units, values",
        ),
        (["tunnel resistance", "units", "coefficient"], "kN", "tunnel resistance.units.coefficient: unknown unit 'kN'"),
        (["tunnel resistance", "units", "cross section"], "m", "tunnel resistance.units.cross section: unknown unit"),
        (["tunnel resistance", "values", 1], [22.5, 1.0], "tunnel_drag[1] repeats the cross section 22.5 m²"),
        (["tunnel resistance", "values", 1], [22.5], "tunnel resistance.values[1]: must be a list of length 2, got 1"),
        ([ETCS, "A_brake_service"], ..., f"{ETCS}: missing field 'A_brake_service'"),
        ([ETCS, "T_traction"], ..., f"{ETCS}: missing field 'T_traction'"),
        ([ETCS, "T_brake"], quantity(1, "s"), f"{ETCS}: unknown field 'T_brake'; known: A_brake_emergency, A"),
        ([ETCS, "T_be", "unit"], "m", f"{ETCS}.T_be: unknown unit 'm' of time"),
        ([ETCS, "K_dry_rst", "unit"], "s", f"{ETCS}.K_dry_rst: unknown unit 's' of ratio"),
        ([ETCS, "A_brake_emergency", "values"], [], f"{ETCS}.A_brake_emergency.values: must be a list of length >= 1"),
        (
            [ETCS, "A_brake_emergency", "values", 1, 0],
            0,
            f"{ETCS}.A_brake_emergency.values[1]: velocity must increase, got 0 km/h after 0 km/h",
        ),
        ([ETCS, "A_brake_service", "values", 0, 1], 0, f"{ETCS}.A_brake_service.values[0][1]: must be a number > 0.0"),
        ([ETCS, "A_brake_service", "units", "velocity"], "kn", f"{ETCS}.A_brake_service.units.velocity: unknown unit"),
    ],
)
def test_bad_trains_of_version_14(tmp_path, path, value, message):
    with pytest.raises(InputError) as caught:
        train_14(tmp_path, *path, value)
    assert message in str(caught.value)


def test_an_efficiency_of_one_percent_is_kept_and_remarked(tmp_path):
    train = train_of(tmp_path, "efficiency traction", quantity(0.9, "%"))
    assert train.traction_efficiency == pytest.approx(0.009)
    assert train.notes == ("efficiency traction is 0.9 %, read as published: was 90 % meant?",)


@pytest.mark.parametrize("name", TRACKS)
def test_every_published_track_loads_with_its_values(shared, name):
    path = shared / "ttobench" / "tracks" / f"{name}.json"
    published = json.loads(path.read_text(encoding="utf-8"))
    track = load_track(path)
    assert track.name == name
    assert list(track.stops_m) == published["stops"]["values"]
    assert [[p, pytest.approx(v * 3.6, rel=1e-15)] for p, v in track.speed_limits] == published["speed limits"][
        "values"
    ]
    assert [list(row) for row in track.gradients] == published["gradients"]["values"]
    curves = [["infinity" if math.isinf(v) else v for v in row] for row in track.curves]
    assert curves == published.get("curvatures", {"values": []})["values"]
    assert [list(row) for row in track.tunnels] == published.get("tunnels", {"values": []})["values"]
    assert "km/h" in describe_file(path).headline


def test_the_tracks_seen_are_all_there_are(shared):
    assert sorted(path.stem for path in (shared / "ttobench" / "tracks").glob("*.json")) == TRACKS
    assert sorted(path.stem for path in (shared / "ttobench" / "trains").glob("*.json")) == TRAINS


def test_kiss_by_hand(shared):
    """Values converted by hand; r2 is used as published although it is twice the formula it cites."""
    train = load_train(shared / "ttobench" / "trains" / "CH_Stadler_KISS_SBB.json")
    assert (train.mass_kg, train.rotating_mass_factor) == (297e3, 1.1)
    assert train.traction.effort_n(0.0) == 400e3
    assert train.traction.effort_n(40.0) == pytest.approx(150e3)
    assert train.friction_brake_n == 2.97e6
    assert train.max_speed_mps * 3.6 == pytest.approx(160.0)
    assert train.davis_a_n == pytest.approx(5672.025)
    assert train.davis_b_n_per_mps == pytest.approx(91.61829)
    assert train.davis_c_n_per_mps2 == pytest.approx(15.6950784)
    assert (train.max_acceleration_mps2, train.max_deceleration_mps2) == (1.1, 1.1)
    assert (train.traction_efficiency, train.regeneration_efficiency) == (0.9, 0.9)


def test_beijing_by_hand(shared):
    train = load_train(shared / "ttobench" / "trains" / "CN_Beijing_Subway.json")
    assert (train.mass_kg, train.rotating_mass_factor, train.friction_brake_n) == (278e3, 1.0, 0.0)
    assert train.traction.effort_n(20.0) == pytest.approx(155e3)
    assert train.braking.effort_n(0.0) == 260e3
    assert train.braking.effort_n(20.0) == pytest.approx(216.65e3)
    assert train.davis_c_n_per_mps2 == pytest.approx(28.893024)
    assert train.davis_b_n_per_mps == 0.0
    assert train.max_acceleration_mps2 == math.inf


def test_st_gallen_wil_by_hand(shared):
    track = load_track(shared / "ttobench" / "tracks" / "CH_StGallen_Wil.json")
    assert (track.length_m, track.altitude_m) == (29556.1, 675.2)
    assert track.speed_limits[0] == SpeedLimit(0.0, 25.0)
    assert track.speed_limits[-1].speed_mps == pytest.approx(22.2222222222)
    assert track.curves[0] == Curve(0.0, 502.0, 502.0)
    assert track.gradients[0] == Gradient(0.0, 11.9)
