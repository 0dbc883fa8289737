"""TTOBench trains: every unit, every field, and what is refused."""

import math
from dataclasses import replace

import pytest

from tests.helpers.format_case import TTOBENCH_TRAIN, TTOBENCH_TRAIN_14, changed, quantity, write_json
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_train
from tgvdp.model.train import BrakingRate, TunnelDrag


def train_of(tmp_path, *path_and_value):
    *path, value = path_and_value
    return load_train(write_json(tmp_path / "train.json", changed(TTOBENCH_TRAIN, path, value)))


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


def test_a_train_without_electric_brake(tmp_path):
    train = train_of(tmp_path, "max reg braking power", quantity(0, "kW"))
    assert train.braking.effort_n(10.0) == 0.0


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
