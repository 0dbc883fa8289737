"""The report of a sweep, against sums made here from its tables."""

import csv
import json

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from tests.helpers.sweep_case import run
from tgvdp import InputError
from tgvdp.report.sweep_plots import Effect, plot_tornado
from tgvdp.sweeps.summary import Savings, axes_of_map, by_effect, grid, read_savings, report_object, told_apart
from tgvdp.sweeps.tables import SCHEMAS

arrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

#: Energy at margins of 0 and 10 %, kWh, by train and load: 20 + 4 · heavy of which the margin saves 2 + heavy.
TRAINS, LOADS = ("a", "b"), ("light", "heavy")


def write_scenarios(folder, columns):
    table = arrow.table(columns).replace_schema_metadata({"schema": SCHEMAS["scenarios"]})
    parquet.write_table(table, folder / "scenarios.parquet")


@pytest.fixture
def folder(tmp_path):
    """A finished sweep, as its tables are: the last scenario failed, the third one's front ends at 5 % already."""
    cases = [(train, load) for train in TRAINS for load in LOADS]
    fastest = [20.0 + 4.0 * (load == "heavy") for _, load in cases]
    table = {
        "scenario": range(5),
        "train": [*(train for train, _ in cases), "b"],
        "line": ["l"] * 5,
        "section": ["0-1"] * 5,
        "to_m": [1.0] * 5,
        "train.name": [*(load for _, load in cases), "none"],
        "status": ["done"] * 4 + ["failed"],
        "fastest_energy_kwh": [*fastest, None],
        "asked_margin_pct": [10.0] * 4 + [None],
    }
    write_scenarios(tmp_path, {name: list(values) for name, values in table.items()})
    (tmp_path / "fronts").mkdir()
    ends = [10.0, 10.0, 5.0, 10.0]
    saved = [2.0, 3.0, 2.0, 3.0]
    rows = {
        "scenario": np.repeat(np.arange(4), 2),
        "margin_pct": np.ravel([(0.0, end) for end in ends]),
        "time_s": np.ravel([(100.0, 100.0 + end) for end in ends]),
        "price_kwh_per_min": [np.nan, 0.3] * 4,
        "energy_kwh": np.ravel([(one, one - less) for one, less in zip(fastest, saved, strict=True)]),
    }
    parquet.write_table(arrow.table(rows), tmp_path / "fronts" / "0000.parquet")
    return tmp_path


def test_an_axis_on_which_nothing_depends_is_noted(folder):
    note = "train changes nothing: runs cost the same at all of its values"
    content = report_object(read_savings(folder, 10.0))
    assert content["notes"] == [note]
    done = run("report", folder, "--margin", 10)
    assert done.stderr == f"tgvdp: note: {note}\n"
    assert f"Note: {note}." in (folder / "report" / "report.md").read_text()


def test_an_axis_that_others_decide_is_not_idle():
    axes = {"line": ["a", "a", "b", "b"], "section": ["a 1", "a 2", "b 1", "b 2"]}
    energies = np.array([4.0, 5.0, 4.0, 5.0])
    assert "notes" not in report_object(
        Savings(5.0, np.arange(4), energies, 0.9 * energies, axes, {"done": 4}, 0.0 * energies)
    )


def test_savings_are_interpolated_and_end_with_the_front(folder):
    savings = read_savings(folder, 7.5)
    assert savings.saved_kwh == pytest.approx([1.5, 2.25, 2.0, 2.25], abs=1e-12)
    assert savings.counts == {"done": 4, "failed": 1}
    assert list(savings.axes) == ["train", "train.name"]


def test_a_front_with_no_point_near_a_margin_is_said(folder):
    """Between 0 and 10 % it may be as low as its tangent at 10 %, 0.3 kWh/min, or as its energy there."""
    savings = read_savings(folder, 7.5)
    least_kwh = np.array([18.0, 21.0]) + 0.3 * 2.5 / 60.0
    read_kwh = np.array([18.5, 21.75])
    assert savings.at_most_above_pct[[0, 1, 3]] == pytest.approx(100.0 * (1.0 - least_kwh / read_kwh)[[0, 1, 1]])
    assert savings.at_most_above_pct[2] == 0.0
    told = "3 of 4 fronts have too few points around 7.5 %: energies are read off a straight line there"
    assert report_object(savings)["warning"].startswith(f"{told}, which may be 3.4 % too dear")
    assert "warning" not in report_object(read_savings(folder, 10.0))
    done = run("report", folder, "--margin", 7.5)
    assert f"tgvdp: warning: {told}" in done.stderr
    assert f"Warning: {told}" in (folder / "report" / "report.md").read_text(encoding="utf-8")


def test_fronts_begin_with_the_fastest_run_wherever_their_points_begin(folder):
    file = folder / "fronts" / "0000.parquet"
    rows = parquet.read_table(file)
    parquet.write_table(rows.filter(arrow.compute.greater(rows["margin_pct"], 0.0)), file)
    assert read_savings(folder, 2.5).saved_kwh == pytest.approx([0.5, 0.75, 1.0, 0.75], abs=1e-12)


def test_a_margin_that_one_front_was_not_asked_for_is_refused(folder):
    """What that front would save there is not known."""
    columns = parquet.read_table(folder / "scenarios.parquet").to_pydict()
    write_scenarios(folder, columns | {"asked_margin_pct": [10.0, 10.0, 5.0, 10.0, None]})
    assert len(read_savings(folder, 5.0).number) == 4
    with pytest.raises(InputError, match=r"scenario 2 was asked for margins up to 5 %, got 5.1 %"):
        read_savings(folder, 5.1)


def test_tables_that_are_damaged_or_of_another_schema_are_named(folder):
    file, scenarios = folder / "fronts" / "0000.parquet", folder / "scenarios.parquet"
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    with pytest.raises(InputError, match=r"0000.parquet: cannot be read: "):
        read_savings(folder, 5.0)
    file.unlink()
    with pytest.raises(InputError, match="scenario 0 is done, but its points are not in fronts"):
        read_savings(folder, 5.0)
    parquet.write_table(arrow.table({"scenario": [0]}), scenarios)
    with pytest.raises(InputError, match=r"is of no schema, this version reads tgvdp.sweep-scenarios/"):
        read_savings(folder, 5.0)


def test_command_writes_page_tables_and_pictures(folder):
    done = run("report", folder, "--margin", 7.5, "--json")
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    assert content["network"]["saved_pct"] == pytest.approx(100.0 * 8.0 / 88.0, rel=1e-12)
    home = folder / "report"
    assert {"report.md", "distribution.png", "tornado.png", "map.png"} <= {file.name for file in home.iterdir()}
    with open(home / "savings.csv", encoding="utf-8", newline="") as file:
        assert [float(row["saved_kwh"]) for row in csv.DictReader(file)] == pytest.approx([1.5, 2.25, 2.0, 2.25])
    assert "7.5 % more running time saves 9.09 %: 8 of 88 kWh" in done.stderr


@pytest.mark.parametrize(
    "effects",
    [
        [
            Effect("section", 21.5, 30.7, "flat-100km 20000-60000", "lgv-100km 0-20000"),
            Effect("wind", 26.7, 28.1, 30, 0),
        ],
        [
            Effect("line", 20.0, 27.4, "a line with a long name", "b"),
            Effect("train", 27.3, 40.0, "a", "a long name, too"),
        ],
        [Effect("wind", 27.4, 27.4, 0, 30)],
    ],
)
def test_values_beside_bars_keep_clear_of_the_names_of_axes(effects):
    figure = plot_tornado(effects, 27.4, 5.0, "72 scenarios")
    FigureCanvasAgg(figure).draw()
    (axes,) = figure.axes
    inside, clear = axes.get_window_extent(), 5.0  # px
    for text in axes.texts[: 2 * len(effects)]:
        extent = text.get_window_extent()
        assert inside.x0 + clear <= extent.x0 < extent.x1 <= inside.x1 - clear, text.get_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--margin", "20"], "scenario 0 was asked for margins up to 10 %, got 20 %"),
        (["--margin", "-1"], "at least 0 %"),
    ],
)
def test_margins_out_of_reach_are_refused(folder, words, message):
    done = run("report", folder, *words)
    assert done.returncode in (2, 3)
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_what_goes_along_with_each_other_is_one_axis():
    """No figure tells which of them the saving depends on; of places one says it all."""
    axes = {
        "train": ["a", "a", "b"],
        "section": ["a 0-1", "a 0-1", "b 0-1"],
        "wind_kmh": [0, 9, 0],
        "energy": ["x", "y", "x"],
    }
    assert told_apart(axes) == {"train": ["a", "a", "b"], "wind_kmh and energy": ["0, x", "9, y", "0, x"]}


def test_a_map_is_of_axes_of_which_none_decides_the_other():
    """Of sections and their lines half of its cells were empty."""
    axes = {
        "line": ["a", "a", "b", "b"] * 2,
        "section": ["a 0-1", "a 1-2", "b 0-1", "b 1-2"] * 2,
        "wind_kmh": [0] * 4 + [9] * 4,
    }
    fastest, energy = np.full(8, 10.0), np.array([1.0, 2.0, 5.0, 8.0, 1.1, 2.1, 5.1, 8.1])
    savings = Savings(5.0, np.arange(8), fastest, energy, axes, {"done": 8}, np.zeros(8))
    assert [axis for axis, _ in by_effect(savings)] == ["section", "line", "wind_kmh"]
    assert axes_of_map(savings) == ["section", "wind_kmh"]
    places = {name: axes[name] for name in ("line", "section")}
    assert axes_of_map(Savings(5.0, np.arange(8), fastest, energy, places, {"done": 8}, np.zeros(8))) == []


def test_no_sweep_there(tmp_path):
    done = run("report", tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (3, 1)
    assert "holds no finished sweep" in done.stderr
    assert f"{tmp_path / 'absent'}: no such folder" in run("report", tmp_path / "absent").stderr


def test_the_axis_with_the_widest_span_comes_first_and_maps_have_holes():
    fastest, energy = np.array([10.0, 10.0, 20.0]), np.array([9.0, 5.0, 18.0])
    axes = {"wind_kmh": [0, 30, 0], "train": ["a", "a", "b"]}
    savings = Savings(5.0, np.arange(3), fastest, energy, axes, {"done": 3}, np.zeros(3))
    ranked = by_effect(savings)
    assert [axis for axis, _ in ranked] == ["wind_kmh", "train"]
    assert [level.saved_pct for level in ranked[0][1]] == pytest.approx([10.0, 50.0])
    made = grid(savings, "wind_kmh", "train")
    assert made.saved_pct[0].tolist() == pytest.approx([10.0, 10.0])
    assert np.isnan(made.saved_pct[1, 1])
