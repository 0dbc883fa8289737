"""``tgvdp journey``: the object that scripts read, the files, the table, and what ``search`` says of stops."""

import csv
import json
import re
from pathlib import Path

import pytest

from tests.helpers.clocks import LooksAtTheClock
from tests.helpers.format_case import JOURNEY, TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, write_json
from tgvdp.cli import main

STOPS = changed(TTOBENCH_TRACK, ("stops", "values"), [0, 4000, 10_000])


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Function that runs a command on a line of two sections."""
    monkeypatch.chdir(tmp_path)
    write_json(tmp_path / "train.json", TTOBENCH_TRAIN)
    write_json(tmp_path / "track.json", STOPS)
    write_json(tmp_path / "journey.json", JOURNEY)

    def command(name, *options):
        return main([name, "--train", "train.json", "--track", "track.json", *options])

    return command


def test_the_object_that_scripts_read(run, capsys):
    assert run("journey", "--points", "3", "--json", "--no-pictures") == 0
    content = json.loads(capsys.readouterr().out)
    assert list(content) == ["schema", "sections", "fastest", "front", "practices", "complete", "advice"]
    assert content["advice"]["point"] == 2
    assert [one["steps"][-1]["to_m"] for one in content["advice"]["sections"]] == [4000.0, 10_000.0]
    assert content["complete"] is True
    assert content["schema"] == "tgvdp.journey/1"
    assert [list(section) for section in content["sections"]] == [["from_m", "to_m", "fastest_time_s"]] * 2
    assert [(section["from_m"], section["to_m"]) for section in content["sections"]] == [(0, 4000), (4000, 10_000)]
    first, *_, last = content["front"]
    assert set(last) == {"time_s", "energy_kwh", "price_kwh_per_min", "sections"}
    assert [set(section) for section in last["sections"]] == [{"time_s", "energy_kwh"}] * 2
    assert first["price_kwh_per_min"] is None
    assert last["energy_kwh"] == pytest.approx(sum(section["energy_kwh"] for section in last["sections"]))
    assert all([set(row) for row in rows] == [{"time_s", "energy_kwh"}] * 3 for rows in content["practices"].values())


def test_what_a_budget_cut_off_is_labelled(run, monkeypatch, capsys):
    monkeypatch.setattr("tgvdp.api.journeys.budget_of", lambda _: LooksAtTheClock(0))
    assert run("journey", "--json", "--no-pictures") == 5
    content = json.loads(capsys.readouterr().out)
    assert content["complete"] is False
    assert content["warning"] == "the time limit ended the search: better splits than these may exist"


def test_what_the_time_limit_ends_after_the_search_is_labelled(run, monkeypatch, capsys):
    monkeypatch.setattr("tgvdp.cli.journey.left_s", lambda *_: 1e-9)
    assert run("journey", "--points", "3", "--certify", "--margins", "5%", "--no-pictures") == 5
    err = capsys.readouterr().err
    content = json.loads(Path("journey/journey.json").read_text(encoding="utf-8"))
    assert content["complete"] is True
    for what in (
        "the time limit ended the replay, 6 runs of sections had none",
        "the budget ended the proof, bounds are missing or loose",
        "the time limit ended the margins before 5%",
    ):
        assert f"tgvdp: budget reached: {what}\n" in err
        assert what in content["warning"]


def test_the_files_and_the_table(run, tmp_path, capsys):
    assert run("journey", "--at", "5%,10%", "--out", "there", "--certify") == 0
    shown = capsys.readouterr().out
    assert "proportional to time" in shown
    assert re.search(r"^2 sections, fastest [0-9:.]+ without 1 dwell of 30 s$", shown, re.MULTILINE)
    names = {file.name for file in (tmp_path / "there").iterdir()}
    pictures = {f"{name}.png" for name in ("front", "time_distance", "profile", "allocation", "price")}
    assert names == {"journey.json", "front.csv", "allocation.csv", "advice.csv", "provenance.json"} | pictures
    rows = list(csv.DictReader((tmp_path / "there" / "allocation.csv").open()))
    assert [(row["point"], row["section"]) for row in rows] == [("1", "1"), ("1", "2"), ("2", "1"), ("2", "2")]
    front = list(csv.DictReader((tmp_path / "there" / "front.csv").open()))
    points = json.loads((tmp_path / "there" / "journey.json").read_text())["front"]
    for row, point in zip(front, points, strict=True):
        assert point["lower_bound_kwh"] <= point["energy_kwh"]
        for name in ("lower_bound_kwh", "gap_pct"):
            assert float(row[name]) == pytest.approx(point[name], rel=1e-6)
    assert [float(row["margin_pct"]) for row in front] == pytest.approx([5.0, 10.0], abs=0.01)
    assert all(0.0 <= float(row["gap_pct"]) < 1.0 for row in front)
    assert all(float(row["all_at_the_end_kwh"]) > float(row["energy_kwh"]) for row in front)


def test_a_timetable(run, tmp_path, capsys):
    loose = changed(JOURNEY, ("timing points", "values", 5, 2), 1500)
    write_json(tmp_path / "journey.json", loose)
    assert run("journey", "--journey", "journey.json", "--points", "2", "--no-pictures", "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert content["practices"] == {}
    assert 270.0 <= content["front"][-1]["sections"][0]["time_s"] <= 330.0


def test_waiting_for_a_window_is_counted_and_shown(run, tmp_path, capsys):
    """The next section may begin at 900 s, long after the first one has to end."""
    late = changed(JOURNEY, ("timing points", "values", 4), [4, 15, 1500, 0, 0])  # 15 min
    late = changed(late, ("timing points", "values", 5, 2), 2500)
    write_json(tmp_path / "journey.json", late)
    asked = ("journey", "--journey", "journey.json", "--points", "2", "--no-pictures", "--energy", "pantograph")
    assert run(*asked, "--out", "there") == 0
    assert re.search(r"\bwaiting\b", capsys.readouterr().out)
    for point in json.loads((tmp_path / "there" / "journey.json").read_text())["front"]:
        assert point["waiting"]["time_s"] > 0.0
        parts = [*point["sections"], point["waiting"]]
        assert point["energy_kwh"] == pytest.approx(sum(part["energy_kwh"] for part in parts))
    front = list(csv.DictReader((tmp_path / "there" / "front.csv").open()))
    assert all(float(row["waiting_s"]) > 0.0 and float(row["waiting_kwh"]) >= 0.0 for row in front)


def test_a_timetable_that_cannot_be_met(run, tmp_path, capsys):
    tight = changed(JOURNEY, ("timing points", "values", 3), [4, 0, 150, 0, 0])
    write_json(tmp_path / "journey.json", tight)
    assert run("journey", "--journey", "journey.json", "--no-pictures") == 4
    row = "journey.json: timing points.values[3]: position 4 km"
    assert f"the window at 4000 m ({row}) closes at 150 s, the first time possible there is" in capsys.readouterr().err


def test_stops_that_only_the_timetable_names_have_their_names(run, tmp_path, capsys):
    """The one at 4 km was shown as an ellipsis."""
    table = "Station,km,Arrival,Departure\nAston,0,,10:00\nMid,4,10:10,10:11\nBerry,10,10:30,\n"
    (tmp_path / "times.csv").write_text(table)
    assert run("journey", "--journey", "times.csv", "--points", "2", "--no-pictures") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "1 Aston – Mid: " in told and "2 Mid – Berry: " in told
    assert "stop at Mid (km 4.00)" in told
    assert "…" not in told


def test_a_timetable_of_the_other_direction_is_doubted(tmp_path, monkeypatch, capsys):
    """Its positions fit, its names do not."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.csv").write_text("Station,km,speed_kmh\nAston,0,80\nMid,4,80\nBerry,10,80\n")
    (tmp_path / "times.csv").write_text("Station,km,Arrival,Departure\nBerry,0,,10:00\nMID,6,,10:11\nAston,10,10:40,\n")
    asked = ["journey", "--train", "alstom-emu", "--track", "line.csv", "--journey", "times.csv", "--points", "2"]
    asked += ["--no-pictures", "--quiet", "--json"]
    assert main(asked) == 0
    doubt = "journey times calls 0 m Berry, track line calls it Aston: is the line to be reversed?"
    assert json.loads(capsys.readouterr().out)["warning"] == doubt
    assert main([*asked, "--reverse"]) == 0
    assert "warning" not in json.loads(capsys.readouterr().out)


def test_search_says_that_it_passes_stops_and_names_journey(run, capsys):
    assert run("search", "--points", "2", "--no-certify", "--no-pictures") == 0
    assert "1 stop between origin and destination is passed: tgvdp journey stops there" in capsys.readouterr().err


def test_points_are_asked_for_once(run, capsys):
    assert run("journey", "--at", "5%", "--points", "3") == 2
    assert "--at and --points exclude each other" in capsys.readouterr().err


def test_several_trains(run, tmp_path, capsys):
    write_json(tmp_path / "heavy.json", changed(TTOBENCH_TRAIN, ("metadata", "id"), "heavy"))
    assert run("journey", "--train", "heavy.json", "--points", "4", "--json", "--out", "both", "--no-pictures") == 0
    shown = capsys.readouterr()
    content = json.loads(shown.out)
    assert content["schema"] == "tgvdp.journeys/1"
    assert [one["train"] for one in content["trains"]] == ["toy", "heavy"]
    assert all(one["schema"] == "tgvdp.journey/1" for one in content["trains"])
    assert "heavy" in shown.err
    rows = list(csv.DictReader((tmp_path / "both" / "compare.csv").open()))
    assert {row["name"] for row in rows} == {"toy", "heavy"}
    assert (tmp_path / "both" / "compare.png").exists()
    assert (tmp_path / "both" / "train-2" / "front.csv").exists()
    assert run("journey", "--train", "heavy.json", "--points", "4", "--out", "both", "--no-pictures") == 0


def test_trains_are_compared_where_points_were_asked_for(run, tmp_path, capsys):
    """A point is a little earlier than its margin: what lies between is told by its price, not by the next point."""
    write_json(tmp_path / "heavy.json", changed(TTOBENCH_TRAIN, ("metadata", "id"), "heavy"))
    assert run("journey", "--train", "heavy.json", "--at", "5%,8%", "--out", "both", "--no-pictures") == 0
    assert "straight line" not in capsys.readouterr().err
    rows = list(csv.DictReader((tmp_path / "both" / "compare.csv").open()))
    assert all(float(row["at_most_above_pct"]) < 0.01 for row in rows)


def test_delays(run, tmp_path, capsys):
    assert run("journey", "--at", "5%,10%", "--delay", "15", "--out", "late") == 0
    shown = capsys.readouterr().out
    assert "cheapest as planned on the second front" in shown
    assert "_" not in shown.partition("with delays")[2]
    content = json.loads((tmp_path / "late" / "journey.json").read_text())["robustness"]
    rows = list(csv.DictReader((tmp_path / "late" / "robustness.csv").open()))
    assert rows[0]["allocation"] == "optimum"
    assert float(rows[0]["expected_kwh"]) > float(rows[0]["planned_kwh"])
    assert [list(row) for row in content] == [list(rows[0])] * len(rows)
    for row, held in zip(rows, content, strict=True):
        assert float(row["expected_delay_s"]) == pytest.approx(held["expected_delay_s"], abs=1e-6)
        assert row["on_the_second_front"] == str(held["on_the_second_front"]).lower()
    assert (tmp_path / "late" / "robustness.png").exists()


def test_a_folder_of_a_search_is_not_written_into(run, tmp_path, capsys):
    assert run("search", "--points", "2", "--no-certify", "--no-pictures", "--out", "there") == 0
    held = {file.name for file in (tmp_path / "there").iterdir()}
    assert run("journey", "--points", "2", "--no-pictures", "--out", "there") == 3
    assert "there: holds results of tgvdp search, which would be lost" in capsys.readouterr().err
    assert {file.name for file in (tmp_path / "there").iterdir()} == held
    assert run("journey", "--points", "2", "--no-pictures", "--out", "there", "--force") == 0


def test_folders_of_trains_that_are_no_longer_run_go(run, tmp_path):
    write_json(tmp_path / "heavy.json", changed(TTOBENCH_TRAIN, ("metadata", "id"), "heavy"))
    options = ("--points", "2", "--out", "both", "--no-pictures", "--quiet")
    assert run("journey", "--train", "heavy.json", "--train", "train.json", *options) == 0
    (tmp_path / "both" / "train-3" / "mine.txt").write_text("not tgvdp's")
    assert run("journey", "--train", "heavy.json", *options) == 0
    assert {file.name for file in (tmp_path / "both" / "train-3").iterdir()} == {"mine.txt"}
    assert run("journey", *options) == 0
    names = {file.name for file in (tmp_path / "both").iterdir()}
    assert names == {"journey.json", "front.csv", "allocation.csv", "advice.csv", "provenance.json", "train-3"}


def test_a_run_that_ended_between_two_trains_may_be_done_again(run, tmp_path, capsys):
    weak = changed(TTOBENCH_TRAIN, ("max traction force", "value"), 0.1)
    write_json(tmp_path / "second.json", weak)
    options = ("--train", "second.json", "--points", "2", "--out", "both", "--no-pictures", "--quiet")
    assert run("journey", *options) == 4
    write_json(tmp_path / "second.json", TTOBENCH_TRAIN)
    (tmp_path / "both" / "mine.txt").touch()
    assert run("journey", *options) == 3
    assert "both: is not empty, and no results of tgvdp are in it" in capsys.readouterr().err
    (tmp_path / "both" / "mine.txt").unlink()
    assert run("journey", *options) == 0


def test_trains_with_a_timetable_count_from_their_earliest_journey(run, tmp_path, capsys):
    write_json(tmp_path / "journey.json", changed(JOURNEY, ("timing points", "values", 5, 2), 1500))
    write_json(tmp_path / "heavy.json", changed(TTOBENCH_TRAIN, ("metadata", "id"), "heavy"))
    options = ("--journey", "journey.json", "--points", "3", "--no-pictures", "--out", "both")
    assert run("journey", "--train", "heavy.json", *options) == 0
    assert "–" not in capsys.readouterr().out.splitlines()[2]
    rows = list(csv.DictReader((tmp_path / "both" / "compare.csv").open()))
    assert all(float(row["saved_pct"]) == 0.0 for row in rows if float(row["margin_pct"]) == 0.0)


def test_a_map_has_no_gap(run, capsys):
    assert run("journey", "--energy", "map", "--points", "2", "--certify", "--no-pictures") == 0
    shown = capsys.readouterr()
    assert "inf" not in shown.out
    assert "--certify: energies by a map have no bound" in shown.err


def test_margins_side_by_side(run, tmp_path, capsys):
    options = ("--points", "2", "--margins", "5%", "--margins", "0:5km:5%,5km::30s", "--out", "marg")
    assert run("journey", *options, "--json") == 0
    shown = capsys.readouterr()
    content = json.loads(shown.out)["margins"]
    assert [one["margin"] for one in content] == ["5%", "0:5km:5%,5km::30s"]
    assert [row["name"] for row in content[0]["runs"]] == ["linear", "economy", "uniform", "optimum"]
    assert [row["margin_pct"] for row in content[0]["runs"]] == pytest.approx([5.0] * 4, abs=0.02)
    assert content[0]["runs"][0]["deviation_s"] == 0.0
    assert "0:5km:5%,5km::30s more time:" in shown.err
    rows = list(csv.DictReader((tmp_path / "marg" / "margins.csv").open()))
    assert [row["margin"] for row in rows] == ["5%"] * 4 + ["0:5km:5%;5km::30s"] * 4
    assert float(rows[0]["energy_kwh"]) > float(rows[2]["energy_kwh"]) > float(rows[3]["energy_kwh"])
    assert (tmp_path / "marg" / "margins.png").exists()


def test_a_corridor_without_margins_is_refused(run, capsys):
    assert run("journey", "--points", "2", "--no-pictures", "--within", "5") == 2
    assert "--within goes with --margins" in capsys.readouterr().err
    assert not Path("journey").exists()


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("often", 2, "must be 5%, 4.5min/100km or 90s"),
        ("5km:5%", 2, "must be 5%, 4.5min/100km or 90s"),
        ("0:5km:5%,3km::1%", 3, "margins: two ranges hold 3000 m"),
        ("0:50km:5%", 3, "margins: to must lie within the line's"),
        ("3000:3001:900s", 4, "margins: one of them has no run that takes"),
    ],
)
def test_margins_that_cannot_be_taken(run, capsys, text, code, message):
    assert run("journey", "--points", "2", "--no-pictures", "--margins", text) == code
    assert message in capsys.readouterr().err


def test_what_goes_without_windows_only_is_refused_before_the_search(run, capsys, monkeypatch):
    """It was after it, and after a certificate."""
    monkeypatch.setattr("tgvdp.api.journey", pytest.fail)
    for option, what in (("--delay", "delays are simulated"), ("--margins", "margins are taken")):
        assert run("journey", "--journey", "journey.json", option, "5%" if option == "--margins" else "5") == 3
        assert capsys.readouterr().err.endswith(f"tgvdp: error: journey: {what} without windows only\n")


def test_a_corridor_is_narrower_than_all_of_the_time(run, capsys):
    assert run("journey", "--margins", "5%", "--within", "100") == 2
    assert "'--within': must be below 100 %, got 100 %" in capsys.readouterr().err


def test_a_timetable_is_no_name_of_the_catalog(run, capsys):
    """It was "unknown train or track or map"."""
    for name in ("times", "tgv"):
        assert run("journey", "--journey", name) == 3
        assert capsys.readouterr().err == f"tgvdp: error: {name}: no such file\n"
