"""Descents that a dynamic brake of limited power nearly holds."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train
from tgvdp.line.cells import cells_of
from tgvdp.methods.costate.descents import parts_on_descents
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import kernel_train

POWER_W, EFFORT_N = 6.6e6, 900e3
FREIGHT = Train(
    mass_kg=2.5e6, rotating_mass_factor=1.05, traction=EffortCurve.from_caps(530e3, 7.2e6),
    braking=EffortCurve.from_caps(EFFORT_N, POWER_W), friction_brake_n=1e6, davis_a_n=45e3, max_speed_mps=30.0,
    traction_efficiency=0.87, regeneration_efficiency=0.9,
)  # fmt: skip
TABLE = EffortCurve.from_points(
    [(0.0, EFFORT_N), *((float(v), min(EFFORT_N, POWER_W / v)) for v in np.linspace(1.0, 40.0, 80))]
)


def descending(permil):
    gradients = (Gradient(0.0, 0.0), Gradient(15e3, permil), Gradient(21e3, 0.0))
    return Track(length_m=40e3, speed_limits=(SpeedLimit(0.0, 25.0),), gradients=gradients)


def parts(permil):
    cells = cells_of(Trip(train=FREIGHT, track=descending(permil), origin_m=0.0, destination_m=40e3))
    return parts_on_descents(kernel_train(FREIGHT), cells, np.full(len(cells.station_m), 25.0**2)).tolist()


def test_cells_are_cut_where_runs_part_under_the_dynamic_brake():
    """Two that are next to the speed v that it holds part by exp(P/(m·v³)·s), as P/v falls by P/(2·v³) per v²."""
    pull_n = FREIGHT.mass_kg * 9.80665 * 30e-3 / math.hypot(1.0, 30e-3) - FREIGHT.davis_a_n
    held_mps = POWER_W / pull_n
    asked = 6e3 * POWER_W / (FREIGHT.inertia_kg * held_mps**3)
    assert parts(-30.0) == [1, pytest.approx(asked, rel=0.2), 1]


@pytest.mark.parametrize("permil", [-1.0, -5.0, 10.0])
def test_cells_stay_whole_where_the_dynamic_brake_holds_all_speeds_or_none_is_needed(permil):
    assert parts(permil) == [1, 1, 1]


def test_a_descent_that_the_dynamic_brake_nearly_holds_is_run_at_the_speed_of_its_full_power():
    """One step of the backward pass over hundreds of metres lost that speed: gaps of 0.5 %, and 5 s for the search."""
    result = tgvdp.search(replace(FREIGHT, braking=TABLE), descending(-40.0), points=8, energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.1
