"""railtoolkit: formations become one train, paths become tracks, and what is refused."""

import copy

import pytest

from tests.helpers.format_case import changed, write_json, yaml_text
from tests.helpers.railtoolkit_case import PATHS, PATHS_2024, ROLLING_STOCK, vehicle_changed
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_scenario, load_track, load_train
from tgvdp.model.track import Gradient, SpeedLimit
from tgvdp.model.train import BrakingRate

G = 9.80665


def written(tmp_path, tree, name="input.yaml"):
    path = tmp_path / name
    path.write_text(yaml_text(tree), encoding="utf-8")
    return path


def train_of(tmp_path, name, tree=ROLLING_STOCK):
    return load_train(f"{written(tmp_path, tree)}#{name}")


def refusal(tmp_path, tree, part=""):
    path = written(tmp_path, tree)
    with pytest.raises(InputError) as caught:
        load_scenario(f"{path}{part}")
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert line.isprintable()
    return line.removeprefix(f"{path}: ")


@pytest.mark.parametrize("kmh", [0.0, 30.0, 100.0, 180.0])
@pytest.mark.parametrize("name", ["IC", "G", "unit"])
def test_resistance_is_that_of_the_formulas(tmp_path, name, kmh):
    wind = ((kmh + 15) / 100) ** 2
    loco = G * (60 * 2.5 + 20 * 1.5 + 80 * 4.0 * wind)
    coach = G * 50 * (1.9 + 0.4 * kmh / 100 + 1.1 * wind)
    wagon = G * 80 * (1.4 + 5.7 * (kmh / 100) ** 2)
    railcar = G * (34 * 3.0 + 34 * 1.4 + 68 * 3.9 * wind)
    expected_n = {"IC": loco + 2 * coach, "G": 2 * loco + wagon, "unit": railcar}[name]
    assert train_of(tmp_path, name).resistance_n(kmh / 3.6) == pytest.approx(expected_n, rel=1e-12)


def test_a_passenger_train(tmp_path):
    train = train_of(tmp_path, "IC")
    assert train.name == "IC"
    assert (train.mass_kg, train.length_m, train.max_speed_mps) == (180e3, pytest.approx(72.8), 50.0)
    assert train.rotating_mass_factor == pytest.approx((80 * 1.09 + 80 * 1.06) / 160)  # empty masses
    assert train.braking_rates == (BrakingRate(0.0, 0.375),)
    assert [train.traction.effort_n(kmh / 3.6) for kmh in (0, 71.999, 72, 136, 200)] == pytest.approx(
        [300e3, 300e3, 250e3, 170e3, 90e3]
    )
    assert "Fast passenger: 1 × loco, 2 × coach" in train.notes
    assert "mass is with the full load of 20 t" in train.notes
    assert "a_braking is absent, taken as -0.375 m/s²: loco" in train.notes


def test_of_two_locomotives_the_first_drives(tmp_path):
    train = train_of(tmp_path, "Goods")  # by its name as well as by its id
    assert (train.name, train.mass_kg, train.max_speed_mps) == ("G", 240e3, pytest.approx(100 / 3.6))
    assert train.traction == train_of(tmp_path, "IC").traction
    assert train.braking_rates == (BrakingRate(0.0, 0.225),)
    assert train.rotating_mass_factor == pytest.approx((160 * 1.09 + 22 * 1.06) / 182)
    assert "driven by one loco alone, as TrainRuns.jl does; hauled without traction: 1 × loco" in train.notes
    assert "rotation_mass is absent, taken as 1.09 of powered vehicles, 1.06 of cars: wagon" in train.notes


def test_what_a_powered_vehicle_does_not_say_is_as_trainruns_takes_it(tmp_path):
    absent = ("rolling_resistance", "tractive_effort", "rotation_mass", "speed_limit", "air_resistance", "a_braking")
    tree = vehicle_changed(3, **dict.fromkeys(absent, ...))
    train = train_of(tmp_path, "unit", tree)
    assert train.traction.effort_n(0.0) == train.traction.effort_n(50.0) == pytest.approx(0.2 * G * 34_000)
    assert train.rotating_mass_factor == 1.09
    assert train.max_speed_mps == 140.0
    assert train.resistance_n(10.0) == pytest.approx(G * 34 * 3.0)
    assert train.braking_rates == (BrakingRate(0.0, 0.375),)
    assert train.notes[2:] == (
        "rotation_mass is absent, taken as 1.09 of powered vehicles, 1.06 of cars: railcar",
        "tractive_effort is absent, taken as 0.2 of the weight on driven axles: railcar",
        "a_braking is absent, taken as -0.375 m/s²: railcar",
        "speed_limit is absent, taken as 504 km/h",
    )


def test_coefficients_of_cars_are_the_mean_over_cars_and_their_masses_add_up(tmp_path):
    """As TrainRuns.jl has it: not weighed by mass; and one passenger car makes it a passenger train."""
    tree = changed(ROLLING_STOCK, ("trains", 0, "formation"), ["loco", "coach", "wagon", "wagon"])
    v_kmh, wind = 80.0, 0.95**2
    loco = G * (60 * 2.5 + 20 * 1.5 + 80 * 4.0 * wind)
    cars = G * (50 + 160) * ((1.9 + 2 * 1.4) / 3 + 0.4 / 3 * v_kmh / 100 + (1.1 + 2 * 5.7) / 3 * wind)
    assert train_of(tmp_path, "IC", tree).resistance_n(v_kmh / 3.6) == pytest.approx(loco + cars, rel=1e-12)


def test_the_brake_is_that_of_the_leading_vehicle(tmp_path):
    tree = changed(ROLLING_STOCK, ("trains", 2, "formation"), ["coach", "railcar"])
    tree["vehicles"][1]["a_braking"] = -0.3
    assert train_of(tmp_path, "unit", tree).braking_rates == (BrakingRate(0.0, 0.4),)


def test_paths_of_2022(tmp_path):
    path = written(tmp_path, PATHS)
    track = load_track(f"{path}#two")
    assert (track.name, track.length_m) == ("two", 10_000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(3000.0, 40.0))
    assert track.gradients == (Gradient(0.0, 0.0), Gradient(3000.0, -5.0))
    assert "points_of_interest are not used" in track.notes
    assert load_track(f"{path}#Level").length_m == 5000.0


def test_paths_of_2024_carry_speed_and_resistance_forward(tmp_path):
    track = load_track(written(tmp_path, PATHS_2024))
    assert track.length_m == 10_000.0
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(1000.0, 25.0), SpeedLimit(3000.0, 40.0))
    assert track.gradients == (Gradient(0.0, 0.0), Gradient(1000.0, 3.0), Gradient(3000.0, -5.0))
    assert "positions count from the start of the path at 500 m" in track.notes


@pytest.mark.parametrize("tree", [ROLLING_STOCK, PATHS, PATHS_2024])
def test_json_and_unquoted_versions_are_the_same(tmp_path, tree):
    unquoted = changed(tree, ("schema_version",), float(tree["schema_version"]))
    texts = {str(describe_file(path)) for path in (
        written(tmp_path, tree), written(tmp_path, unquoted), write_json(tmp_path / "input.json", tree)
    )}  # fmt: skip
    assert len(texts) == 1


def test_several_trains_in_one_file_are_a_choice(tmp_path):
    path = written(tmp_path, ROLLING_STOCK)
    description = describe_file(path)
    assert description.kind == "choice"
    assert [figure.name for figure in description.figures] == ["IC", "G", "unit"]
    assert all("mass" in str(figure.value) for figure in description.figures)
    assert describe_file(f"{path}#unit").kind == "train"
    with pytest.raises(InputError, match="holds 3 trains, choose one as FILE#NAME: IC, G, unit"):
        load_train(path)
    with pytest.raises(InputError, match=r"holds no train 'unti', did you mean 'unit'\?"):
        load_train(f"{path}#unti")
    with pytest.raises(InputError, match="holds a railtoolkit train, not a track"):
        load_track(f"{path}#unit")


def test_a_file_whose_name_holds_a_hash_is_reached_by_its_name(tmp_path):
    tree = changed(ROLLING_STOCK, ("trains",), ROLLING_STOCK["trains"][:1])
    assert load_train(written(tmp_path, tree, "train#1.yaml")).name == "IC"
    assert load_train(f"{written(tmp_path, tree, 'train#1.yaml')}#IC").name == "IC"


def test_a_native_scenario_refers_to_a_part_of_a_file(tmp_path):
    written(tmp_path, ROLLING_STOCK, "stock.yaml")
    written(tmp_path, PATHS, "paths.yaml")
    scenario = tmp_path / "scenario.toml"
    scenario.write_text('train = "stock.yaml#unit"\ntrack = "paths.yaml#level"\n')
    loaded = load_scenario(scenario)
    assert (loaded.train.name, loaded.track.name) == ("unit", "level")
    assert len(loaded.inputs) == 3


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (vehicle_changed(0, mass=...), "vehicles[0]: missing field 'mass'"),
        (vehicle_changed(0, mass=0), "vehicles[0].mass: must be"),
        (vehicle_changed(0, mass="80 t"), "vehicles[0].mass: must be a number, got '80 t'"),
        (vehicle_changed(0, mass=False), "vehicles[0].mass: must be a number, got False"),
        (vehicle_changed(0, mass_traction=81), "vehicles[0].mass_traction: must be at most the mass, 80 t, got 81 t"),
        (vehicle_changed(1, tractive_effort=[[0, 1]]), "vehicles[1].tractive_effort: a passenger vehicle has"),
        (vehicle_changed(0, tractive_effort=[[1, 5]]), "vehicles[0].tractive_effort: effort curve: the first point"),
        (vehicle_changed(0, tractive_effort=[[0, 5], [9, 4], [8, 3]]), "vehicles[0].tractive_effort: effort"),
        (vehicle_changed(0, tractive_effort=[[0, 5, 3]]), "vehicles[0].tractive_effort[0]: must be a list of length 2"),
        (vehicle_changed(0, tractive_effort=[[0, -5]]), "vehicles[0].tractive_effort[0][1]: must be a number >= 0"),
        (vehicle_changed(0, vehicle_type="lokomotive"), "vehicles[0].vehicle_type: unknown type 'lokomotive'"),
        (vehicle_changed(0, rotation_mass=0.09), "vehicles[0].rotation_mass: must be a number >= 1.0"),
        (vehicle_changed(3, a_braking=0.4), "vehicles[3].a_braking: must be a number < 0.0"),
        (vehicle_changed(1, id="loco"), "vehicles[1].id: 'loco' is given twice"),
        (vehicle_changed(0, load_limt=5), "vehicles[0]: unknown field 'load_limt', did you mean 'load_limit'?"),
        (changed(ROLLING_STOCK, ("trains", 0, "formation", 1), "caoch"), "trains[0].formation[1]: unknown vehicle"),
        (changed(ROLLING_STOCK, ("trains", 0, "formation"), []), "trains[0].formation: "),
        (changed(ROLLING_STOCK, ("trains", 0, "formation"), ["coach"]), "trains[0].formation: holds no vehicle of"),
        (changed(ROLLING_STOCK, ("trains", 1, "id"), "IC"), "trains[1].id: 'IC' is given twice"),
        (changed(ROLLING_STOCK, ("schema_version",), "2030.01"), "schema_version: rolling stock must be of 2022.05"),
        (changed(ROLLING_STOCK, ("schema_version",), 2024.07), "schema_version: rolling stock must be of 2022.05"),
        (changed(ROLLING_STOCK, ("vehicles",), ...), "is a railtoolkit file, but holds neither vehicles nor paths"),
    ],
    ids=lambda value: value[:40] if isinstance(value, str) else "",
)  # fmt: skip
def test_bad_rolling_stock(tmp_path, tree, message):
    assert refusal(tmp_path, tree, "#IC" if "trains[1]" not in message else "").startswith(message)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ((0, "characteristic_sections", 1, 0), 0.0, "[0].characteristic_sections[1]: position must increase, got 0 m"),
        ((0, "characteristic_sections", 1, 1), 0, "[0].characteristic_sections[1][1]: must be a number > 0"),
        ((0, "characteristic_sections", 1, 2), 1500, "[0].characteristic_sections[1][2]: must be a number < 1000"),
        ((0, "characteristic_sections", 1), [5, 6], "[0].characteristic_sections[1]: must be a list of length 3"),
        ((0, "characteristic_sections"), [[0, 5, 0]], "[0].characteristic_sections: "),
        ((0, "characteristic_sections", 0), {"position": 0}, "[0].characteristic_sections[0]: missing field 'speed'"),
        ((0, "characteristic_section"), [], "[0]: unknown field 'characteristic_section'"),
        ((1, "id"), "two", "[1].id: 'two' is given twice"),
        ((1, "id"), ..., "[1]: missing field 'id'"),
    ],
)
def test_bad_paths(tmp_path, place, value, message):
    if "unknown" in message:
        tree = copy.deepcopy(PATHS)
        tree["paths"][0]["characteristic_section"] = tree["paths"][0].pop("characteristic_sections")
        message = "[0]: missing field 'characteristic_sections'"
    else:
        tree = changed(PATHS, ("paths", *place), value)
    assert refusal(tmp_path, tree, "#two").startswith(f"paths{message}")


def test_extensions_are_listed(tmp_path):
    tree = vehicle_changed(0, colour="red")
    tree["vehicles"][1]["colour"] = "blue"
    assert "fields that are not part of the format: 'vehicles[].colour'" in train_of(tmp_path, "IC", tree).notes


@pytest.mark.parametrize(
    ("name", "limits", "gradients"), [("const", 1, {0.0}), ("slope", 11, {20.0, -10.0}), ("speed", 9, {0.0})]
)
def test_published_paths(shared, name, limits, gradients):
    track = load_track(shared / "railtoolkit" / "paths" / f"{name}.yaml")
    assert (track.name, track.length_m, len(track.speed_limits)) == (name, 10_000.0, limits)
    assert gradients <= {row.gradient_permil for row in track.gradients}


def test_published_train(shared):
    train = load_train(shared / "railtoolkit" / "trains" / "local.yaml")
    assert (train.name, train.mass_kg, train.length_m) == ("RB50-1", 88e3, 41.7)
    assert (train.rotating_mass_factor, train.max_speed_mps) == (1.08, pytest.approx(120 / 3.6))
    assert train.braking_rates == (BrakingRate(0.0, 0.4253),)
    assert train.traction.effort_n(50 / 3.6) == pytest.approx(32220)
    wind = (1.2 + 0.15) ** 2
    expected_n = G * (45.333 * 3.0 + (68 - 45.333) * 1.4 + 68 * 3.9 * wind)
    assert train.resistance_n(120 / 3.6) == pytest.approx(expected_n, rel=1e-12)
