"""Lines on which an extremal is hard to find: regeneration on steep grades, ends at speed, many blocks, long lines."""

import math

import numpy as np
import pytest

import tgvdp
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.methods.extremal.command import AT, BOUND, COMMAND_COLUMNS, HOLDS_FROM, REGIME, TOUCH
from tgvdp.methods.extremal.follow import follow_run
from tgvdp.methods.extremal.solve import Solver
from tgvdp.methods.extremal.switches import FROZEN, PINNED
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import COASTING
from tgvdp.runs.fastest import fastest_run

TGV, LGV, FLAT = tgvdp.load_train("tgv"), tgvdp.load_track("lgv-100km"), tgvdp.load_track("flat-100km")
EMU = tgvdp.load_train("alstom-emu")


def steep_trip():
    """Descents on which a regenerating train brakes by its motors, and limits at their ends."""
    track = tgvdp.Track(
        length_m=50e3,
        speed_limits=((0.0, 60.0), (12e3, 40.0), (16e3, 60.0), (38e3, 25.0), (44e3, 60.0)),
        gradients=((0.0, 0.0), (6e3, -25.0), (12e3, 15.0), (16e3, 0.0), (24e3, -30.0), (30e3, 20.0), (36e3, -20.0),
                   (44e3, 5.0)),
    )  # fmt: skip
    return Trip(train=EMU, track=track, origin_m=0.0, destination_m=50e3, energy=PANTOGRAPH)


def programs_run(trip, margin):
    """The program's run, its multiplier with auxiliaries, and its cost at that."""
    fastest = fastest_run(trip)
    found = optimal_front(trip, fastest, np.array([1.0, 1.0 + margin]) * fastest.duration_s, SearchBudget())
    solver = Solver(trip)
    price = float(found.multiplier_j_per_s[-1]) + solver.tables.auxiliary_w
    cost_j = float(found.energy_j[-1]) - solver.tables.auxiliary_w * float(found.duration_s[-1])
    return solver, *found.rows(1), price, cost_j + price * float(found.duration_s[-1])


def traction_alone():
    commands = np.zeros((400, COMMAND_COLUMNS))
    commands[:, -1] = -1.0
    return commands


@pytest.mark.parametrize("margin", [0.05, 0.12])
def test_commands_are_added_until_a_run_is_followed(margin):
    """Full traction to the end, mended where it leaves the band: it never runs away."""
    solver, x_m, w, price, cost_j = programs_run(steep_trip(), margin)
    solver.drive(traction_alone()[:1], price)
    commands = traction_alone()
    args = solver.train, solver.course, solver.levels, x_m, w, len(x_m), 0.04, solver.start_w, solver.work
    count, _ = follow_run(*args, commands, 1)
    followed = solver.drive(commands[:count], price)
    alone = solver.drive(traction_alone()[:1], price)
    assert followed.cost_j(price) < cost_j * 1.1
    assert alone.cost_j(price) > followed.cost_j(price) * 1.05
    solver.drive(commands[:count], price)
    rows, n = solver.run()
    there = (rows.x[:n] > 1e3) & (rows.x[:n] < 49e3)  # rows are coarse next to standstill
    apart = rows.w[:n][there] / np.interp(rows.x[:n][there], x_m, w).clip(9.0) - 1.0
    assert np.median(np.abs(apart)) < 0.04
    assert np.abs(apart).max() < 0.3


@pytest.mark.parametrize("margin", [0.05, 0.12])
def test_regeneration_on_steep_lines_descends_to_no_dearer_runs(margin):
    solver, x_m, w, price, cost_j = programs_run(steep_trip(), margin)
    found = solver.settle([solver.commands_of(x_m, w, price, short_s) for short_s in (1.5, 0.1)], price, math.inf)
    assert found.cost_j(price) <= cost_j * (1.0 + 1e-3)


def test_runs_that_end_at_speed_are_clean():
    """The last switch is bound by the end speed, which coasting or braking would fall below."""
    end_mps = 20.0
    track = tgvdp.Track(length_m=25e3, speed_limits=((0.0, 60.0),))
    result = tgvdp.search(TGV, track, points=8, max_margin=0.4, end_speed_mps=end_mps, clean=True)
    assert result.counters["clean"] == 7
    for index in range(8):
        assert result.profile(index).speed_mps[-1] == pytest.approx(end_mps, rel=1e-6)
    assert all(verdict.ok for verdict in result.verify())


def test_corners_are_tried_not_imposed():
    """On a long line a corner may be a kilometre from where traction begins: rest never costs more than the start."""
    limits = tuple((20e3 * k, 80.0 if k % 2 else 65.0) for k in range(15))
    track = tgvdp.Track(length_m=300e3, speed_limits=limits)
    solver = Solver(Trip(train=TGV, track=track, origin_m=0.0, destination_m=300e3))
    price = 3e6
    commands = traction_alone()[:15]
    corners_m = solver.course.corner_m[:7]
    commands[1::2, AT] = corners_m - 4e3
    commands[2::2, AT] = corners_m + 900.0
    commands[1::2, REGIME] = COASTING
    commands[:, HOLDS_FROM] = commands[:, AT]
    before = solver.drive(commands, price)
    for most_runs in (2, 3, 5, 9, 14):
        after = solver.rest(commands, price, most_runs)
        assert after.cost_j(price) <= before.cost_j(price) * (1.0 + 1e-10)


def test_a_frozen_switch_does_not_hold_up_the_others():
    """It stays where it is; the others meet the running time."""
    solver, x_m, w, price, _ = programs_run(Trip(train=TGV, track=LGV, origin_m=0.0, destination_m=100e3), 0.12)
    found = solver.settle([solver.commands_of(x_m, w, price)], price, math.inf)
    assert found.rests
    commands = found.commands.copy()
    switch = len(commands) // 2
    commands[switch, BOUND] = FROZEN
    commands[switch, AT] += 30.0
    commands[switch, HOLDS_FROM] = max(commands[switch, HOLDS_FROM], commands[switch, AT])
    target_s = found.time_s + 1.0
    met, _, _ = solver.meet(commands, price, target_s, target_s, 1e-3)
    assert met.time_s == pytest.approx(target_s, abs=1e-3)
    assert commands[switch, AT] in met.commands[:, AT]
    free, _, _ = solver.meet(found.commands, price, target_s, target_s, 1e-3)
    assert free.energy_j <= met.energy_j * (1.0 + 1e-9)


@pytest.mark.parametrize("margin", [0.03, 0.06])
def test_pinned_commands_know_where_they_touch(margin):
    """Taken up again at its own running time, an extremal stays as it is."""
    solver, x_m, w, price, _ = programs_run(steep_trip(), margin)
    found = solver.settle([solver.commands_of(x_m, w, price)], price, math.inf)
    pinned = found.commands[found.commands[:, BOUND] == PINNED]
    assert len(pinned) and (pinned[:, TOUCH] > pinned[:, AT]).all()
    runs = solver.runs
    again, _, _ = solver.meet(found.commands, price, found.time_s, found.time_s, 1e-3)
    assert solver.runs - runs <= 2
    assert again.energy_j == pytest.approx(found.energy_j, rel=1e-9)
