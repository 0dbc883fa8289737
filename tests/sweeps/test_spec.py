"""From a spec to scenarios and their rows: what varies, in which order, under which names; and what is no spec."""

import csv
import hashlib
import json

import pytest

from tests.helpers.sweep_case import COUNT, SPEC, write_case
from tgvdp import InputError, journey, load_track, load_train, search
from tgvdp.cli import main
from tgvdp.formats.native.changes import changed
from tgvdp.sweeps.journal import Journal
from tgvdp.sweeps.parts import write_part
from tgvdp.sweeps.read import read_spec
from tgvdp.sweeps.scenario import task_of
from tgvdp.sweeps.tables import write_tables
from tgvdp.sweeps.work import solve

HEAD = SPEC.partition("[product]")[0]


def tables_of(spec, folder):
    """Tables of a sweep that is solved here, in a single part."""
    pytest.importorskip("pyarrow")
    pytest.importorskip("distributed")
    folder.mkdir()
    journal = Journal(folder / "journal.sqlite")
    journal.enrol((scenario.key("engine") for scenario in spec), "plan")
    records = [solve(task_of(spec[number], id)) for id, number in journal.pending()]
    write_part(folder, 0, records)
    journal.commit(records, 0)
    files = write_tables(spec, journal, folder, folder / "out")
    journal.close()
    return {file.relative_to(folder / "out").as_posix() for file in files}


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_lines_change_slowest_and_the_last_axis_fastest(tmp_path):
    spec = read_spec(write_case(tmp_path))
    assert (len(spec), len(list(spec))) == (COUNT, COUNT)
    named = [(one.line.name, one.section.name, *one.parameters.values()) for one in spec]
    assert named[:4] == [("east", "0-900", 180, wind) for wind in (0, 10, 20)] + [("east", "0-900", 200, 0)]
    assert named[9][:2] == ("east", "900-2000")
    assert named[-1] == ("west", "1100-1900", 220, 20)
    assert len({one.key("engine") for one in spec}) == COUNT
    assert spec[5].key("engine") != spec[5].key("another engine")


def test_values_of_a_zip_go_along_with_each_other(tmp_path):
    axes = '"train.mass_t" = ["90%", "110%"]\n"train.traction_efficiency_pct" = [80, 90]\n'
    spec = read_spec(write_case(tmp_path, f"{HEAD}[product]\nwind_kmh = [0, 5]\n[[zip]]\n{axes}"))
    assert [tuple(one.parameters.values()) for one in spec[:4]] == [
        (0, "90%", 80), (0, "110%", 90), (5, "90%", 80), (5, "110%", 90),
    ]  # fmt: skip
    assert spec[0].changes == ("train.mass_t=90%", "train.traction_efficiency_pct=80")


def test_a_default_that_is_written_out_is_the_same_scenario(tmp_path):
    spec = read_spec(write_case(tmp_path, f"{HEAD}[product]\nwind_kmh = [0]\n"))
    plain = read_spec(write_case(tmp_path / "plain", HEAD))
    assert [one.key("") for one in spec] == [one.key("") for one in plain]


@pytest.mark.parametrize("sections", ['"stops"', '["0:1100", "1100:1900"]'])
def test_positions_in_the_other_direction_are_those_of_the_single_command(tmp_path, capsys, sections):
    """Sections and speed restrictions count from what was the line's end."""
    run = 'points = 5\nreverse = true\nspeed_restriction = ["300:600:40"]'
    text = HEAD.replace('"stops"', sections).replace('"lines"', '"lines/east.toml"').replace("points = 5", run)
    tables_of(read_spec(write_case(tmp_path, text)), tmp_path / "out")
    fronts = rows_of(tmp_path / "out" / "out" / "fronts.csv")
    for from_m, to_m in ((0, 1100), (1100, 2000 if sections == '"stops"' else 1900)):
        own = [row for row in fronts if row["section"] == f"{from_m}-{to_m}"]
        files = ["--train", str(tmp_path / "metro.toml"), "--track", str(tmp_path / "lines" / "east.toml")]
        words = ["--points", "5", "--max-margin", "10", "--from", str(from_m), "--to", str(to_m), "--reverse"]
        slow = ["--speed-restriction", "300:600:40", "--no-pictures", "--json", "--out", str(tmp_path / f"{from_m}")]
        assert main(["search", *files, *words, *slow]) == 0
        front = json.loads(capsys.readouterr().out)["front"]
        assert [float(row["time_s"]) for row in own] == [point["time_s"] for point in front]
        assert [float(row["energy_kwh"]) for row in own] == [point["energy_kwh"] for point in front]


def test_sections_of_a_journey_are_named_as_where_they_run_on_their_own_in_either_direction(tmp_path):
    both = HEAD.replace("points = 5", "points = 3") + "[product]\nreverse = [false, true]\n"
    tables_of(read_spec(write_case(tmp_path / "stops", both)), tmp_path / "one")
    journeys = both.replace('"stops"', '"journey"')
    tables_of(read_spec(write_case(tmp_path / "journeys", journeys)), tmp_path / "all")
    stretches = {}
    for row in rows_of(tmp_path / "one" / "out" / "scenarios.csv"):
        stretches.setdefault((row["line"], row["reverse"]), []).append(row["section"])
    assert stretches["east", "true"] == ["0-1100", "1100-2000"]
    of_journeys = {row["scenario"]: row for row in rows_of(tmp_path / "all" / "out" / "scenarios.csv")}
    sections = {}
    for row in rows_of(tmp_path / "all" / "out" / "allocation.csv"):
        key = row["line"], of_journeys[row["scenario"]]["reverse"]
        sections.setdefault(key, {})[row["section"]] = None
    assert {key: list(names) for key, names in sections.items()} == stretches


def test_journeys_say_what_each_section_gets_under_its_name(tmp_path):
    path = write_case(tmp_path, HEAD.replace('"stops"', '"journey"\ndwell_s = 20'))
    names = tables_of(read_spec(path), tmp_path / "out")
    assert {"allocation.csv", "allocation/0000.parquet"} <= names
    rows = [row for row in rows_of(tmp_path / "out" / "out" / "allocation.csv") if row["line"] == "west"]
    assert [row["section"] for row in rows[:2]] == ["0-1100", "1100-1900"]
    result = journey(
        load_train(tmp_path / "metro.toml"), load_track(tmp_path / "lines" / "west.toml"), points=5, max_margin=0.1
    )
    assert [float(row["time_s"]) for row in rows] == result.section_time_s.ravel().tolist()
    front = [row for row in rows_of(tmp_path / "out" / "out" / "fronts.csv") if row["line"] == "west"]
    assert [float(row["energy_kwh"]) for row in front] == (result.front.energy_j / 3.6e6).tolist()


def test_tables_that_an_axis_names_are_read_once_from_beside_the_spec(tmp_path, monkeypatch):
    axes = '"train.traction" = [{ file = "curve.csv" }, { file = "older/curve.csv" }]'
    path = write_case(tmp_path / "case", f"{HEAD}[product]\n{axes}\n")
    files = [tmp_path / "case" / "curve.csv", tmp_path / "case" / "older" / "curve.csv"]
    weak = files[1]
    weak.parent.mkdir()
    for file, force_kn in zip(files, (250, 150), strict=True):
        file.write_text(f"speed [km/h],force [kN]\n0,{force_kn}\n30,{force_kn}\n80,90\n")
    monkeypatch.chdir(tmp_path)
    spec, again = read_spec(path), [one.key("") for one in read_spec(path)]
    digests = {f"{one.parent.name}/curve.csv": hashlib.sha256(one.read_bytes()).hexdigest() for one in files}
    assert spec.tables.provenance == {"set": {"beside": digests}}
    made = changed(spec[1].train.value, spec[1].line.value, ['train.traction={file="case/older/curve.csv"}'])
    weak.write_text("speed [km/h],force [kN]\n0,140\n80,90\n")
    now = [one.key("") for one in read_spec(path)]
    assert [a == b for a, b in zip(now, again, strict=True)] == [True, False] * 4
    for file in files:
        file.unlink()
    tables_of(spec, tmp_path / "out")
    front = [row for row in rows_of(tmp_path / "out" / "out" / "fronts.csv") if row["scenario"] == "1"]
    result = search(made.train, made.track, points=5, max_margin=0.1, destination_m=900.0)
    assert [float(row["time_s"]) for row in front] == result.front.time_s.tolist()
    rows = rows_of(tmp_path / "out" / "out" / "scenarios.csv")
    assert {row["train.traction"] for row in rows} == {'{file = "curve.csv"}', '{file = "older/curve.csv"}'}


def test_profiles_on_demand_and_no_csv_where_none_is_wanted(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    text = HEAD.replace("[run]", "profiles_every_m = 200\ncsv = false\n[run]").replace("[run]", "[run]\n", 1)
    names = tables_of(read_spec(write_case(tmp_path, text)), tmp_path / "out")
    assert "profiles/0000.parquet" in names
    assert not [name for name in names if name.endswith(".csv")]
    rows = parquet.read_table(tmp_path / "out" / "out" / "profiles").to_pylist()
    own = [row for row in rows if (row["scenario"], row["point"]) == (0, 3)]
    line = load_track(tmp_path / "lines" / "east.toml")
    result = search(load_train(tmp_path / "metro.toml"), line, points=5, max_margin=0.1, destination_m=900.0)
    assert [row["position_m"] for row in own] == [0.0, 200.0, 400.0, 600.0, 800.0, 900.0]
    assert own[-1]["time_s"] == pytest.approx(result.front.time_s[3], rel=1e-9)
    assert own[0]["regime"] == "traction"


def test_options_that_one_value_of_an_axis_needs_are_no_error_with_the_others(tmp_path):
    text = (
        HEAD.replace("points = 5", "segment_m = 100")
        + "[product]\nmethod = ['exact', 'best-first']\nwind_kmh = [0, 9]\n"
    )
    assert len(read_spec(write_case(tmp_path, text))) == 16


def test_scenarios_that_are_the_same_but_in_name_are_solved_once_and_all_have_rows(tmp_path):
    write_case(tmp_path, HEAD)
    (tmp_path / "lines" / "eastern.toml").write_bytes((tmp_path / "lines" / "east.toml").read_bytes())
    spec = read_spec(tmp_path / "spec.toml")
    tables_of(spec, tmp_path / "out")
    scenarios = rows_of(tmp_path / "out" / "out" / "scenarios.csv")
    assert [int(row["scenario"]) for row in scenarios] == list(range(len(spec))) == list(range(6))
    assert len({row["key"] for row in scenarios}) == 4
    fronts = rows_of(tmp_path / "out" / "out" / "fronts.csv")
    own, other = ([list(row.values())[3:] for row in fronts if row["line"] == line] for line in ("east", "eastern"))
    assert own == other
    assert len(own) == 2 * 5


def test_profiles_make_another_scenario_of_which_nothing_is_done(tmp_path):
    with_profiles = HEAD.replace("[run]", "profiles_every_m = 200\n[run]")
    spec, plain = read_spec(write_case(tmp_path, with_profiles)), read_spec(write_case(tmp_path / "plain", HEAD))
    assert not {one.key("") for one in spec} & {one.key("") for one in plain}


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("trains", "train", "unknown field 'train', did you mean 'trains'?"),
        ('["metro.toml"]', '["tgw"]', "trains[0]: "),
        ('["metro.toml"]', '["metro.toml", "metro.toml"]', "trains[1]: two trains are called 'metro'"),
        ('["lines"]', '["."]', "lines[0]: "),
        ('"stops"', '"all"', "sections: must be whole, stops, journey or a list of FROM:TO, got 'all'"),
        ('"stops"', '["0:1950"]', "sections[0]: ends beyond the 1900 m of line west, got '0:1950'"),
        ('"stops"', '["900"]', "sections[0]: must be FROM:TO"),
        ('"stops"', '"stops"\ndwell_s = 3', "dwell_s: belongs to sections = 'journey'"),
        ("wind_kmh", "wind_mph", "unknown field 'wind_mph', did you mean 'wind_kmh'?"),
        ("[0, 10, 20]", "[0, 'much']", "product.wind_kmh: must be a number"),
        ("[0, 10, 20]", "[]", "product.wind_kmh: must have values"),
        (
            '"train.mass_t" = [180, 200, 220]',
            '"train.traction" = [{ file = "none.csv" }]',
            "spec.toml: train.traction.file: ",
        ),
        ("train.mass_t", "trian.mass_t", "product: unknown field 'trian.mass_t', did you mean 'train.mass_t'?"),
        ("train.mass_t", "train.mas_t", "spec.toml: train.mas_t: unknown field"),
        ("[180, 200, 220]", "[180, -3]", "spec.toml: train.mass_t: must be a number > 0.0, got -3"),
        ("wind_kmh", "points", "points: stands in more than one of run, product and zip"),
        ("wind_kmh", "from_m", "the sections of a sweep say from where to where"),
        (
            "wind_kmh = [0, 10, 20]",
            '"track.length_m" = [2500]',
            "product.track.length_m: the sections of a sweep say from where to where",
        ),
        ("wind_kmh = [0,", '"track.stops_m[1]" = [950,', "stops_m[1]: the sections of a sweep say from where to where"),
        ("[0, 10, 20]", "[0, 1e300]", "product.wind_kmh: must be a number <= 500.0, got 1e+300"),
        ("[0, 10, 20]", "[0, 10, 0.0]", "product.wind_kmh: must have each value once, got 0 twice"),
        ('"stops"', '["0:900", "0:0.9km"]', "sections[1]: stands there twice, got '0:0.9km'"),
        ("points = 5", 'points = 5\nmethod = "exact"', "zip together: search: points belongs to method front"),
        ("wind_kmh = [0, 10, 20]", 'method = ["front", "exact"]', "zip together: search: points belongs to method"),
        (
            "points = 5\nmax_margin_pct = 10",
            "[[zip]]\nat=['3%']\n[[zip]]\npoints=[60, 9]\nreverse=[true, false]",
            "zip together: search: points has no effect beside at_margin",
        ),
        ("[product]", "[[zip]]", None),
        ("[product]", "[[zip]]\nreverse = [true]", "zip[0]: all lists must be equally long, got reverse with 1"),
    ],
)
def test_what_is_no_spec_is_named(tmp_path, before, after, message):
    assert before in SPEC
    path = write_case(tmp_path, SPEC.replace(before, after, 1))
    if message is None:
        assert len(read_spec(path)) == 12
        return
    with pytest.raises(InputError) as error:
        read_spec(path)
    assert message in str(error.value)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
