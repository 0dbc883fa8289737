"""The native scenario: TOML and JSON alike, references, run options, and what is refused."""

import json
import math
import tomllib
from pathlib import Path

import pytest

from tests.helpers.format_case import SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, write_json
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, input_digest, load_scenario, load_track, load_train
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Tunnel

TREE = tomllib.loads(SCENARIO)


@pytest.fixture
def scenario_file(tmp_path):
    path = tmp_path / "trip.toml"
    path.write_text(SCENARIO)
    return path


def test_scenario_in_si(scenario_file):
    scenario = load_scenario(scenario_file)
    train, track = scenario.train, scenario.track
    assert (scenario.name, scenario.format, train.name, track.name) == ("trip", "native", "trip", "trip")
    assert (train.mass_kg, train.max_speed_mps, train.friction_brake_n) == (200e3, 40.0, 100e3)
    assert (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) == (2000.0, 36.0, 6.48)
    assert (train.rotating_mass_factor, train.length_m, train.max_acceleration_mps2) == (1.0, 0.0, math.inf)
    assert [train.traction.effort_n(v) for v in (0, 40)] == pytest.approx([200e3, 100e3])
    assert [train.braking.effort_n(v) for v in (0, 5, 40)] == pytest.approx([0, 50e3, 100e3])
    assert track.stops_m == (0.0, 10_000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(3000.0, 120 / 3.6))
    assert track.gradients == (Gradient(0.0, 5.0),)
    assert track.curves == (Curve(0.0, math.inf, -400.0),)
    assert track.tunnels == (Tunnel(7000.0, 1050.0, 40.0),)
    assert scenario.options == {
        "from_m": 1000.0,
        "to_m": 9000.0,
        "start_speed_kmh": 36.0,
        "method": "exact",
        "points": 20,
        "dominance": False,
    }
    assert scenario.inputs == {str(scenario_file): input_digest(scenario_file)}


def test_json_holds_the_same(scenario_file, tmp_path):
    path = write_json(tmp_path / "trip.json", TREE)
    from_json, from_toml = load_scenario(path), load_scenario(scenario_file)
    assert (from_json.train, from_json.track, from_json.options) == (
        from_toml.train,
        from_toml.track,
        from_toml.options,
    )


def test_the_format_is_told_by_content_and_not_by_suffix(tmp_path):
    assert load_train(write_json(tmp_path / "train.txt", TREE)).mass_kg == 200e3
    path = tmp_path / "train.dat"
    path.write_text(SCENARIO)
    assert load_track(path).length_m == 10e3


def test_efforts_of_each_kind_agree(tmp_path):
    efforts = (
        {"force_kn": 100},
        {"points": [{"speed_kmh": 0, "effort_kn": 100}]},
        {"polynomials": [{"from_kmh": 0, "coefficients_n_kmh": [100_000]}]},
    )
    trains = [load_train(write_json(tmp_path / "t.json", changed(TREE, ["train", "traction"], e))) for e in efforts]
    assert trains[0] == trains[1] == trains[2]


def test_references_resolve_beside_the_file_and_in_the_catalog(tmp_path, monkeypatch):
    (tmp_path / "data").mkdir()
    track = write_json(tmp_path / "data" / "track.json", TTOBENCH_TRACK)
    path = tmp_path / "trip.toml"
    path.write_text('train = "tgv"\ntrack = "data/track.json"\n[run]\npoints = 7\n')
    monkeypatch.chdir("/")
    scenario = load_scenario(path)
    assert (scenario.train.name, scenario.track.name, scenario.options) == ("tgv", "toy", {"points": 7})
    assert scenario.inputs == {
        str(path): input_digest(path),
        "catalog:tgv": input_digest("tgv"),
        str(track): input_digest(track),
    }
    assert load_train(path).name == "tgv"
    assert load_track(path).name == "toy"


def test_a_reference_may_name_a_scenario_and_take_its_part(tmp_path, scenario_file):
    path = tmp_path / "other.toml"
    path.write_text('train = "trip.toml"\ntrack = "flat-100km"\n')
    assert load_scenario(path).train == load_train(scenario_file)


def test_only_what_is_asked_for_is_followed(tmp_path):
    path = tmp_path / "half.toml"
    path.write_text('train = "tgv"\ntrack = "absent.json"\n')
    assert load_train(path).name == "tgv"
    with pytest.raises(InputError, match=r"half.toml: track: .*absent.json: no such file"):
        load_track(path)


def test_references_in_a_circle(tmp_path):
    (tmp_path / "a.toml").write_text('train = "b.toml"')
    (tmp_path / "b.toml").write_text('train = "./a.toml"')
    with pytest.raises(InputError, match=r"a.toml: train: .*b.toml: train: the references go round in a circle"):
        load_train(tmp_path / "a.toml")


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ("tvg", "trip.toml: train: unknown train 'tvg', did you mean 'tgv'?"),
        ("lgv-100km", "trip.toml: train: 'lgv-100km' is a track, not a train"),
        ("", "trip.toml: train: expected the name of a train or a path, got an empty text"),
        ("./tgv", "no such file"),
        (".", "is a folder, not a file"),
    ],
)
def test_bad_references(tmp_path, reference, message):
    path = tmp_path / "trip.toml"
    path.write_text(f'train = "{reference}"')
    with pytest.raises(InputError) as caught:
        load_scenario(path)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["train", "mass_t"], ..., "train: missing field 'mass_t'"),
        (["train", "traction"], ..., "train: missing field 'traction'"),
        (["train", "davis_a_n"], ..., "train: missing field 'davis_a_n'"),
        (["train", "mass_kg"], 5, "train: unknown field 'mass_kg', did you mean 'mass_t'?"),
        (["train", "mass_t"], 0, "train.mass_t: must be a number > 0.0, got 0"),
        (["train", "mass_t"], -3.5, "train.mass_t: must be a number > 0.0, got -3.5"),
        (["train", "mass_t"], "200 t", "train.mass_t: must be a number, got '200 t'"),
        (["train", "mass_t"], [1], "train.mass_t: must be a number, got [1]"),
        (["train", "max_speed_kmh"], 0, "train.max_speed_kmh: must be a number > 0.0, got 0"),
        (["train", "rotating_mass_factor"], 0.06, "train.rotating_mass_factor: must be a number >= 1.0, got 0.06"),
        (["train", "traction"], {}, "train.traction: must hold exactly one of force_kn"),
        (["train", "traction"], {"power_kw": 5}, "exactly one of force_kn (with power_kw or without), points, polynom"),
        (["train", "traction"], {"force_kn": 5, "points": []}, "exactly one of"),
        (["train", "traction"], {"points": []}, "train.traction: effort curve: the first point must be at 0 m/s"),
        (["train", "traction"], {"force": 5}, "train.traction: unknown field 'force', did you mean 'force_kn'?"),
        (
            ["train", "traction"],
            {"polynomials": [{"from_kmh": 0, "coefficients_n_kmh": [1, 2, 3, 4, 5]}]},
            "train.traction.polynomials[0].coefficients_n_kmh: must be a list of length <= 4, got 5 values",
        ),
        (
            ["train", "traction"],
            {"polynomials": [{"from_kmh": 0, "coefficients_n_kmh": [1000, -100]}]},
            "traction: effort must be at least 0 N, got -13400 N at 40 m/s",
        ),
        (["track", "length_m"], 0, "track.length_m: must be a number > 0.0, got 0"),
        (["track", "speed_limits"], [], "speed_limits must not be empty"),
        (
            ["track", "speed_limits", 1, "speed_kmh"],
            0,
            "track.speed_limits[1].speed_kmh: must be a number > 0.0, got 0",
        ),
        (
            ["track", "speed_limits", 1, "speed"],
            5,
            "track.speed_limits[1]: unknown field 'speed', did you mean 'speed_k",
        ),
        (["track", "speed_limits", 1, "from_m"], -1, "track.speed_limits[1].from_m: must be a number >= 0.0, got -1"),
        (["track", "speed_limits", 1, "from_m"], 10_000, "speed_limits[1].position must be below the line's length"),
        (["track", "speed_limits", 1, "from_m"], 0, "speed_limits[1].position must increase, got 0 m after 0 m"),
        (["track", "speed_limits", 0], [0, 90], "track.speed_limits[0]: must be a table, got [0, 90]"),
        (
            ["track", "curves", 0, "radius_end_m"],
            "round",
            "curves[0].radius_end_m: must be a number or 'infinity'",
        ),
        (["track", "stops_m"], [0, 20_000], "stops[1] must be within the line's 10000 m, got 20000 m"),
        (
            ["train", "braking_rates"],
            [{"from_kmh": 0, "deceleration_mps2": 0.5}, {"from_kmh": 0, "deceleration_mps2": 0.6}],
            "train.braking_rates[1].from_kmh: must not be given more than once, got 0 km/h",
        ),
        (
            ["train", "traction"],
            {"points": [{"speed_kmh": speed, "effort_kn": 9} for speed in (0, 100, 50)]},
            "train.traction: points[2].speed_kmh: must rise, got 50 km/h after 100 km/h",
        ),
        (
            ["train", "traction"],
            {"points": [{"speed_kmh": speed, "effort_kn": 9} for speed in (0, 50, 50, 50)]},
            "train.traction: points[3].speed_kmh: must not be given more than twice, got 50 km/h",
        ),
        (
            ["train", "braking"],
            {"polynomials": [{"from_kmh": 36, "coefficients_n_kmh": [9e3]}]},
            "train.braking: polynomials[0].from_kmh: must be 0 km/h, got 36 km/h",
        ),
        (
            ["train", "adhesion"],
            {"adhesive_mass_t": 500},
            "train.adhesion.adhesive_mass_t: must be at most train.mass_t, 200 t, got 500 t",
        ),
        (["track", "gradients", 0, "gradient_permil"], 5000, "gradient must be within ±1000 ‰, got 5000 ‰"),
        (["track", "name"], "", "name must be one line of printable text"),
        (["run", "point"], 5, "run: unknown field 'point', did you mean 'points'?"),
        (["run", "points"], 1, "run.points: must be a whole number >= 2, got 1"),
        (["run", "points"], 20.5, "run.points: must be a whole number, got 20.5"),
        (["run", "max_margin_pct"], 0, "run.max_margin_pct: must be a number > 0.0, got 0"),
        (["run", "method"], "exakt", "run.method: unknown method 'exakt', did you mean 'exact'?"),
        (["run", "heuristic"], "magic", "run.heuristic: unknown heuristic 'magic'; known: ratio, time, energy"),
        (["run", "start_speed_kmh"], -1, "run.start_speed_kmh: must be a number >= 0.0, got -1"),
        (["run", "time_limit_s"], 0, "run.time_limit_s: must be a number > 0.0, got 0"),
        (["run", "dominance"], 1, "run.dominance: must be true or false, got 1"),
        (["run", "to_m"], 500, "run.to_m: must lie after run.from_m, got 500 m after 1000 m"),
        (["run", "to_m"], 10_500, "run.to_m: must lie within the track's 10000 m, got 10500 m"),
        (["run"], {"from_m": 10_000}, "run.from_m: must lie before the destination at 10000 m, got 10000 m"),
        (["train"], 5, "train: must be text or a table, got 5"),
        (["name"], "", "name must be one line"),
        (["trian"], {}, "unknown field 'trian', did you mean 'train'?"),
    ],
)
def test_bad_scenarios(tmp_path, path, value, message):
    file = write_json(tmp_path / "trip.json", changed(TREE, path, value))
    with pytest.raises(InputError) as caught:
        load_scenario(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[trian]\nmass_t = 5", "got 'trian', did you mean 'train'?"),
        ("name = 'only a name'", "nor what TTOBench, railtoolkit and OSRD files hold, got 'name'"),
        ('{"metadata": {"id": "x"}}', "is no TTOBench train, track or journey"),
        ('{"mass": 5, "max_speed": 80, "length": 3}', "holds none of train, track, map and run"),
        ('{"id": "a", "params": {"kind": "binary"}}', "is an instance of the formulations, which tgvdp solve takes"),
        ('{"schema": "tgvdp.search/1", "trip": {}}', "is a result of tgvdp, 'tgvdp.search/1', and no train or line"),
        ("{}", "got nothing"),
    ],
)
def test_content_of_no_known_kind(tmp_path, content, message):
    path = tmp_path / "input"
    path.write_text(content)
    with pytest.raises(InputError) as caught:
        describe_file(path)
    assert message in str(caught.value)


def test_a_file_of_the_other_kind_says_what_it_holds(tmp_path, scenario_file):
    track = write_json(tmp_path / "track.json", TTOBENCH_TRACK)
    train = write_json(tmp_path / "train.json", TTOBENCH_TRAIN)
    native = write_json(tmp_path / "native.json", {"track": TREE["track"]})
    run = write_json(tmp_path / "run.json", {"run": {"points": 5}})
    for load, path, message in (
        (load_train, track, "track.json: holds a TTOBench track, not a train"),
        (load_track, train, "train.json: holds a TTOBench train, not a track"),
        (load_train, native, "native.json: holds a track, not a train"),
        (load_track, run, "run.json: holds run options, not a track"),
        (load_train, "lgv-100km", "'lgv-100km' is a track, not a train"),
        (load_track, "lgv-10km", "unknown track 'lgv-10km', did you mean 'lgv-100km'?"),
        (load_train, "zzz", "unknown train 'zzz' (built in: alstom-emu, tgv; or give a file)"),
        (load_train, "tgv.json", "tgv.json: no such file"),
        (load_train, 5, "expected the name of a train or a path, got 5"),
    ):
        with pytest.raises(InputError) as caught:
            load(path)
        assert message in str(caught.value)


def test_a_bare_name_is_a_file_where_the_catalog_has_none(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_json(tmp_path / "mine", {"track": TREE["track"]})
    write_json(tmp_path / "flat-100km", {"track": TREE["track"]})
    assert load_track("mine").length_m == 10_000.0
    assert load_track("flat-100km").length_m == 100_000.0  # the catalog comes first
    assert load_track("./flat-100km").length_m == 10_000.0


def test_run_options_alone_are_a_legal_file(tmp_path):
    scenario = load_scenario(write_json(tmp_path / "run.json", {"run": {"points": 5}}))
    assert (scenario.train, scenario.track, scenario.options) == (None, None, {"points": 5})


def test_descriptions_give_the_figures_an_engineer_checks(scenario_file, tmp_path):
    description = describe_file(scenario_file)
    assert (description.kind, description.format, description.name) == ("scenario", "native", "trip")
    figures = {figure.name: str(figure) for figure in description.figures}
    assert figures["mass"] == "200 t"
    assert figures["top speed"] == "144 km/h"
    assert figures["starting acceleration"] == "0.99 m/s²"
    assert figures["power to mass"] == "20 W/kg"
    assert figures["speed limits"] == "2, 90 to 120 km/h"
    assert figures["net height"] == "50 m"
    assert figures["run method"] == "exact"
    text = str(description)
    assert text.startswith("scenario trip (native)\n")
    assert "  stops" in text
    assert describe_file(write_json(tmp_path / "run.json", {"run": {"points": 5}})).kind == "run options"


def test_toy_numbers_survive_the_units(tmp_path):
    tree = {
        "train": {
            "mass_t": 0.001,
            "max_speed_kmh": 3.6,
            "davis_a_n": 0,
            "davis_b_n_per_kmh": 0,
            "davis_c_n_per_kmh2": 0,
            "traction": {"force_kn": 0.001},
        },
        "track": {"length_m": 2, "speed_limits": [{"from_m": 0, "speed_kmh": 3.6}]},
    }
    scenario = load_scenario(write_json(tmp_path / "toy.json", tree))
    assert (scenario.train.mass_kg, scenario.train.max_speed_mps, scenario.track.length_m) == (1.0, 1.0, 2.0)
    assert scenario.train.traction.effort_n(1.0) == 1.0


def test_the_example_of_the_documentation_is_valid(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    examples = [block.split("```")[0] for block in page.split("```toml\n")[1:]]
    assert examples
    for example in examples:
        path = tmp_path / "example.toml"
        path.write_text(example)
        assert load_scenario(path).train is not None


def test_values_too_long_for_a_line_are_cut(tmp_path):
    path = write_json(tmp_path / "long.json", changed(TREE, ["train", "mass_t"], "x" * 10_000))
    with pytest.raises(InputError) as caught:
        load_train(path)
    assert len(str(caught.value)) < 300 + len(str(path))
    assert json.dumps(str(caught.value))
