"""``tgvdp score``: a recorded run against the front."""

import json
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tgvdp.cli import main
from tgvdp.model.track import NeutralSection
from tgvdp.report.scores import plot_score, score_object

TRIP = {"train": "alstom-emu", "track": "flat-100km"}
COMMAND_TRIP = ("--train", "alstom-emu", "--track", "flat-100km")


def record(path, profile, *, head="position_m,speed_kmh", every_m=20.0):
    """Write a run of the model as a record: v² is linear in position within a row."""
    x = np.arange(profile.position_m[0], profile.position_m[-1], every_m)
    x = np.union1d(x, profile.position_m)
    v = np.sqrt(np.interp(x, profile.position_m, profile.speed_mps**2))
    path.write_text("\n".join([head, *(f"{a:.9f},{3.6 * b:.9f}" for a, b in zip(x, v, strict=True))]))
    return path


@pytest.fixture(scope="module")
def result():
    return tgvdp.search(*TRIP.values(), destination_m=10_000.0, at_margin=(0.05, 0.1))


@pytest.fixture(scope="module")
def capped(result, tmp_path_factory):
    """A driver who holds 100 km/h, and brakes late."""
    slow = replace(result.trip.train, max_speed_mps=100 / 3.6)
    profile = tgvdp.search(slow, result.trip.track, destination_m=10_000.0, points=2).fastest.profile
    return profile, record(tmp_path_factory.mktemp("score") / "run.csv", profile)


def test_the_optimum_itself_cannot_be_improved(result, tmp_path):
    profile = result.profile(len(result.front) - 1)
    score = tgvdp.score_run(tgvdp.load_run(record(tmp_path / "run.csv", profile)), *TRIP.values())
    assert score.time_s == pytest.approx(profile.duration_s, rel=1e-6)
    assert repr(score).startswith(f"<Score: run.csv in {score.time_s:.1f} s, ")
    assert score.recorded.total_energy_j == pytest.approx(profile.total_energy_j, rel=1e-3)
    assert abs(score.saving_j) < 2e-3 * profile.total_energy_j
    assert score.warnings == ()


def test_what_is_no_record_is_refused():
    """The path of one ended in an AttributeError."""
    with pytest.raises(tgvdp.InputError, match=r"run must be a RecordedRun, as of load_run, got 'run\.csv'"):
        tgvdp.score_run("run.csv", *TRIP.values())


def test_regimes_of_both_runs_are_told_in_the_same_way(tmp_path):
    """On hills an optimum lets its speed rise a little while it pulls in part: of the record that was traction."""
    profile = tgvdp.search("tgv", "lgv-100km", at_margin=(0.05,)).profile(0)
    content = score_object(
        tgvdp.score_run(tgvdp.load_run(record(tmp_path / "run.csv", profile, every_m=500.0)), "tgv", "lgv-100km")
    )
    assert content["recorded"]["distance_pct"] == pytest.approx(content["optimum"]["distance_pct"], abs=1.0)


def test_traction_without_current_is_a_doubt(result, tmp_path):
    """It was free where the pantograph is lowered, so that a record "beat" the optimum by 20 %."""
    profile = result.profile(len(result.front) - 1)
    train, track = result.trip.train, result.trip.track
    pulls = int(np.argmax(profile.speed_mps > 0.6 * profile.speed_mps.max()))
    neutral = (NeutralSection(float(profile.position_m[pulls]), 300.0, True),)
    path = record(tmp_path / "run.csv", profile)
    score = tgvdp.score_run(tgvdp.load_run(path), train, replace(track, neutral_sections=neutral))
    assert any("where the line has no current" in warning for warning in score.warnings)
    obeys = tgvdp.search(train, replace(track, neutral_sections=neutral), destination_m=10_000.0, at_margin=(0.1,))
    path = record(tmp_path / "obeys.csv", obeys.profile(0))
    score = tgvdp.score_run(tgvdp.load_run(path), train, replace(track, neutral_sections=neutral))
    assert score.warnings == ()


def test_positions_alone_tell_the_same(result, tmp_path):
    """Neither a start at speed nor an overspeed or a saving is made of the means between positions."""
    profile = result.profile(len(result.front) - 1)
    t = np.append(np.arange(0.0, profile.duration_s, 1.0), profile.duration_s)
    row = np.searchsorted(profile.time_s, t, side="right").clip(1, profile.time_s.size - 1) - 1
    v0, since_s = profile.speed_mps[row], t - profile.time_s[row]
    x = profile.position_m[row] + 0.5 * (v0 + np.interp(t, profile.time_s, profile.speed_mps)) * since_s
    path = tmp_path / "gps.csv"
    path.write_text("\n".join(["time_s,position_m", *(f"{a:.2f},{b:.2f}" for a, b in zip(t, x, strict=True))]))
    score = tgvdp.score_run(tgvdp.load_run(path), *TRIP.values())
    assert (score.result.trip.start_speed_mps, score.result.trip.end_speed_mps) == (0.0, 0.0)
    assert score.result.fastest.time_s == pytest.approx(result.fastest.time_s, rel=1e-6)
    assert abs(score.saving_j) < 2e-3 * profile.total_energy_j
    assert score.warnings == ()


@pytest.mark.parametrize("has_speeds", [False, True])
@pytest.mark.parametrize("every_s", [7.0, 30.0, 60.0])
def test_a_limit_that_is_kept_is_so_however_rare_the_rows_are(every_s, has_speeds, tmp_path):
    """What the model makes of slopes and of a constant acceleration between two rows is nothing that was driven."""
    profile = tgvdp.search("tgv", "lgv-100km", points=2).fastest.profile
    t = np.append(np.arange(0.0, profile.duration_s, every_s), profile.duration_s)
    row = np.searchsorted(profile.time_s, t, side="right").clip(1, profile.time_s.size - 1) - 1
    v = np.interp(t, profile.time_s, profile.speed_mps)
    x = profile.position_m[row] + 0.5 * (profile.speed_mps[row] + v) * (t - profile.time_s[row])
    names, columns = ["time_s", "position_m", "speed_mps"][: 2 + has_speeds], (t, x, v)[: 2 + has_speeds]

    def warned(scale):
        scaled = [column * by for column, by in zip(columns, (1.0 / scale, 1.0, scale), strict=False)]
        lines = (",".join(f"{value:.4f}" for value in row) for row in zip(*scaled, strict=True))
        path = tmp_path / "run.csv"
        path.write_text("\n".join([",".join(names), *lines]))
        warnings = tgvdp.score_run(tgvdp.load_run(path), "tgv", "lgv-100km").warnings
        return [warning for warning in warnings if "exceeds a speed limit" in warning]

    assert warned(1.0) == []
    assert warned(1.02) != []


def test_speeds_at_ends_that_positions_do_not_tell_are_doubted(result, tmp_path):
    """It brakes for the last 15 s, of which two rows know."""
    path = tmp_path / "gps.csv"
    x = np.concatenate(([20_000.0], 20_000.0 + np.cumsum([400.0] * 17 + [350.0, 250.0])))
    path.write_text("\n".join(["time_s,position_m", *(f"{10 * at},{b}" for at, b in enumerate(x))]))
    score = tgvdp.score_run(tgvdp.load_run(path), *TRIP.values())
    assert "no speeds are recorded: those at its ends, 40 and" in score.warnings[0]


def test_a_late_braker_is_told_what_it_cost(capped):
    profile, path = capped
    score = tgvdp.score_run(tgvdp.load_run(path), *TRIP.values())
    assert score.recorded.total_energy_j == pytest.approx(profile.total_energy_j, rel=1e-4)
    assert score.optimum.duration_s == pytest.approx(profile.duration_s, abs=0.05)
    assert score.saving_j > 0.05 * profile.total_energy_j
    # Work at the wheel ends in brakes or against resistance, for the speeds at the ends are the same.
    assert score.saving_in_brakes_j + score.saving_in_resistance_j == pytest.approx(score.saving_j, rel=1e-9)
    assert score.saving_in_brakes_j > 0.0
    # The same energy on the front, found by a search of its own.
    earlier = tgvdp.search(*TRIP.values(), destination_m=10_000.0, at_s=(score.time_for_energy_s,))
    assert earlier.front.energy_j[-1] == pytest.approx(score.recorded.total_energy_j, rel=0.01)


def test_parts_add_up(capped):
    content = score_object(tgvdp.score_run(tgvdp.load_run(capped[1]), *TRIP.values(), energy="pantograph"))
    for name in ("recorded", "optimum"):
        assert sum(part[f"{name}_kwh"] for part in content["parts"]) == pytest.approx(content[name]["energy_kwh"])
        assert sum(content[name]["distance_pct"].values()) == pytest.approx(100.0)
    assert content["saving_kwh"] == pytest.approx(content["recorded"]["energy_kwh"] - content["optimum"]["energy_kwh"])
    assert content["energy"] == "pantograph"


def test_the_picture_shows_both_runs_and_the_way_to_the_front(capped):
    score = tgvdp.score_run(tgvdp.load_run(capped[1]), *TRIP.values())
    speed, energy, front = plot_score(score).axes
    assert speed.get_title(loc="left") == "What could this run have saved?"
    assert [line.get_label() for line in energy.lines] == ["recorded", "optimum of that time"]
    assert energy.lines[0].get_ydata()[-1] == pytest.approx(score.recorded.total_energy_j / 3.6e6)
    (mark,) = (line for line in front.lines if line.get_label() == "recorded")
    assert mark.get_ydata()[0] == pytest.approx(score.recorded.total_energy_j / 3.6e6)
    assert f"{score.saving_j / 3.6e6:.4g} kWh" in [text.get_text() for text in front.texts]


def test_command_writes_and_prints(capped, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["score", str(capped[1]), "--train", "alstom-emu", "--track", "flat-100km", "--out", str(out)]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "the optimum of that time saves" in text
    assert "most of it between" in text
    assert {path.name for path in out.iterdir()} == {"score.json", "score.png", "provenance.json"}
    assert main([*arguments, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["schema"] == "tgvdp.score/1"
    assert set(content["provenance"]["inputs"]) == {"record", "train", "track"}


def test_a_time_that_no_record_tells_is_not_said(result, tmp_path, capsys):
    """With the energy of the optimum itself it was said to arrive 2.7e-05 s earlier."""
    run = record(tmp_path / "run.csv", result.profile(len(result.front) - 1))
    assert main(["score", str(run), *COMMAND_TRIP, "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    assert "earlier" not in told
    assert "the optimum of that time takes as much, to 0.05 %" in told
    assert "more" not in told


def test_an_optimum_that_saves_nothing_is_said_to_take_more(capped, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tgvdp.api.Score, "saving_j", -3.6e5)
    arguments = ["score", str(capped[1]), "--train", "alstom-emu", "--track", "flat-100km"]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    assert "the optimum of that time takes 0.1 kWh more, " in capsys.readouterr().out


def test_a_run_faster_than_the_model_is_doubted(result, tmp_path, capsys):
    profile, path = result.fastest.profile, tmp_path / "fast.csv"
    t = np.arange(0.0, profile.duration_s, 1.0)
    rows = zip(0.9 * t, np.interp(t, profile.time_s, profile.position_m), strict=True)
    path.write_text("\n".join(["time_s;position_km", *(f"{a:.2f};{b / 1000:.5f}".replace(".", ",") for a, b in rows)]))
    assert (
        main(["score", str(path), "--train", "alstom-emu", "--track", "flat-100km", "--out", str(tmp_path / "out")])
        == 0
    )
    out, err = capsys.readouterr()
    assert "less than the fastest run of the model" in err
    assert "exceeds a speed limit" in err
    assert "more traction than the train has" in err
    assert "the fastest run of the model saves" in out
    assert "earlier" not in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "200km"], "the line from 0 m to 100000 m"),
        (["--section", "2"], "section must be from 1 to 1, got 2"),
        (["--train", "nobody"], "nobody"),
    ],
)
def test_records_that_do_not_fit(capped, tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["score", str(capped[1]), "--train", "alstom-emu", "--track", "flat-100km", *arguments]) == 3
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_several_sections_are_to_be_chosen(tmp_path, capsys):
    t = np.arange(0.0, 400.0)
    v = np.select(
        [(t > 5) & (t < 180), (t > 220) & (t < 380)], [np.minimum(t - 5, 180 - t), np.minimum(t - 220, 380 - t)], 0
    )
    path = tmp_path / "day.csv"
    path.write_text("\n".join(["time_s,speed_mps", *(f"{a},{min(b, 20) * 0.5}" for a, b in zip(t, v, strict=True))]))
    arguments = ["score", str(path), "--train", "alstom-emu", "--track", "flat-100km", "--out", str(tmp_path / "out")]
    assert main(arguments) == 3
    assert "has 2 sections between stands" in capsys.readouterr().err
    assert main([*arguments, "--section", "2", "--from", "0"]) == 0
