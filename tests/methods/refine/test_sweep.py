"""Sweeps remember what arcs cost: a program that forgets finds the same runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.trips import commuter, trip_on
from tgvdp.line.cells import cells_of
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.refine.mesh import Level
from tgvdp.methods.refine.sweep import Scratch, descend
from tgvdp.model.energy import EnergyModel
from tgvdp.model.track import LOWERED, POWERED, NeutralSection
from tgvdp.physics.arc import arc
from tgvdp.physics.codes import OK
from tgvdp.physics.energy import arc_energy, energy_tables
from tgvdp.physics.forces import kernel_train, unpowered


def random_level(rng, cells):
    """A short trip with gradients, sometimes with limits of comfort, a neutral section, and speeds at its ends."""
    length_m = rng.uniform(200.0, 1500.0)
    limits = [(0.0, rng.uniform(10.0, 25.0)), (0.6 * length_m, rng.uniform(8.0, 25.0))]
    gradients = [(0.0, rng.uniform(-15.0, 15.0)), (0.3 * length_m, rng.uniform(-15.0, 15.0))]
    change = {"max_acceleration_mps2": 0.5, "max_deceleration_mps2": 0.6} if rng.random() < 0.5 else {}
    ends = {"start_speed_mps": 6.0, "end_speed_mps": 5.0} if rng.random() < 0.5 else {}
    trip = trip_on(limits, gradients, length_m, commuter(**change), **ends)
    if rng.random() < 0.5:
        neutral = (NeutralSection(0.4 * length_m, 0.1 * length_m, bool(rng.random() < 0.5)),)
        trip = replace(trip, track=replace(trip.track, neutral_sections=neutral))
    trip = replace(trip, energy=EnergyModel("map", tgvdp.load_energy_map("alstom-map")))
    stations_m = np.union1d(cells_of(trip).station_m, np.linspace(0.0, length_m, cells + 1))
    return Level(trip, kernel_train(trip.train), cells_of(trip, stations_m))


def cost_j(level, tables, multiplier, k, w0, w1):
    """E + λT of one arc, J; infinite where no train drives it."""
    cells = level.cells
    train = level.train if cells.supply[k] == POWERED else unpowered(level.train)
    status, seconds, work = arc(train, cells.length_m[k], cells.grade_n[k], cells.air[k], w0, w1)
    if status != OK:
        return math.inf
    drawn = 0.0 if cells.supply[k] == LOWERED else arc_energy(train, tables, cells.length_m[k], seconds, work, w0, w1)
    return multiplier * seconds + drawn


def forgetful_sweep(level, tables, multiplier, half, step, start_w, steps):
    """The best run among whole steps around one, each arc computed anew; its steps and its E + λT."""
    to_go = {int(steps[-1]): (0.0, None)}
    choices = []

    def speed(k, at):
        return min(max(start_w[k] + at * step, level.low[k]), level.fast[k])

    for k in range(len(steps) - 2, -1, -1):
        w = speed(k, steps[k])
        first = int(steps[k]) - math.ceil(min(half, (w - level.low[k]) / step))
        last = int(steps[k]) + math.ceil(min(half, (level.fast[k] - w) / step))
        here = {}
        for at in range(first, last + 1):
            costs = [
                (cost_j(level, tables, multiplier, k, speed(k, at), speed(k + 1, to)) + rest, to)
                for to, (rest, _) in to_go.items()
            ]
            here[at] = min(costs)
        choices.append(here)
        to_go = here
    found = [int(steps[0])]
    for here in reversed(choices):
        found.append(here[found[-1]][1])
    return found, choices[-1][int(steps[0])][0]


@pytest.mark.parametrize(("half", "sweeps"), [(2, 25), (24, 2)], ids=["usual", "widest"])
@pytest.mark.parametrize("cells", [1, 3, 9])
def test_sweeps_that_remember_find_what_others_find(half, sweeps, cells):
    """Also where the ring of costs is shorter than the line, and where stations have one speed only."""
    rng = np.random.default_rng([half, cells])
    for _ in range(4):
        level = random_level(rng, cells)
        tables = energy_tables(level.trip.train, level.trip.energy)
        multiplier, step = rng.uniform(2e5, 4e6), level.top_w * rng.uniform(0.005, 0.05)
        n = len(level.fast)
        w, start_w = level.fast.copy(), level.fast.copy()
        scratch = Scratch.of(n, 49, 5)
        _, cost, _ = descend(
            level.train, tables, level.cells, level.low, level.fast, multiplier, half, step, math.inf, sweeps, w,
            start_w, scratch,
        )  # fmt: skip
        steps, known, least = np.zeros(n, dtype=np.int64), math.inf, math.inf
        for _ in range(sweeps):
            steps, least = forgetful_sweep(level, tables, multiplier, half, step, start_w, steps)
            if known - least <= 1e-6 * abs(least):
                break
            known = least
        assert cost == pytest.approx(least, rel=1e-12)
        expected = np.clip(start_w + step * np.array(steps), level.low, level.fast)
        expected[0] = start_w[0]
        assert w == pytest.approx(expected, rel=1e-12)
        assert level.measured(tables, w)[1] < math.inf


def test_a_run_that_holds_its_time_is_cheaper_and_as_late():
    """A run of the time of a blend, which sweeps at any multiplier would leave."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        level = random_level(rng, 40)
        tables = energy_tables(level.trip.train, level.trip.energy)
        clock = SearchBudget().start()
        slow = level.fast.copy()
        level.descend(tables, 3e5, slow, 2, 0.01, 1e-6, clock)
        blended = level.blend(level.fast, slow, 0.5)
        time_s, energy_j = level.measured(tables, blended)
        held = blended.copy()
        sweeps, multiplier = level.hold(tables, 1e6, held, time_s, 0.01, 1e-7, clock)
        if np.isinf(energy_j):  # nothing around it is feasible
            assert (held == blended).all()
            continue
        held_s, held_j = level.measured(tables, held)
        assert sweeps > 0 and multiplier > 0.0
        assert held_s == pytest.approx(time_s, rel=1e-6)
        assert held_j <= energy_j * (1.0 + 1e-6)


def test_a_run_with_nothing_feasible_around_it_stays_as_it_is():
    """Which of its speeds are best is not known then, and must not be looked up."""
    level = random_level(np.random.default_rng(3), 40)
    tables = energy_tables(level.trip.train, level.trip.energy)
    w = level.fast.copy()
    w[1:-1:2] = level.low[1:-1:2]  # from the envelope to the slowest speed and back, cell by cell
    level._scratch.best[:] = 2**14
    given = w.copy()
    level.descend(tables, 1e6, w, 2, 1e-6, 1e-7, SearchBudget().start())
    assert (w == given).all()
    level.hold(tables, 1e6, w, 100.0, 1e-6, 1e-7, SearchBudget().start())
    assert (w == given).all()
