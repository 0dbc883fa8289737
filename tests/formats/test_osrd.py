"""OSRD rolling stock: both spellings of braking, both units of resistance, modes, and what is refused."""

import pytest

from tests.helpers.format_case import changed, write_json
from tests.helpers.osrd_case import OSRD_TRAIN
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_track, load_train
from tgvdp.model.train import BrakingRate


def train_of(tmp_path, *path_and_value, part=""):
    *path, value = path_and_value
    return load_train(f"{write_json(tmp_path / 'stock.json', changed(OSRD_TRAIN, path, value))}{part}")


def test_train_in_si(tmp_path):
    train = load_train(write_json(tmp_path / "stock.json", OSRD_TRAIN))
    assert (train.name, train.mass_kg, train.length_m, train.max_speed_mps) == ("toy", 200e3, 150.0, 40.0)
    assert train.rotating_mass_factor == 1.06
    assert (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) == (2000.0, 36.0, 6.48)
    assert train.braking_rates == (BrakingRate(0.0, 0.5),)
    assert train.max_acceleration_mps2 == float("inf")
    assert [train.traction.effort_n(v) for v in (0, 20, 25, 30, 40)] == [200e3, 200e3, 150e3, 100e3, 100e3]


def test_notes_say_what_was_chosen_and_what_is_not_used(tmp_path):
    notes = load_train(write_json(tmp_path / "stock.json", OSRD_TRAIN)).notes
    assert notes[0] == "resistance is taken to be in N, as A is above 1"
    assert notes[1] == "traction is that of mode '25000V'; FILE#MODE takes another one of 'thermal'"
    assert notes[2].startswith("traction is the mode's default curve; 1 more for comfort")
    assert notes[3] == "not used: comfort_acceleration, startup_time, startup_acceleration, power_restrictions"


@pytest.mark.parametrize(
    ("constant", "share"), [(2.4, "0.0012"), (0.000012, "0.0012"), (0.19, "19"), (2000.0, ""), (0.01, "")]
)
def test_a_resistance_that_no_train_has_is_told(tmp_path, constant, share):
    stock = OSRD_TRAIN | {"rolling_resistance": {"type": "davis", "A": constant, "B": 0.0, "C": 0.0}}
    note = load_train(write_json(tmp_path / "stock.json", stock)).notes[0]
    assert note.partition("; ")[2] == (f"that is {share} ‰ of the weight, not usual" if share else "")


def test_a_mode_is_chosen_by_its_name(tmp_path):
    train = load_train(f"{write_json(tmp_path / 'stock.json', OSRD_TRAIN)}#thermal")
    assert train.traction.effort_n(0.0) == 100e3
    assert describe_file(tmp_path / "stock.json").kind == "train"  # the default mode, no choice
    with pytest.raises(InputError, match=r"stock.json: holds no train 'diesel'; it holds: thermal, 25000V"):
        load_train(f"{tmp_path / 'stock.json'}#diesel")
    with pytest.raises(InputError, match="holds an OSRD train, not a track"):
        load_track(tmp_path / "stock.json")


def test_gamma_of_version_3_2(tmp_path):
    old = changed(OSRD_TRAIN, ("const_gamma",), ...) | {"railjson_version": "3.2"}
    path = write_json(tmp_path / "old.json", old | {"gamma": {"type": "CONST", "value": 0.7}})
    assert load_train(path).braking_rates == (BrakingRate(0.0, 0.7),)


def test_gamma_max_is_an_effort_beside_resistance_and_gradient(tmp_path):
    old = changed(OSRD_TRAIN, ("const_gamma",), ...) | {"railjson_version": "3.2"}
    train = load_train(write_json(tmp_path / "old.json", old | {"gamma": {"type": "MAX", "value": 0.7}}))
    assert train.braking_rates == ()
    assert train.friction_brake_n == pytest.approx(0.7 * 200e3 * 1.06)


def test_until_2023_the_version_was_called_version(tmp_path):
    old = changed(OSRD_TRAIN, ("railjson_version",), ...)
    assert load_train(write_json(tmp_path / "old.json", old | {"version": "3.1", "power_class": 5})).mass_kg == 200e3
    with pytest.raises(InputError, match=r"old\.json: version: must be one of 3.0, 3.1, .*, got '2.0'"):
        load_train(write_json(tmp_path / "old.json", old | {"version": "2.0"}))


def test_a_stock_with_metadata_is_not_taken_for_another_format(tmp_path):
    given = OSRD_TRAIN | {"metadata": {"id": "1", "library version": "1.4"}}
    assert load_train(write_json(tmp_path / "stock.json", given)).name == "toy"


def test_no_resistance_at_all_needs_no_unit(tmp_path):
    train = train_of(tmp_path, "rolling_resistance", {"type": "davis", "A": 0.0, "B": 0.0, "C": 0.0})
    assert (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) == (0.0, 0.0, 0.0)
    assert train.notes[0] == "the file gives no resistance: A, B and C are 0"


def test_resistance_per_kg(tmp_path):
    per_kg = {"type": "davis", "A": 0.01, "B": 1.8e-4, "C": 3.24e-5}
    train = train_of(tmp_path, "rolling_resistance", per_kg)
    assert (train.davis_a_n, train.davis_b_n_per_mps) == (2000.0, pytest.approx(36.0))
    assert train.davis_c_n_per_mps2 == pytest.approx(6.48)
    assert train.notes[0] == "resistance is taken to be in N/kg, as A is below 0.2"


@pytest.mark.parametrize("value", [0.0, 0.2, 0.5, 1.0])
def test_resistance_between_the_units_is_refused(tmp_path, value):
    with pytest.raises(InputError) as caught:
        train_of(tmp_path, "rolling_resistance", "A", value)
    assert "stock.json: rolling_resistance.A: neither above 1, as it is in N, nor between 0 and 0.2" in str(
        caught.value
    )
    assert "give A, B and C in one of the two, or the train as a native file" in str(caught.value)


def test_extensions_are_listed(tmp_path):
    assert "fields that are not part of the format: 'tilting'" in train_of(tmp_path, "tilting", True).notes


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("railjson_version",), "2.1", "railjson_version: must be one of 3.0, 3.1, 3.2, 3.3, 3.4, got '2.1'"),
        (("mass",), "200", "mass: must be a number in kg, got '200'"),
        (("mass",), True, "mass: must be a number in kg, got True"),
        (("mass",), 0, "mass: must be a number in kg > 0.0, got 0 kg"),
        (("mass",), 1e300, "mass: must be a number in kg within ±1e+12, got 1e+300 kg"),
        (("inertia_coefficient",), 0.06, "inertia_coefficient: must be a number >= 1"),
        (("inertia_coefficient",), ..., "missing field 'inertia_coefficient'"),
        (("const_gamma",), ..., "must hold one of const_gamma (since 3.3) and gamma (3.2), got none"),
        (("gamma",), {"type": "CONST", "value": 0.5}, "must hold one of const_gamma (since 3.3) and gamma (3.2), got"),
        (("const_gamma",), -0.5, "const_gamma: must be a number in m/s² > 0.0, got -0.5 m/s²"),
        (("rolling_resistance", "type"), "cubic", "rolling_resistance.type: must be 'davis', got 'cubic'"),
        (("effort_curves", "default_mode"), "15000V", "effort_curves.default_mode: must be one of 'thermal', '25000V'"),
        (("effort_curves", "modes"), {}, "effort_curves.modes: "),
        (
            ("effort_curves", "modes", "25000V", "default_curve", "speeds"),
            [0, 20],
            "effort_curves.modes.25000V.default_curve: must hold as many efforts as speeds, got 2 speeds and 3 efforts",
        ),
        (
            ("effort_curves", "modes", "25000V", "default_curve", "speeds"),
            [0, 20, 10],
            "effort_curves.modes.25000V.default_curve.speeds[2]: must not decrease, got 10 m/s after 20 m/s",
        ),
        (
            ("effort_curves", "modes", "25000V", "default_curve", "speeds"),
            [5, 20, 25],
            "effort_curves.modes.25000V.default_curve.speeds[0]: must be 0 m/s, got 5 m/s",
        ),
        (
            ("effort_curves", "modes", "25000V", "default_curve", "max_efforts", 1),
            None,
            "effort_curves.modes.25000V.default_curve.max_efforts[1]: must be a number in N, got null",
        ),
        (("comfort_aceleration",), 1, "unknown field 'comfort_aceleration', did you mean 'comfort_acceleration'?"),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_bad_files(tmp_path, path, value, message):
    tree = changed(OSRD_TRAIN, path, value)
    if path == ("comfort_aceleration",):
        del tree["comfort_acceleration"]
    file = write_json(tmp_path / "stock.json", tree)
    with pytest.raises(InputError) as caught:
        load_train(file)
    assert str(caught.value).startswith(f"{file}: {message}")
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("name", "part", "effort_n"),
    [("electric", "", 500e3), ("electric", "#1500V", 441666.6666666667), ("fast", "", 441666.6666666667)],
)
def test_published_files(shared, name, part, effort_n):
    train = load_train(f"{shared / 'osrd' / name}_rolling_stock.json{part}")
    assert (train.name, train.mass_kg, train.length_m) == (f"{name}_rolling_stock", 900e3, 400.0)
    assert (train.rotating_mass_factor, train.max_speed_mps) == (1.05, 80.0)
    assert train.braking_rates == (BrakingRate(0.0, 0.5),)
    assert (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) == (5400.0, 200.0, 12.0)
    assert train.traction.effort_n(0.0) == effort_n
