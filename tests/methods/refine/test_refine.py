"""The generic refinement: published optima at wheel and pantograph, the front method, maps, and trips of every kind."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.trips import EFFICIENT, EFFICIENT_HILLS, HILLS, references
from tests.helpers.twins.brute_force import least_costs
from tests.helpers.twins.running import arc as twin_arc
from tests.helpers.twins.running import mean_over_distance
from tests.helpers.twins.trips import random_trip
from tgvdp.line.cells import cells_of
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.methods.refine.front import refine_front
from tgvdp.model.energy import PANTOGRAPH, WHEEL, EnergyMap, EnergyModel
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of


def refined(trip, target_s, energy=WHEEL):
    trip = replace(trip, energy=energy)
    return refine_front(trip, fastest_run(trip), np.asarray(target_s, dtype=float), SearchBudget())


def map_of(speeds_mps, demand, power_w):
    """Energy model of a table."""
    return EnergyModel("map", EnergyMap(speed_mps=tuple(speeds_mps), demand=tuple(demand), power_w=tuple(power_w)))


def with_efficiencies(traction, regeneration):
    train = replace(EFFICIENT, traction_efficiency=traction, regeneration_efficiency=regeneration)
    return replace(EFFICIENT_HILLS, train=train)


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["A", "B"])
def test_meets_every_reference(shared, variant):
    """Energies of independent direct transcription, at the wheel (A) and with efficiencies and regeneration (B)."""
    count = 0
    for trip, seconds, joules in references(shared, variant):
        energy = WHEEL if variant == "A" else PANTOGRAPH
        found = refined(trip, seconds, energy)
        above_j = found.energy_j + found.multiplier_j_per_s * (found.duration_s - seconds) - joules
        place = f"{trip.track.length_m:g} m from {trip.origin_m:g} m: {above_j / joules}"
        assert (above_j <= 3e-4 * np.abs(joules)).all(), place
        assert (above_j >= -3e-4 * np.abs(joules)).all(), place
        count += len(seconds)
    assert count == 90


@pytest.mark.slow
def test_agrees_with_the_front_method(shared):
    """One acceleration per cell, and runs of the costate program, which the first ones started from."""
    for trip, seconds, _ in list(references(shared, "A"))[::5]:
        fastest = fastest_run(trip)
        target_s = np.linspace(seconds[0], seconds[-1], 12)
        front = optimal_front(trip, fastest, target_s, SearchBudget())
        found = refined(trip, target_s)
        gap_j = found.energy_j + found.multiplier_j_per_s * (found.duration_s - front.duration_s) - front.energy_j
        assert (np.abs(gap_j) <= 1e-3 * front.energy_j).all(), gap_j / front.energy_j
        assert np.median(gap_j / front.energy_j) <= 5e-4


def pantograph_by_twin(trip, x_m, w):
    """Energy of rows at the pantograph, straight from the definitions: η_t 0.85, η_r 0.75, constant effort in a row.

    The dynamic brake follows its limit where that passes the effort within a row, but changes by little.
    """
    total = 0.0
    cells = cells_of(trip, x_m)
    permil = cells.grade_n / (trip.train.mass_kg * 9.81) * 1000.0
    for length, slope, w0, w1 in zip(cells.length_m, permil, w[:-1], w[1:], strict=True):
        v0, v1 = math.sqrt(w0), math.sqrt(w1)
        work = twin_arc(trip.train, length, slope, v0, v1)[1]
        total += work / 0.85 if work > 0.0 else -0.75 * length * returned_n(trip.train.braking, -work / length, v0, v1)
    return total


def returned_n(braking, effort_n, v0, v1):
    dynamic_n = mean_over_distance(braking.effort_n, v0, v1)
    low_n, high_n = sorted((braking.effort_n(v0), braking.effort_n(v1)))
    if low_n < effort_n < high_n and high_n - low_n <= 0.05 * dynamic_n:
        return min(effort_n, dynamic_n)
    return mean_over_distance(functools.partial(least, effort_n, braking.effort_n), v0, v1)


def least(effort_n, limit, speed_mps):
    return min(effort_n, limit(speed_mps))


def test_pantograph_energy_is_what_it_says():
    fastest = fastest_run(EFFICIENT_HILLS)
    found = refined(EFFICIENT_HILLS, fastest.duration_s * np.array([1.0, 1.1, 1.2]), PANTOGRAPH)
    for index in range(3):
        twin = pantograph_by_twin(EFFICIENT_HILLS, *found.rows(index))
        assert found.energy_j[index] == pytest.approx(twin, rel=1e-5)
    assert (np.diff(found.energy_j) < 0.0).all()


def test_runs_replay_and_meet_their_times():
    fastest = fastest_run(HILLS)
    wanted = fastest.duration_s * np.linspace(1.0, 1.25, 20)
    found = refined(HILLS, wanted)
    assert found.complete
    assert not found.exhausted
    assert np.abs(found.duration_s - wanted).max() <= 0.03 * (wanted[1] - wanted[0]) * (1.0 + 1e-9)
    assert (np.diff(found.energy_j) < 0.0).all()
    assert found.multiplier_j_per_s[0] == math.inf
    assert (np.diff(found.multiplier_j_per_s[1:]) <= 1e-3 * found.multiplier_j_per_s[1:-1]).all()
    for index in range(20):
        profile = profile_of(HILLS, *found.rows(index))
        assert replay(HILLS, profile).ok, index
        assert profile.duration_s == pytest.approx(found.duration_s[index], rel=1e-9)
        assert profile.total_energy_j == pytest.approx(found.energy_j[index], rel=1e-9)


def test_efficiency_alone_scales_the_front():
    wanted = fastest_run(HILLS).duration_s * np.array([1.05, 1.15])
    plain, dear = refined(HILLS, wanted), refined(with_efficiencies(0.5, 0.0), wanted, PANTOGRAPH)
    shifted_j = dear.multiplier_j_per_s * (dear.duration_s - plain.duration_s)
    assert dear.energy_j + shifted_j == pytest.approx(2.0 * plain.energy_j, rel=1e-3)
    assert dear.multiplier_j_per_s == pytest.approx(2.0 * plain.multiplier_j_per_s, rel=0.05)


def test_regeneration_makes_it_cheaper_and_changes_the_driving():
    wanted = fastest_run(EFFICIENT_HILLS).duration_s * np.array([1.03, 1.1])
    without = refined(with_efficiencies(0.85, 0.0), wanted, PANTOGRAPH)
    regenerating = refined(EFFICIENT_HILLS, wanted, PANTOGRAPH)
    assert (regenerating.energy_j < 0.99 * without.energy_j).all()
    for index in range(2):  # the run made for it is better than the other run with its braking paid for
        twin = pantograph_by_twin(EFFICIENT_HILLS, *without.rows(index))
        assert regenerating.energy_j[index] <= twin * (1.0 + 1e-3)


def test_a_linear_map_gives_the_same_front():
    """Power = speed × effort over efficiency is bilinear between nodes on the breaks of the effort curves."""
    speeds = np.unique(np.concatenate(([0.0, 3.5e6 / 2.5e5, 3e6 / 1.5e5], np.linspace(0.0, 44.0, 45))))
    pull_w = np.array([v * EFFICIENT.traction.effort_n(v) for v in speeds]) / 0.85
    brake_w = np.array([v * EFFICIENT.braking.effort_n(v) for v in speeds]) * 0.75
    table = np.stack((-brake_w, np.zeros_like(speeds), pull_w), axis=1)
    wanted = fastest_run(EFFICIENT_HILLS).duration_s * np.array([1.03, 1.1, 1.2])
    linear = refined(EFFICIENT_HILLS, wanted, PANTOGRAPH)
    mapped = refined(EFFICIENT_HILLS, wanted, map_of(speeds, np.array([-1.0, 0.0, 1.0]), table))
    shifted_j = mapped.multiplier_j_per_s * (mapped.duration_s - linear.duration_s)
    assert mapped.energy_j + shifted_j == pytest.approx(linear.energy_j, rel=2e-4)


def test_a_map_with_idle_losses_punishes_partial_effort():
    """With constant losses whenever the motors pull, the cheapest runs pull for a shorter time, if they can.

    At a long running time the cheapest run at the wheel hardly ever pulls with less than full effort.
    """
    speeds, demand = np.linspace(0.0, 44.0, 45), np.array([-1.0, 0.0, 0.02, 1.0])
    full_w = np.array([v * EFFICIENT.traction.effort_n(v) for v in speeds])
    idle_w = np.full_like(speeds, 3e5)
    table = np.stack((0.0 * full_w, 0.0 * full_w, 0.02 * full_w + idle_w, full_w + idle_w), axis=1)
    wanted = fastest_run(EFFICIENT_HILLS).duration_s * np.array([1.05, 1.15])
    plain = refined(EFFICIENT_HILLS, wanted)
    lossy = refined(EFFICIENT_HILLS, wanted, map_of(speeds, demand, table))

    def pulling_s(found, index):
        profile = profile_of(EFFICIENT_HILLS, *found.rows(index))
        return float(np.diff(profile.time_s)[profile.force_n[:-1] > 1e3].sum())

    for index in range(2):
        assert replay(EFFICIENT_HILLS, profile_of(EFFICIENT_HILLS, *lossy.rows(index))).ok
        assert lossy.energy_j[index] > plain.energy_j[index]
        late_j = lossy.multiplier_j_per_s[index] * (lossy.duration_s - plain.duration_s)[index]
        assert lossy.energy_j[index] + late_j < (plain.energy_j[index] + 3e5 * pulling_s(plain, index)) * (1.0 + 2e-4)
        assert pulling_s(lossy, index) < pulling_s(plain, index) * (1.0 if index == 0 else 1.01)


def test_no_plain_grid_is_better():
    fastest = fastest_run(HILLS)
    found = refined(HILLS, fastest.duration_s * np.linspace(1.0, 1.6, 30))
    multipliers = fastest.total_energy_j / fastest.duration_s * np.exp([1.0, 0.0, -1.0])
    for multiplier, (seconds, joules) in zip(multipliers, least_costs(HILLS, fastest, multipliers), strict=True):
        assert float((found.energy_j + multiplier * found.duration_s).min()) <= (joules + multiplier * seconds) * 1.0005


def test_the_time_limit_ends_it():
    fastest = fastest_run(HILLS)
    wanted = fastest.duration_s * np.linspace(1.0, 1.25, 60)
    found = refine_front(HILLS, fastest, wanted, SearchBudget(time_limit_s=1e-6))
    assert not found.complete
    assert len(found.duration_s) == 1


#: Random trips: 10 g to 10 000 t, 1 m to 1000 km, comfort limits, moving ends, up to 40 limits and 30 gradients.
SEEDS = [3, 4, 5, 11, 16, 17, 28, 29, 42, 56, 58]


@pytest.mark.parametrize("seed", SEEDS)
def test_trips_of_every_kind(seed):
    """As good as the front method, and every run replays: once infinite, or 0.1 % too slow at the stop."""
    trip = random_trip(seed)
    fastest = fastest_run(trip)
    wanted = fastest.duration_s * np.linspace(1.0, 1.25, 9)
    found = refined(trip, wanted)
    front = optimal_front(trip, fastest, wanted, SearchBudget())
    assert len(found.duration_s) == len(front.duration_s)
    multipliers = np.where(np.isfinite(found.multiplier_j_per_s), found.multiplier_j_per_s, 0.0)
    gap_j = found.energy_j - front.energy_j + multipliers * (found.duration_s - front.duration_s)
    kinetic_j = 0.5 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
    assert (gap_j <= 5e-3 * (front.energy_j[0] + 0.02 * kinetic_j)).all()
    for index in range(len(found.duration_s)):
        assert replay(trip, profile_of(trip, *found.rows(index))).ok, index
