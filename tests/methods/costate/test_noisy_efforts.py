"""Effort curves that were measured or read off a drawing: hundreds of points, and noise."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, SpeedLimit, Track, Train
from tgvdp.methods.costate.forward_rows import evenly
from tgvdp.methods.costate.trend import train_of_trends
from tgvdp.physics.cell import Cell, room_for_marches, room_for_rows
from tgvdp.physics.forces import kernel_train, mean_effort

TOP_MPS, FORCE_N = 35.0, 2.16e6
SPEEDS_MPS = np.linspace(0.0, TOP_MPS, 500)
CLEAN_N = np.minimum(FORCE_N, 0.35 * FORCE_N * TOP_MPS / np.maximum(SPEEDS_MPS, 1e-9))
NOISE = np.random.default_rng(1).standard_normal(len(SPEEDS_MPS))
LEVEL = Track(length_m=10e3, speed_limits=(SpeedLimit(0.0, 33.0),))
HEAVY = Train(
    mass_kg=1.23e6, rotating_mass_factor=1.15, friction_brake_n=2.5e6, davis_a_n=12e3, davis_c_n_per_mps2=1300.0,
    max_speed_mps=33.0, traction=EffortCurve.from_points(list(zip(SPEEDS_MPS, CLEAN_N, strict=True))),
)  # fmt: skip


def noisy(share):
    points = list(zip(SPEEDS_MPS, CLEAN_N * (1.0 + share * NOISE), strict=True))
    return replace(HEAVY, traction=EffortCurve.from_points(points))


@pytest.mark.parametrize("share", [0.005, 0.02])
def test_a_noisy_curve_costs_what_its_trend_does(share):
    """Points were up to 17 % dearer, on 1,488 cells, and runs changed their effort in each of them."""
    clean, found = (tgvdp.search(train, LEVEL, points=12) for train in (HEAVY, noisy(share)))
    assert found.front.energy_j == pytest.approx(clean.front.energy_j, rel=4e-3)
    assert found.counters["cells"] < 2 * clean.counters["cells"]
    assert all(verdict.ok for verdict in found.verify())
    assert max(len(np.flatnonzero(np.diff(found.profile(i).regime))) for i in range(12)) < 12


def test_trends_are_means_over_the_speeds_of_a_cell():
    train = kernel_train(noisy(0.02))
    noise, trend = train.traction, train_of_trends(train, 60.0).traction
    asked = (SPEEDS_MPS > 15.0) & (SPEEDS_MPS < 30.0)
    off = trend[asked, 2] + trend[asked, 3] * SPEEDS_MPS[asked] - CLEAN_N[asked]
    assert np.abs(off).max() < 0.4 * 0.02 * np.abs(NOISE[asked] * CLEAN_N[asked]).max()
    whole_n = [mean_effort(table, 15.0, 30.0) for table in (noise, trend)]
    assert whole_n[0] == pytest.approx(whole_n[1], rel=5e-3)


def test_trends_are_of_cells_as_short_as_breaks_leave_them(shared):
    """Over the usual size of a cell a trend is another train's: this took 16 s, and 38,060 cells."""
    train = tgvdp.load_train(shared / "railtoolkit" / "trains" / "local.yaml")
    track = tgvdp.load_track(shared / "ttobench" / "tracks" / "CH_StGallen_Wil.json")
    found = tgvdp.search(train, track, convention="osrd", points=6)
    assert found.counters["cells"] < 3000
    assert np.nanmax(found.certify().gap_pct[2:]) < 0.1


@pytest.mark.parametrize(
    "curve",
    [
        EffortCurve.from_caps(2e5, 3e6),
        EffortCurve.from_points([(0, 2e5), (5, 1e5), (5, 1.5e5), (12, 8e4), (12, 1e5), (40, 3e4)]),  # gears
        EffortCurve.from_points(list(zip(SPEEDS_MPS, np.round(CLEAN_N, -4), strict=True))),  # rounded, and falling
    ],
)
def test_curves_without_noise_are_taken_as_they_are(curve):
    train = kernel_train(replace(HEAVY, traction=curve, mass_kg=2e5))
    assert train_of_trends(train, 60.0).traction is train.traction


def test_an_effort_stays_within_a_dip_of_its_limit():
    """Limits were looked at where a row begins and ends: one passed a dip between the two by 3 %, and its parts did."""
    dip = EffortCurve.from_points([(0, 9e4), (22.0, 9e4), (22.3, 8.6e4), (22.6, 9e4), (40.0, 9e4)])
    train = kernel_train(Train(mass_kg=2.7e5, traction=dip, friction_brake_n=3e5, davis_a_n=2e3))
    length_m, start_w = 60.0, 22.0**2
    end_w = start_w + 2.0 * length_m * (0.98 * 9e4 - 2e3) / 2.7e5
    cell, rows = Cell(0.0, length_m, length_m, 0.0, 0.0, math.inf), room_for_rows(1000, "test")
    n = evenly(train, cell, start_w, end_w, room_for_marches(1000, "test: march"), rows, 0)
    x_m, w = np.concatenate(([0.0], rows.x[:n])), np.concatenate(([start_w], rows.w[:n]))
    assert (x_m[-1], w[-1]) == (length_m, pytest.approx(end_w, rel=1e-3))
    for effort_n, v0, v1 in zip(
        0.5 * 2.7e5 * np.diff(w) / np.diff(x_m) + 2e3, np.sqrt(w), np.sqrt(w[1:]), strict=False
    ):
        least_n = min(dip.effort_n(v) for v in (v0, v1, min(max(v0, 22.3), v1)))
        is_full = effort_n == pytest.approx(mean_effort(train.traction, v0, v1), rel=1e-3)
        assert is_full or effort_n <= least_n
