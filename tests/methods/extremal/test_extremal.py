"""Clean extremals: against closed forms, finite differences, the program that they start from, and the referee."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.twins.level import optimal_run
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.methods.extremal.command import AT, COMMAND_COLUMNS
from tgvdp.methods.extremal.solve import Solver
from tgvdp.methods.extremal.switches import ACTIVE, SLOPE
from tgvdp.model.energy import PANTOGRAPH, EnergyModel
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import COASTING, HOLDING
from tgvdp.runs.fastest import fastest_run

TGV, LGV, FLAT = tgvdp.load_train("tgv"), tgvdp.load_track("lgv-100km"), tgvdp.load_track("flat-100km")


def trip_of(train, track, energy="wheel"):
    model = EnergyModel("wheel") if energy == "wheel" else PANTOGRAPH
    return Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m, energy=model)


def hills():
    """Steep climbs and descents, and limits between them: chains of switches and touches of the envelope."""
    track = tgvdp.Track(
        length_m=40e3,
        speed_limits=((0.0, 70.0), (15e3, 45.0), (18e3, 70.0)),
        gradients=((0.0, 0.0), (6e3, 18.0), (9e3, -16.0), (13e3, 2.0), (24e3, -20.0), (27e3, 15.0), (30e3, 0.0)),
    )
    return Trip(train=TGV, track=track, origin_m=0.0, destination_m=40e3)


def coasts(price, *at_m):
    """Traction, then coasting and traction in turn."""
    commands = np.zeros((len(at_m) + 1, COMMAND_COLUMNS))
    commands[1::2, 0] = COASTING
    commands[1:, AT] = at_m
    commands[:, 2] = commands[:, AT]
    commands[-1, 2] = math.inf
    return commands


@pytest.mark.parametrize("price", [3e5, 1e6, 4e6])
def test_level_track_is_the_closed_form(price):
    solver = Solver(trip_of(TGV, FLAT))
    limit = FLAT.speed_limits[0].limit_mps if hasattr(FLAT.speed_limits[0], "limit_mps") else FLAT.speed_limits[0][1]
    expected = optimal_run(TGV, FLAT.length_m, limit, price)
    found = solver.rest(coasts(price, 85e3), price)
    assert found.rests
    assert found.time_s == pytest.approx(expected.duration_s, rel=2e-7)
    assert found.energy_j == pytest.approx(expected.energy_j, rel=5e-7)
    assert found.cost_j(price) == pytest.approx(expected.energy_j + price * expected.duration_s, rel=1e-7)


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_slopes_of_the_sweep_are_those_of_the_cost(energy):
    """The derivative of E + λT by each switch, by moving it."""
    solver = Solver(trip_of(TGV, LGV, energy))
    price = 6e6
    commands = coasts(price, 17.1e3, 17.9e3, 22.3e3, 30.4e3, 38.6e3, 57.2e3, 64.8e3)
    base = solver.drive(commands, price)
    found = solver.work.found[: len(commands)].copy()
    checked = 0
    for i in range(1, len(commands)):
        if found[i, ACTIVE] == 0.0:
            continue
        costs = []
        for step_m in (-0.5, 0.5):
            moved = commands.copy()
            moved[i, AT] += step_m
            moved[i, 2] = moved[i, AT] if math.isfinite(moved[i, 2]) else math.inf
            costs.append(solver.drive(moved, price).cost_j(price))
        assert (costs[1] - costs[0]) / solver.unit_j == pytest.approx(found[i, SLOPE], rel=2e-3, abs=2e-5)
        checked += 1
    assert checked >= 4
    assert base is not None


def test_coming_to_rest_never_raises_the_cost():
    solver = Solver(hills())
    rng = np.random.default_rng(1)
    rested = 0
    for _ in range(40):
        price = 10 ** rng.uniform(5.5, 7.0)
        commands = coasts(price, *np.sort(rng.uniform(1e3, 39e3, 2 * rng.integers(1, 5) - 1)))
        before = solver.drive(commands, price)
        if before is None:
            continue
        after = solver.rest(commands, price)
        assert after.cost_j(price) <= before.cost_j(price) * (1.0 + 1e-10)
        rested += after.rests
    assert rested >= 12


def test_the_best_of_two_is_no_dearer_than_either():
    solver = Solver(hills())
    rng = np.random.default_rng(2)
    better = 0
    for _ in range(30):
        price = 10 ** rng.uniform(5.5, 7.0)
        one, other = (solver.rest(coasts(price, *np.sort(rng.uniform(1e3, 39e3, 5))), price) for _ in range(2))
        if one is None or other is None:
            continue
        solver.drive(one.commands, price)
        rows = solver.run()
        solver.drive(other.commands, price)
        best = solver.best_of(one, rows, other, price)
        least = min(one.cost_j(price), other.cost_j(price))
        assert best.cost_j(price) <= least * (1.0 + 1e-9)
        better += best.cost_j(price) < least * (1.0 - 1e-6)
    assert better >= 3


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_points_are_extremals_no_dearer_than_the_programs_runs(energy):
    result = tgvdp.search(TGV, LGV, points=24, energy=energy, clean=True)
    target_s = result.fastest.time_s * np.linspace(1.0, 1.25, 24)
    program = optimal_front(result.trip, result.fastest.profile, target_s, SearchBudget())
    assert result.counters["clean"] >= 22
    assert result.front.time_s == pytest.approx(target_s, rel=1e-3)
    program_j = np.interp(result.front.time_s, program.duration_s, program.energy_j)
    assert (result.front.energy_j <= program_j * 1.00005).all()
    assert all(verdict.ok for verdict in result.verify())
    for index in range(2, 24):
        profile = result.profile(index)
        assert abs(profile.duration_s - target_s[index]) <= 3e-7 * target_s[index]


def test_points_have_few_phases():
    """Regimes are those that were commanded: no phases of rounding."""
    result = tgvdp.search(TGV, FLAT, points=12, clean=True)
    for index in range(1, 12):
        regime = result.profile(index).regime
        assert np.count_nonzero(np.diff(regime)) <= 4


def test_no_time_is_missed_on_level_track():
    train = tgvdp.Train(
        mass_kg=200e3, traction=tgvdp.EffortCurve.from_caps(200e3, 3e6), friction_brake_n=200e3, davis_a_n=3000.0,
        davis_b_n_per_mps=50.0, davis_c_n_per_mps2=6.0,
    )  # fmt: skip
    track = tgvdp.Track(length_m=20e3, speed_limits=((0.0, 40.0),))
    result = tgvdp.search(train, track, points=500, clean=True)
    assert len(result.front) == 500
    assert not result.warnings


def test_gradual_resistance_keeps_the_programs_runs():
    result = tgvdp.search(TGV, LGV, points=4, mass_model="strip", clean=True)
    assert result.counters["clean"] == 0
    assert all(verdict.ok for verdict in result.verify())


def test_holding_speeds_are_those_of_the_multiplier():
    trip = trip_of(TGV, FLAT)
    solver = Solver(trip)
    price = 1e6
    solver.rest(coasts(price, 85e3), price)
    whole, n = solver.run()
    v = math.sqrt(whole.w[:n][whole.regime[:n] == HOLDING][0])
    assert v * v * (TGV.davis_b_n_per_mps + 2.0 * TGV.davis_c_n_per_mps2 * v) == pytest.approx(price, rel=1e-9)
    assert fastest_run(trip).duration_s < whole.time[n - 1]


def test_a_front_takes_few_runs():
    """From point to point two or three runs, and some to find structures: not hundreds."""
    result = tgvdp.search(TGV, LGV, clean=True)
    assert result.counters["clean"] >= 57  # of 59
    assert result.counters["drives"] < 25 * 59


def test_hardly_a_phase_is_shorter_than_a_second():
    """Fewer than 0.3 on a point: those that stay cost more to leave out than they take to drive."""
    result = tgvdp.search(TGV, LGV, clean=True)
    short = 0
    for index in range(1, 60):
        profile = result.profile(index)
        cuts = np.flatnonzero(np.diff(profile.regime[:-1])) + 1
        at_s = profile.time_s[np.concatenate(([0], cuts, [len(profile.time_s) - 1]))]
        short += int((np.diff(at_s) < 1.0).sum())
    assert short < 0.3 * 59


def test_the_multiplier_moves_the_running_time_as_foreseen():
    """dT/dλ of the bordered step, against two extremals of multipliers nearby."""
    solver = Solver(trip_of(TGV, FLAT))
    price = 1e6
    found = solver.rest(coasts(price, 85e3), price)
    _, _, foreseen = solver.meet(found.commands, price, found.time_s, found.time_s + 0.5, 1e-3)
    other = solver.rest(found.commands, foreseen)
    assert other.time_s == pytest.approx(found.time_s + 0.5, abs=2e-3)
