"""Rows through a cell last as long as the equation of motion says, however much of the speed goes there."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tgvdp.methods.costate.forward_brakes import coast_through
from tgvdp.methods.costate.forward_cell import drive_cell
from tgvdp.methods.costate.forward_lines import Lines, coast_then_pull
from tgvdp.methods.costate.forward_rows import coast, evenly
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import Train
from tgvdp.physics.cell import Cell, rest_of, room_for_marches, room_for_rows
from tgvdp.physics.codes import TRACTION
from tgvdp.physics.forces import kernel_train, mean_effort, mean_resistance
from tgvdp.physics.march import march

FREIGHT = Train(
    mass_kg=2.5e6,
    traction=EffortCurve.from_caps(4e5, 4.6e6),
    friction_brake_n=1.5e6,
    davis_a_n=3e4,
    davis_b_n_per_mps=360.0,
    davis_c_n_per_mps2=32.0,
)


#: 0.5 t with a strong drag: rows of a cell are stiff.
LIGHT = Train(
    mass_kg=500.0,
    traction=EffortCurve.from_caps(1000.0),
    friction_brake_n=500.0,
    davis_a_n=8.0,
    davis_b_n_per_mps=0.4,
    davis_c_n_per_mps2=2.0,
)


def march_room():
    return room_for_marches(1000, "test: march")


def full_traction_n(v):
    return min(4e5, 4.6e6 / v)


def brakes_n(v):
    return -2e3


@pytest.mark.parametrize(
    ("effort_n", "start_mps", "permil", "length_m"),
    [(full_traction_n, 20.0, 9.7, 4200.0), (brakes_n, 24.0, -9.0, 1500.0)],
    ids=["full traction that slows down", "the friction brake alone"],
)
def test_rows_last_as_long_as_the_motion(effort_n, start_mps, permil, length_m):
    grade_n = FREIGHT.mass_kg * 9.81e-3 * permil
    train = kernel_train(FREIGHT)._replace(rows=4.0, other_rows=2.0)  # finer than fronts are driven

    def slopes(_, state):
        v = math.sqrt(state[0])
        load_n = FREIGHT.davis_a_n + v * (FREIGHT.davis_b_n_per_mps + v * FREIGHT.davis_c_n_per_mps2) + grade_n
        return 2.0 * (effort_n(v) - load_n) / FREIGHT.inertia_kg, 1.0 / v

    (end_w, seconds) = solve_ivp(slopes, (0.0, length_m), (start_mps**2, 0.0), rtol=1e-11, atol=1e-9).y[:, -1]
    rows = room_for_rows(1000, "test")
    cell = Cell(0.0, length_m, length_m, grade_n, FREIGHT.davis_c_n_per_mps2, math.inf)
    n = evenly(train, cell, start_mps**2, end_w, march_room(), rows, 0)
    x_m, v = np.concatenate(([0.0], rows.x[:n])), np.sqrt(np.concatenate(([start_mps**2], rows.w[:n])))
    assert (x_m[-1], v[-1] ** 2) == pytest.approx((length_m, end_w), rel=1e-7)
    assert float(np.sum(2.0 * np.diff(x_m) / (v[:-1] + v[1:]))) == pytest.approx(seconds, rel=5e-6)


@pytest.mark.parametrize(
    ("start_mps", "length_m", "permil", "davis_b_share"),
    [
        *((v, d, permil, 1.0) for v in (15.0, 25.0, 40.0) for d in (0.5, 40.0, 150.0) for permil in (-12.0, 0.0, 9.0)),
        *((v, 1500.0, -40.0, share) for v in (0.0, 1e-3, 0.3, 3.0) for share in (1.0, 20.0)),
    ],
)
def test_coasting_solves_its_row_to_rounding(start_mps, length_m, permil, davis_b_share):
    """Newton's rule solves w₁ = w₀ − 2·d/m·(mean resistance + grade), from next to a standstill, too."""
    train = kernel_train(FREIGHT)
    train = train._replace(davis_b=davis_b_share * train.davis_b)
    cell = Cell(0.0, length_m, length_m, FREIGHT.mass_kg * 9.81e-3 * permil, FREIGHT.davis_c_n_per_mps2, math.inf)

    def excess(w):
        load_n = mean_resistance(train, cell.air, start_mps, math.sqrt(w)) + cell.grade_n
        return w - start_mps**2 + 2.0 * length_m / train.inertia_kg * load_n

    expected = brentq(excess, 1e-6, max(4.0 * start_mps**2, 4e3), xtol=1e-12, rtol=1e-14)
    assert coast(train, cell, length_m, start_mps**2) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("end_mps", [21.0, 24.0])
def test_rows_of_one_effort_are_of_one_effort(end_mps):
    """The effort that leads to the target is found so well that what the last row makes up for is nothing."""
    train = kernel_train(FREIGHT)
    cell = Cell(0.0, 2000.0, 2000.0, 0.0, FREIGHT.davis_c_n_per_mps2, math.inf)
    rows = room_for_rows(100, "test")
    n = evenly(train, cell, 22.0**2, end_mps**2, march_room(), rows, 0)
    assert n > 2
    w = np.concatenate(([22.0**2], rows.w[:n]))
    v = np.sqrt(w)
    gains_n = 0.5 * train.inertia_kg * np.diff(w) / np.diff(rows.x[:n], prepend=0.0)
    loads_n = [mean_resistance(train, cell.air, v0, v1) for v0, v1 in pairwise(v)]
    efforts_n = gains_n + loads_n
    np.testing.assert_allclose(efforts_n, efforts_n[0], rtol=1e-5)


def test_several_rows_pull_no_more_than_one_may():
    """One row would do with full traction, as its drag grows along a straight line; the motion needs more of it."""
    train = kernel_train(LIGHT)
    cell = Cell(0.0, 300.0, 300.0, -100.0, LIGHT.davis_c_n_per_mps2, math.inf)
    start_w = 21.0**2

    def pulled_n(end_w):
        load_n = mean_resistance(train, cell.air, math.sqrt(start_w), math.sqrt(end_w)) + cell.grade_n
        return 0.5 * train.inertia_kg * (end_w - start_w) / cell.length_m + load_n

    end_w = brentq(lambda w: pulled_n(w) - 999.99, start_w, 30.0**2)
    rows = room_for_rows(1000, "test")
    n = evenly(train, cell, start_w, end_w, march_room(), rows, 0)
    w = np.concatenate(([start_w], rows.w[:n]))
    loads_n = [mean_resistance(train, cell.air, v0, v1) + cell.grade_n for v0, v1 in pairwise(np.sqrt(w))]
    efforts_n = 0.5 * train.inertia_kg * np.diff(w) / np.diff(rows.x[:n], prepend=0.0) + loads_n
    assert efforts_n.max() <= 1000.0 * (1.0 + 1e-6)
    assert rows.x[n - 1] == cell.length_m


def test_nearly_full_effort_downhill_is_full_traction_and_coasting():
    """The limit falls along the cell below the effort of a single row, which was 20 ms off the motion it stood for."""
    train = kernel_train(replace(FREIGHT, mass_kg=4.2e5, davis_a_n=7e3, davis_b_n_per_mps=200.0))
    cell = Cell(0.0, 680.0, 680.0, -4.2e5 * 9.81e-3 * 15.0, 6.0, 80.0**2)
    start_w, rows = 36.3**2, room_for_rows(1000, "test")
    fastest_w = march(train, TRACTION, 1.0, cell, cell.length_m, start_w, math.inf, rows, 0)[1]
    end_w = start_w + 0.98 * (fastest_w - start_w)
    n = evenly(train, cell, start_w, end_w, march_room(), rows, 0)
    x_m, w = np.concatenate(([0.0], rows.x[:n])), np.concatenate(([start_w], rows.w[:n]))
    assert (x_m[-1], w[-1]) == (cell.length_m, end_w)
    v = np.sqrt(w)
    loads_n = np.array([mean_resistance(train, cell.air, v0, v1) + cell.grade_n for v0, v1 in pairwise(v)])
    efforts_n = 0.5 * train.inertia_kg * np.diff(w) / np.diff(x_m) + loads_n
    limits_n = np.array([mean_effort(train.traction, v0, v1) for v0, v1 in pairwise(v)])
    pulls = efforts_n > 1.0
    np.testing.assert_allclose(efforts_n[pulls], limits_n[pulls], rtol=1e-5)
    np.testing.assert_allclose(efforts_n[~pulls], 0.0, atol=1.0)
    assert pulls[0] and not pulls[-1] and np.count_nonzero(np.diff(pulls)) == 1


def test_coasting_beyond_the_line_of_the_dynamic_brake_needs_no_brakes():
    """One row would end on that line, several end above it: none of them is bent down to it."""
    train = kernel_train(LIGHT)
    cell = Cell(0.0, 100.0, 100.0, 100.0, LIGHT.davis_c_n_per_mps2, math.inf)
    start_w = 24.0**2
    landed = coast(train, cell, cell.length_m, start_w)
    lines = Lines(*[1e4] * 3, 0.0, 0.0, 1e4, landed, landed, landed, 1e4, 0.0, 0.0, 1e4, math.inf)
    rows = room_for_rows(1000, "test")
    n = coast_through(train, True, cell, start_w, landed, lines, march_room(), rows, 0)
    assert n > 2
    w = np.concatenate(([start_w], rows.w[:n]))
    loads_n = [mean_resistance(train, cell.air, v0, v1) + cell.grade_n for v0, v1 in pairwise(np.sqrt(w))]
    efforts_n = 0.5 * train.inertia_kg * np.diff(w) / np.diff(rows.x[:n], prepend=0.0) + loads_n
    np.testing.assert_allclose(efforts_n, 0.0, atol=1e-6 * max(loads_n))


@pytest.mark.parametrize("left_m", [7e-4, 0.7])
def test_traction_up_to_a_hand_before_the_end_of_a_cell_goes_on_to_its_end(left_m):
    """What is left was coasted, and the error of the rows before it was an effort of its own, that no rate allowed."""
    train, cell = kernel_train(FREIGHT), Cell(0.0, 15.0, 15.0, 0.0, 32.0, 900.0)
    scratch, rows = march_room(), room_for_rows(100, "test: rows")
    rows.x[0], rows.w[0] = 0.0, 225.0
    line = march(train, TRACTION, 1.0, cell, 15.0 - left_m, 225.0, math.inf, scratch, 0)[1]
    lines = Lines(
        line, 900.0, 900.0, 0.0, 0.0, 900.0, line, line, 900.0, 900.0, 0.0, 0.0, line * (1.0 - 1e-9), math.inf
    )
    n = drive_cell(train, False, cell, cell, 225.0, lines, scratch, rows, 1)
    assert rows.x[n - 1] == 15.0
    assert rows.w[n - 1] <= lines.top
    assert np.diff(rows.x[:n]).min() > min(0.1, left_m)


def test_full_traction_that_slows_down_begins_where_it_ends_on_the_target():
    """A train coasts up a climb to 300 m, and pulls from there on; its line was met at 500 m, and could not be held."""
    train, length_m, pulls_m, start_w = kernel_train(FREIGHT), 700.0, 300.0, 20.0**2
    cell = Cell(0.0, length_m, length_m, FREIGHT.mass_kg * 9.81 * 16e-3, 0.5 * FREIGHT.davis_c_n_per_mps2, math.inf)
    rows = room_for_rows(100, "test")
    rows.x[0], rows.w[0] = 0.0, start_w
    met_w = coast(train, cell, pulls_m, start_w)
    late = rest_of(cell, pulls_m, length_m - pulls_m)
    target_w = march(train, TRACTION, 1.0, late, late.length_m, met_w, math.inf, march_room(), 0)[1]
    assert target_w < met_w
    n = coast_then_pull(train, cell, start_w, 500.0, target_w, rows, 1)
    assert (rows.x[n - 1], rows.w[n - 1]) == (length_m, target_w)
    assert rows.x[:n] == pytest.approx(np.sort(rows.x[:n]))
    assert np.interp(pulls_m, rows.x[:n], rows.w[:n]) == pytest.approx(met_w, rel=1e-6)
    assert coast_then_pull(train, cell, start_w, 500.0, start_w, rows, 1) == 1  # not even all the way
