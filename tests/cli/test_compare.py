"""``tgvdp compare``: results of folders and of trains, at equal margins."""

import csv
import json

import numpy as np
import pytest

import tgvdp
from tests.helpers.report_case import PROVENANCE, VERDICT, make_result, railway_trip
from tgvdp.cli import main
from tgvdp.report import result_object
from tgvdp.report.comparison import COMPARE_COLUMNS, compare_object, differences, names_of, plot_comparison

SHORT = ("--track", "flat-100km", "--to", "5km")


def test_trains_on_a_line(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["compare", "--train", "tgv", "--train", "alstom-emu", *SHORT, "--out", str(out), "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert {path.name for path in out.iterdir()} == {"compare.json", "compare.csv", "compare.png", "provenance.json"}
    assert content == json.loads((out / "compare.json").read_text(encoding="utf-8"))
    assert [run["name"] for run in content["runs"]] == ["tgv", "alstom-emu"]
    # Each figure is that of a search for this margin alone.
    row = next(row for row in content["rows"] if row["name"] == "alstom-emu" and row["margin_pct"] == 5.0)
    alone = tgvdp.search("alstom-emu", "flat-100km", destination_m=5000.0, at_margin=(0.05,))
    assert row["energy_kwh"] == pytest.approx(alone.front.energy_j[-1] / 3.6e6, rel=2e-3)
    with (out / "compare.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COMPARE_COLUMNS
    assert len(rows) == 14


def test_folders_of_results(tmp_path, capsys):
    for train in ("tgv", "alstom-emu"):
        arguments = ["--train", train, *SHORT, "--points", "8", "--no-pictures", "--quiet"]
        assert main(["search", *arguments, "--out", str(tmp_path / train)]) == 0
    folders = [str(tmp_path / train) for train in ("tgv", "alstom-emu")]
    assert main(["compare", *folders, "--at", "0%,10%,60%", "--out", str(tmp_path / "out")]) == 0
    head, units, *rows = capsys.readouterr().out.splitlines()[:-1]
    assert head.split() == ["margin", "tgv", "saved", "alstom-emu", "saved"]
    assert units.split() == ["%", "kWh", "%", "kWh", "%"]
    assert [row.split()[0] for row in rows] == ["0", "10", "60"]
    assert rows[0].split()[2] == rows[0].split()[4] == "0.0"
    assert rows[2].split()[1:] == ["–"] * 4  # no front goes so far


def test_figures_between_points_say_how_far_they_may_be_off(tmp_path, capsys):
    """Of a coarse front 2 % are read off a straight line: dearer than the front, and not by more than is said."""
    for name, at in (("coarse", "0%,10%"), ("fine", "0%,2%,10%")):
        arguments = ["--train", "tgv", *SHORT, "--at", at, "--no-pictures", "--no-certify", "--quiet"]
        assert main(["search", *arguments, "--out", str(tmp_path / name)]) == 0
    folders = [str(tmp_path / name) for name in ("coarse", "fine")]
    assert main(["compare", *folders, "--at", "2%,10%", "--out", str(tmp_path / "out"), "--json"]) == 0
    shown = capsys.readouterr()
    content = json.loads(shown.out)
    coarse, _, fine, _ = content["rows"]
    assert fine["at_most_above_pct"] == pytest.approx(0.0, abs=0.1)
    above_pct = 100.0 * (1.0 - fine["energy_kwh"] / coarse["energy_kwh"])
    assert 1.0 < above_pct <= coarse["at_most_above_pct"]
    assert "read off a straight line, which may be" in content["warning"]
    assert "--at puts points there" in shown.err


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        ([], 2, "name folders of results"),
        (["out", "--train", "tgv"], 2, "folders hold results"),
        (["--train", "tgv", "--at", "20:00"], 2, "margins only"),
        (["--train", "tgv", "--at", "often"], 2, "'often'"),
        (["no-such-folder"], 3, "no-such-folder: cannot be read"),
    ],
)
def test_wrong_usage(tmp_path, monkeypatch, capsys, arguments, code, message):
    monkeypatch.chdir(tmp_path)
    assert main(["compare", *arguments]) == code
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_results_of_one_name_are_numbered(tmp_path, capsys):
    out = str(tmp_path / "one")
    assert main(["search", "--train", "tgv", *SHORT, "--points", "4", "--no-pictures", "--quiet", "--out", out]) == 0
    assert main(["compare", out, out, "--at", "5%", "--out", str(tmp_path / "both"), "--json"]) == 0
    assert [run["name"] for run in json.loads(capsys.readouterr().out)["runs"]] == ["result 1", "result 2"]


@pytest.mark.parametrize(
    "text",
    ["no JSON", "[]", '{"schema": "tgvdp.solve/2"}', '{"schema": "tgvdp.search/1", "method": "front", "trip": {}}'],
)
def test_files_that_are_no_results(tmp_path, capsys, text):
    (tmp_path / "result.json").write_text(text)
    assert main(["compare", str(tmp_path), "--out", str(tmp_path / "out")]) == 3
    assert "result.json: " in capsys.readouterr().err


@pytest.fixture(scope="module")
def contents():
    return [
        result_object(make_result(railway_trip(), speeds), [VERDICT] * len(speeds), PROVENANCE)
        for speeds in ([24.0, 20.0, 16.0], [24.0, 22.0, 18.0])
    ]


def test_folders_of_other_results_are_named(tmp_path, capsys):
    (tmp_path / "journey.json").write_text("{}")
    assert main(["compare", str(tmp_path), "--out", str(tmp_path / "out")]) == 3
    assert capsys.readouterr().err == f"tgvdp: error: {tmp_path}: holds no result.json, which tgvdp search writes\n"


def test_figures_follow_from_the_fronts(contents):
    rows = compare_object(contents, ["a", "b"], [0.0, 10.0])["rows"]
    for name, content in zip("ab", contents, strict=True):
        start, margin = (row for row in rows if row["name"] == name)
        assert (start["saved_pct"], start["energy_kwh"]) == (0.0, content["fastest"]["energy_kwh"])
        at_s = 1.1 * content["fastest"]["time_s"]
        points = content["front"]
        energy = np.interp(at_s, [one["time_s"] for one in points], [one["energy_kwh"] for one in points])
        assert margin["energy_kwh"] == pytest.approx(energy)
    first, other = (row for row in rows if row["margin_pct"] == 10.0)
    assert str(first["against_first_pct"]) == "0.0"  # not -0.0
    assert other["against_first_pct"] == pytest.approx(100 * (other["energy_kwh"] / first["energy_kwh"] - 1))


def test_results_are_named_by_what_tells_them_apart(contents):
    assert names_of(contents, ["a", "b"]) == ["a", "b"]
    assert names_of(contents) == ["result 1", "result 2"]
    other = {**contents[1], "trip": {**contents[1]["trip"], "track": "Other"}}
    assert names_of([contents[0], other], ["a", "b"]) == ["Test line", "Other"]


@pytest.mark.parametrize(
    ("trip", "fields", "told"),
    [
        ({}, [], ""),
        ({"train": "Other"}, [], "the results are of different trains (Test train, Other)"),
        (
            {"track": "Branch", "destination_m": 2500.0},
            [],
            "the results are of different lines (Test line, Branch) and stretches (1 to 5 km, 1 to 2.5 km): their"
            " shares compare, their energies do not",
        ),
        ({}, ["train.mass_t=450"], "the results are of different fields set (none, train.mass_t=450)"),
    ],
)
def test_results_say_in_what_their_trips_differ(contents, trip, fields, told):
    options = {"options": {"set": fields}} if fields else {}
    other = {**contents[1], "trip": {**contents[1]["trip"], **trip}, "provenance": options}
    assert differences([contents[0], other]) == told


def test_results_of_different_lines_are_told(tmp_path, capsys):
    """The table named the trains alone."""
    for train, track in (("tgv", "flat-100km"), ("alstom-emu", "lgv-100km")):
        arguments = ["--train", train, "--track", track, "--to", "5km", "--points", "4", "--no-pictures", "--quiet"]
        assert main(["search", *arguments, "--out", str(tmp_path / train)]) == 0
    folders = [str(tmp_path / train) for train in ("tgv", "alstom-emu")]
    for quiet in ([], ["--quiet"]):
        assert main(["compare", *folders, "--at", "5%", "--out", str(tmp_path / "out"), *quiet]) == 0
        said = "note: the results are of different trains (tgv, alstom-emu) and lines (flat-100km, lgv-100km): their"
        assert (said in capsys.readouterr().err) is not bool(quiet)


def test_different_energies_are_told(contents):
    other = {**contents[1], "energy": {"model": "pantograph"}}
    assert "a wheel, b pantograph" in compare_object([contents[0], other], ["a", "b"])["warning"]
    assert "different energies" not in compare_object(contents, ["a", "b"]).get("warning", "")


def test_the_picture_has_a_line_for_each(contents):
    upper, lower = plot_comparison(contents, ["a", "b"]).axes
    assert [line.get_label() for line in upper.lines] == ["a", "b"]
    assert len({line.get_color() for line in upper.lines}) == len({line.get_linestyle() for line in upper.lines}) == 2
    np.testing.assert_allclose(upper.lines[0].get_ydata()[1:], [one["saved_pct"] for one in contents[0]["front"]])
    assert lower.get_ylim()[0] == 0.0
