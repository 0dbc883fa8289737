"""Presets reproduce what other tools publish, from their own files, in Python and on the command line."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.documented_case import OSRD_TRACK, OSRD_TRAIN
from tests.helpers.format_case import write_json
from tests.helpers.railtoolkit_case import INTERCITY_2
from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.formats import load_track, load_train


@pytest.mark.parametrize(
    ("origin_m", "destination_m", "time_s", "energy_kwh", "switches_m"),
    [(0.0, 6000.0, 231.17, 280.25, (2726.0, 4029.0)), (6000.0, 10_000.0, 185.57, 227.37, (8292.0,))],
)
def test_osrd_brakes_and_accelerates_where_it_says(origin_m, destination_m, time_s, energy_kwh, switches_m):
    ends = {"origin_m": origin_m, "destination_m": destination_m}
    fastest = tgvdp.search(OSRD_TRAIN, OSRD_TRACK, convention="osrd", points=2, **ends).fastest
    assert fastest.time_s == pytest.approx(time_s, abs=0.01)
    assert fastest.energy_j / 3.6e6 == pytest.approx(energy_kwh, abs=0.02)
    regimes = fastest.profile.regime
    found_m = fastest.profile.position_m[1:-1][np.diff(regimes[:-1]) != 0]
    assert found_m == pytest.approx(np.array(switches_m), abs=2.0)


@pytest.mark.parametrize("path", ["const", "slope", "speed"])
@pytest.mark.parametrize(("name", "longer"), [("local", 1.005), ("freight", 1.0042)])
def test_trainruns_running_times(shared, name, longer, path):
    """To 0.05 s by its own steps; what these converge to stands beside it."""
    folder = shared / "railtoolkit"
    published_s = float((folder / "snapshots" / f"{name}_{path}.csv").read_text().split()[1])
    train, track = load_train(folder / "trains" / f"{name}.yaml"), load_track(folder / "paths" / f"{path}.yaml")
    result = tgvdp.search(train, track, convention="trainruns", points=2)
    assert result.fastest.stepped_time_s == pytest.approx(published_s, abs=0.05)
    assert result.fastest.time_s / published_s == pytest.approx(longer, abs=0.001)
    assert all(verdict.ok for verdict in result.verify())


@pytest.mark.parametrize(("path", "published_s"), [("const", 330.746), ("slope", 331.609), ("speed", 501.021)])
def test_trainruns_running_times_of_a_locomotive_with_coaches(shared, tmp_path, path, published_s):
    """Published in test/snapshots/default/longdistance_*.csv of TrainRuns.jl."""
    train = load_train(write_json(tmp_path / "train.json", INTERCITY_2))
    track = load_track(shared / "railtoolkit" / "paths" / f"{path}.yaml")
    result = tgvdp.search(train, track, convention="trainruns", points=2)
    assert result.fastest.stepped_time_s == pytest.approx(published_s, abs=0.05)


@pytest.mark.parametrize("convention", ["ttobench", "osrd"])
@pytest.mark.parametrize("rates", [((0.0, 0.5),), ((0.0, 0.55), (20.0, 0.5), (35.0, 0.45))])
def test_braking_rates_are_certified(convention, rates):
    """A bound that took the brakes for stronger than the rates would lie far below."""
    train = replace(OSRD_TRAIN, braking_rates=rates)
    track = replace(OSRD_TRACK, gradients=((0.0, 0.0), (3000.0, 6.0), (6000.0, -5.0)))
    result = tgvdp.search(train, track, convention=convention, points=8)
    gaps_pct = result.certify().gap_pct
    assert (gaps_pct >= -1e-6).all()
    assert (gaps_pct[1:] < 0.5).all()


def test_the_command_line_follows_a_convention(shared, tmp_path, capsys):
    folder = shared / "railtoolkit"
    files = ["--train", str(folder / "trains" / "local.yaml"), "--track", str(folder / "paths" / "slope.yaml")]
    options = ["--convention", "trainruns", "--points", "3", "--no-certify", "--profiles", "railtoolkit"]
    assert main(["search", *files, *options, "--out", str(tmp_path)]) == 0
    assert "by the explicit steps of the convention" in capsys.readouterr().out
    published_s = float((folder / "snapshots" / "local_slope.csv").read_text().split()[1])
    content = json.loads((tmp_path / "result.json").read_text())
    assert content["fastest"]["stepped_time_s"] == pytest.approx(published_s, abs=0.05)
    course = (tmp_path / "driving_course.csv").read_text()
    assert course.startswith("id,label,driving_mode,s,v,t,a,")


def test_ttobench_tunnels_count_when_asked(shared, tmp_path):
    """The reference track with tunnels, and the coefficient of each train for one cross section."""
    track = load_track(shared / "ttobench" / "tracks" / "00_reference_with_tunnels.json")
    train = load_train(shared / "ttobench" / "trains" / "CH_Stadler_KISS_SBB.json")
    areas_m2 = {row.cross_section_m2 for row in track.tunnels}
    known = {row.cross_section_m2 for row in train.tunnel_drag}
    plain = tgvdp.search(train, track, points=3)
    assert track.tunnels
    if areas_m2 <= known:
        slowed = tgvdp.search(train, track, points=3, tunnels=True)
        assert slowed.fastest.time_s > plain.fastest.time_s
        assert slowed.fastest.energy_j > plain.fastest.energy_j
        assert all(verdict.ok for verdict in slowed.verify())
    else:
        with pytest.raises(InputError, match=re.escape("tunnel_drag is not known for")):
            tgvdp.search(train, track, points=3, tunnels=True)
