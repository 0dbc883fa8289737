"""``tgvdp search`` from option to file, on the real search."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from tgvdp.cli import main
from tgvdp.cli.notes import large_gaps
from tgvdp.cli.search import _asked

SHORT = ("--track", "flat-100km", "--to", "3000", "--points", "6", "--max-margin", "10")
FILES = {"result.json", "front.csv", "profiles.csv", "front.png", "profile.png"}


def search(out, *arguments):
    return main(["search", *arguments, "--out", str(out)])


def test_table_and_files(tmp_path, capsys):
    assert search(tmp_path / "out", *SHORT) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.splitlines()[1].split() == ["margin", "time", "delay", "energy", "saved", "price", "gap", "gap"]
    assert out.splitlines()[2].split() == ["%", "s", "kWh", "%", "kWh/min", "%", "kWh"]
    assert max(map(len, out.splitlines()[:-1])) <= 80
    decimals = [[cell.partition(".")[2] for cell in line.split()] for line in out.splitlines()[3:9]]
    assert all(len({len(cell) for cell in column if cell != ""}) <= 1 for column in zip(*decimals, strict=True))
    assert "fastest run" in out
    told = " ".join(out.split("how to drive at ")[1].split())
    assert "Accelerate to " in told
    assert "then brake to stop at km 3.00." in told
    assert str(tmp_path / "out") in out
    assert FILES <= {path.name for path in (tmp_path / "out").iterdir()}


def test_points_that_may_be_far_from_the_optimum_are_noted():
    points = [
        {"gap_pct": gap_pct, "energy_kwh": 100.0, "lower_bound_kwh": bound_kwh, "margin_pct": margin_pct}
        for gap_pct, bound_kwh, margin_pct in (
            (0.0, 100.0, 0.0),
            (0.282, 99.718, 2.5),
            (None, None, 5.0),
            (0.11, 99.89, 7.5),
        )
    ]
    assert list(large_gaps({"front": points})) == [
        "2 of 4 points may be more than 0.1 % above the optimum, at most 0.282 % (0.282 kWh) at margin 2.50 %"
    ]
    assert not list(large_gaps({"front": points[:1]}))
    (note,) = large_gaps({"front": [*points[:1], {**points[0], "gap_pct": -0.0441}]})
    assert note.startswith("1 of 2 points are below their lower bound, by 0.044 % at most")


def test_json_is_one_object_on_stdout(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--json") == 0
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert content["schema"] == "tgvdp.search/1"
    assert {"fastest", "front", "counters", "provenance"} <= set(content)
    figures = {"peak_power_kw", "balance", "ride", "advice"}
    assert set(content["fastest"]) == {"time_s", "energy_kwh", "stepped_time_s"} | figures
    for point in content["front"]:
        assert point["replay"]["ok"]
        assert {"id", "time_s", "delay_s", "margin_pct", "energy_kwh", "saved_pct"} <= set(point)
    assert content == json.loads((tmp_path / "result.json").read_text())
    assert "margin" in err


def test_quiet_prints_nothing(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_quiet_json_prints_the_object_alone(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--quiet", "--json") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["front"]
    assert err == ""


def test_certificate_is_given_unless_declined(tmp_path, capsys):
    assert search(tmp_path / "proven", *SHORT, "--json") == 0
    content = json.loads(capsys.readouterr().out)
    for point in content["front"][1:]:
        assert point["lower_bound_kwh"] <= point["energy_kwh"]
        assert 0.0 <= point["gap_pct"] < 5.0
        assert point["price_kwh_per_min"] > 0.0
    assert content["front"][0]["price_kwh_per_min"] is None
    assert {"elapsed_s", "elapsed_verify_s", "elapsed_certify_s"} <= set(content["provenance"])

    assert search(tmp_path / "plain", *SHORT, "--no-certify", "--json") == 0
    out, err = capsys.readouterr()
    declined = json.loads(out)
    assert all(point["gap_pct"] is None for point in declined["front"])
    assert "elapsed_certify_s" not in declined["provenance"]
    assert "gap" not in err
    assert (tmp_path / "plain" / "front.png").read_bytes() != (tmp_path / "proven" / "front.png").read_bytes()


def test_grid_has_bounds_but_no_prices(tmp_path, capsys):
    trip = ("--track", "flat-100km", "--to", "3000", "--max-margin", "20")
    assert search(tmp_path, *trip, "--method", "exact", "--segment", "200", "--speeds", "40", "--json") == 0
    out, err = capsys.readouterr()
    front = json.loads(out)["front"]
    assert all(point["lower_bound_kwh"] <= point["energy_kwh"] for point in front)
    assert all(point["price_kwh_per_min"] is None for point in front)
    assert "kWh/min" not in err


def test_stations_of_a_metro(shared, tmp_path, capsys):
    tracks = shared / "ttobench"
    code = search(
        tmp_path,
        "--track",
        str(tracks / "tracks" / "CN_Songjiazhuang_Yizhuang.json"),
        "--train",
        str(next((tracks / "trains").glob("CN_*.json"), tracks / "trains" / "CH_Stadler_KISS_SBB.json")),
        "--to",
        "2631",
        "--points",
        "10",
        "--json",
    )
    assert code == 0
    content = json.loads(capsys.readouterr().out)
    assert len(content["front"]) > 1
    assert all(point["replay"]["ok"] for point in content["front"])
    with (tmp_path / "front.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(content["front"])


def test_partial_result_is_written_labelled_and_exits_with_5(tmp_path, capsys):
    code = search(
        tmp_path,
        "--track",
        "flat-100km",
        "--to",
        "5000",
        "--method",
        "best-first",
        "--segment",
        "500",
        "--speeds",
        "40",
        "--heuristic",
        "time",
        "--paths",
        "100000",
        "--max-labels",
        "1000",
        "--json",
    )
    out, err = capsys.readouterr()
    assert code == 5
    content = json.loads(out)
    assert content["complete"] is False
    assert content["warning"]
    assert "budget" in err
    assert (tmp_path / "result.json").exists()


def test_naive_search_ends_by_its_budget_with_a_clear_message(tmp_path, capsys):
    code = search(
        tmp_path / "out",
        "--track",
        "flat-100km",
        "--method",
        "best-first",
        "--no-dominance",
        "--no-bounds",
        "--max-labels",
        "100000",
    )
    out, err = capsys.readouterr()
    assert code == 5
    assert out == ""
    assert err.count("\n") == 1
    assert "budget" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_interrupt_leaves_no_files_and_exits_with_130(tmp_path):
    command = [
        sys.executable,
        "-m",
        "tgvdp",
        "search",
        "--method",
        "best-first",
        "--no-dominance",
        "--no-bounds",
        "--max-labels",
        "500000000",
        "--time-limit",
        "60",
        "--out",
        str(tmp_path / "out"),
    ]
    environment = {name: text for name, text in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        time.sleep(1.0)  # inside imports, compilation or the search: all must end alike
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors == "tgvdp: error: interrupted\n"
    assert not (tmp_path / "out").exists()


def test_tables_and_pictures_as_asked(tmp_path, capsys):
    arguments = (*SHORT, "--every", "500", "--format", "svg,pdf", "--price-per-kwh", "0.2", "--co2-g-per-kwh", "100")
    assert search(tmp_path, *arguments) == 0
    out = capsys.readouterr().out
    assert "cost" in out
    assert " kg" in out
    assert {path.suffix for path in tmp_path.iterdir()} == {".json", ".csv", ".svg", ".pdf"}
    with (tmp_path / "profiles.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["id"] == "0"]
    assert [float(row["position_m"]) for row in rows] == [0.0, 500.0, 1000.0, 1500.0, 2000.0, 2500.0, 3000.0]
    content = json.loads((tmp_path / "result.json").read_text())
    assert content["tariff"] == {"price_per_kwh": 0.2, "co2_g_per_kwh": 100.0}
    assert float(rows[-1]["time_s"]) == pytest.approx(content["front"][0]["time_s"], rel=1e-9)
    # What an earlier search wrote does not stay.
    assert search(tmp_path, *SHORT, "--no-pictures", "--quiet") == 0
    assert {path.suffix for path in tmp_path.iterdir()} == {".json", ".csv"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--format", "gif"), "there is no 'gif'; there are png, svg, pdf"),
        (("--format", ","), "there is none"),
        (("--every", "0"), "must be above 0 m"),
        (("--every", "100", "--profiles", "railtoolkit"), "--every is for profiles as csv"),
        (("--format", "svg", "--no-pictures"), "--format is of pictures: it and --no-pictures exclude each other"),
        (("--price-per-kwh", "-1"), "must be at least 0 €/kWh"),
    ],
)
def test_output_options_out_of_range(tmp_path, capsys, arguments, message):
    assert search(tmp_path / "out", *SHORT, *arguments) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("is_there", "time_s"), [(True, 9.0), (False, 2.0)])
def test_pictures_have_the_time_that_is_left_when_they_are_begun(monkeypatch, is_there, time_s):
    asked_s = [9.0]
    monkeypatch.setattr("tgvdp.cli.search.left_s", lambda _: asked_s[-1])
    second = SimpleNamespace(is_there=is_there, promise=lambda task, formats, time_s: lambda: {task: time_s})
    wait = _asked(second, "front_files", ["png"], None)
    asked_s.append(2.0)
    assert wait() == {"tgvdp.report.gallery:front_files": time_s}
