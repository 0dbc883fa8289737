"""The published files of TTOBench with their values, and other versions of its library."""

import json
import math

import pytest

from tests.helpers.format_case import TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, write_json
from tests.helpers.refusal import refusal
from tgvdp.formats import describe_file, load_track, load_train
from tgvdp.formats.detect import load_all
from tgvdp.model.track import Curve, Gradient, SpeedLimit

TRACKS = [
    "00_reference",
    "00_reference_with_tunnels",
    "00_var_gradient_minus_5",
    "00_var_gradient_plus_10",
    "00_var_speed_limit_100",
    "00_var_speed_limit_wind",
    "CH_StGallen_Wil",
    "CN_Songjiazhuang_Yizhuang",
]
TRAINS = ["CH_Stadler_KISS_SBB", "CN_Beijing_Subway"]


@pytest.mark.parametrize("version", ["TTOBench v9.0", "TTOBench v1.6", "TTOBench v1.10", "TTOBench v11.5", ""])
def test_other_versions_of_the_library_are_refused(tmp_path, version):
    field = "metadata", "library version"
    for tree in (TTOBENCH_TRAIN, TTOBENCH_TRACK):
        told = f"metadata.library version: must be TTOBench v1.1 to v1.5, got {version!r}"
        assert refusal(load_all, write_json(tmp_path / "toy.json", changed(tree, field, version))) == told
        (held,) = load_all(write_json(tmp_path / "toy.json", changed(tree, field, "TTOBench v1.1")))
        assert held.name == "toy"


@pytest.mark.parametrize("name", TRACKS)
def test_every_published_track_loads_with_its_values(shared, name):
    path = shared / "ttobench" / "tracks" / f"{name}.json"
    published = json.loads(path.read_text(encoding="utf-8"))
    track = load_track(path)
    assert track.name == name
    assert list(track.stops_m) == published["stops"]["values"]
    assert [[p, pytest.approx(v * 3.6, rel=1e-15)] for p, v in track.speed_limits] == published["speed limits"][
        "values"
    ]
    assert [list(row) for row in track.gradients] == published["gradients"]["values"]
    curves = [["infinity" if math.isinf(v) else v for v in row] for row in track.curves]
    assert curves == published.get("curvatures", {"values": []})["values"]
    assert [list(row) for row in track.tunnels] == published.get("tunnels", {"values": []})["values"]
    assert "km/h" in describe_file(path).headline


def test_the_tracks_seen_are_all_there_are(shared):
    assert sorted(path.stem for path in (shared / "ttobench" / "tracks").glob("*.json")) == TRACKS
    assert sorted(path.stem for path in (shared / "ttobench" / "trains").glob("*.json")) == TRAINS


def test_kiss_by_hand(shared):
    """Values converted by hand; r2 is used as published although it is twice the formula it cites."""
    train = load_train(shared / "ttobench" / "trains" / "CH_Stadler_KISS_SBB.json")
    assert (train.mass_kg, train.rotating_mass_factor) == (297e3, 1.1)
    assert train.traction.effort_n(0.0) == 400e3
    assert train.traction.effort_n(40.0) == pytest.approx(150e3)
    assert train.friction_brake_n == 2.97e6
    assert train.max_speed_mps * 3.6 == pytest.approx(160.0)
    assert train.davis_a_n == pytest.approx(5672.025)
    assert train.davis_b_n_per_mps == pytest.approx(91.61829)
    assert train.davis_c_n_per_mps2 == pytest.approx(15.6950784)
    assert (train.max_acceleration_mps2, train.max_deceleration_mps2) == (1.1, 1.1)
    assert (train.traction_efficiency, train.regeneration_efficiency) == (0.9, 0.9)


def test_beijing_by_hand(shared):
    train = load_train(shared / "ttobench" / "trains" / "CN_Beijing_Subway.json")
    assert (train.mass_kg, train.rotating_mass_factor, train.friction_brake_n) == (278e3, 1.0, 0.0)
    assert train.traction.effort_n(20.0) == pytest.approx(155e3)
    assert train.braking.effort_n(0.0) == 260e3
    assert train.braking.effort_n(20.0) == pytest.approx(216.65e3)
    assert train.davis_c_n_per_mps2 == pytest.approx(28.893024)
    assert train.davis_b_n_per_mps == 0.0
    assert train.max_acceleration_mps2 == math.inf


def test_st_gallen_wil_by_hand(shared):
    track = load_track(shared / "ttobench" / "tracks" / "CH_StGallen_Wil.json")
    assert (track.length_m, track.altitude_m) == (29556.1, 675.2)
    assert track.speed_limits[0] == SpeedLimit(0.0, 25.0)
    assert track.speed_limits[-1].speed_mps == pytest.approx(22.2222222222)
    assert track.curves[0] == Curve(0.0, 502.0, 502.0)
    assert track.gradients[0] == Gradient(0.0, 11.9)
