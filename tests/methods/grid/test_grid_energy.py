"""Searches on a grid where energy is counted at the pantograph or by a map: arcs may return more than they draw."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.energy_case import TRACK, TRAIN, perfect_map
from tests.helpers.grid_case import all_paths, front_of
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.best_first import best_first
from tgvdp.methods.grid.exact import exact_front
from tgvdp.methods.grid.grid import build_grid
from tgvdp.model.energy import PANTOGRAPH, WHEEL, EnergyModel
from tgvdp.model.track import Track
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

BUDGET = SearchBudget(time_limit_s=30.0)
MODELS = {"wheel": WHEEL, "pantograph": PANTOGRAPH, "map": EnergyModel("map", perfect_map(TRAIN, 0.1))}


def random_case(seed, energy):
    """A short hilly trip whose descents return energy, on a grid that can be enumerated."""
    rng = np.random.default_rng(seed)
    train = replace(TRAIN, auxiliary_power_w=float(rng.choice([0.0, 3e5])))
    length_m = rng.uniform(1500.0, 4000.0)
    gradients = [(0.0, rng.uniform(-30.0, 20.0)), (0.4 * length_m, rng.uniform(-40.0, 20.0))]
    track = Track(length_m=length_m, speed_limits=((0.0, rng.uniform(15.0, 33.0)),), gradients=tuple(gradients))
    if rng.random() < 0.3:
        track = replace(track, neutral_sections=((0.6 * length_m, 60.0, bool(rng.random() < 0.5)),))
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=length_m, energy=energy)
    return trip, build_grid(trip, segment_m=0.6 * length_m, speeds=int(rng.integers(2, 4)))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", range(8))
def test_the_front_is_that_of_all_paths(seed, model):
    """Every path of the grid, driven and charged row by row by `profile_of`, which knows no graph."""
    trip, grid = random_case(seed, MODELS[model])
    charged = []
    for _, _, nodes in all_paths(grid.graph):
        profile = profile_of(trip, *grid.rows(grid.level[list(nodes)]))
        charged.append((profile.duration_s, profile.total_energy_j))
    limit_s = 1.6183 * min(seconds for seconds, _ in charged)
    expected = np.array(front_of(point for point in charged if point[0] <= limit_s))
    scale_j = 0.5 * trip.train.inertia_kg * float(grid.level_mps[-1]) ** 2
    for found in (exact_front(grid, limit_s, BUDGET), best_first(grid, limit_s, BUDGET, paths=0)):
        # Paths whose costs agree but for rounding may be one point or two.
        for seconds, joules in expected:
            near = found.duration_s <= seconds * (1.0 + 1e-9)
            assert found.energy_j[near].min() <= joules + 1e-9 * scale_j
        for index in range(len(found)):
            near = expected[:, 0] <= found.duration_s[index] * (1.0 + 1e-9)
            assert found.energy_j[index] >= expected[near, 1].min() - 1e-9 * scale_j
            assert found.node(index).energy_j == pytest.approx(found.energy_j[index], abs=1e-9 * scale_j)
    if model == "wheel":
        assert (grid.floor_j == 0.0).all()


def test_some_grids_return_more_than_they_draw():
    assert min(random_case(seed, PANTOGRAPH)[1].floor_j.min() for seed in range(8)) < -1e6


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("method", ["exact", "best-first"])
def test_no_grid_is_cheaper_than_the_front(method, model):
    energy = perfect_map(TRAIN, 0.1) if model == "map" else model
    grid = {"segment_m": 400.0, "speeds": 16} | ({"paths": 400} if method == "best-first" else {})
    found = tgvdp.search(TRAIN, TRACK, method=method, energy=energy, **grid)
    front = tgvdp.search(TRAIN, TRACK, energy=energy, points=40)
    assert all(verdict.ok for verdict in found.verify())
    multipliers = (front.front.energy_j[0] / front.fastest.time_s) * np.exp([1.0, 0.0, -1.0, -2.0])
    for multiplier in multipliers:  # the grid is coarse, and best-first finds different paths rather than all good ones
        least_j = float((front.front.energy_j + multiplier * front.front.time_s).min())
        grid_j = float((found.front.energy_j + multiplier * found.front.time_s).min())
        assert least_j * (1.0 - 1e-3) <= grid_j <= least_j * 1.3


def test_downhill_runs_may_earn_energy():
    track = Track(length_m=4000.0, speed_limits=((0.0, 25.0),), gradients=((0.0, -25.0),))
    train = replace(TRAIN, auxiliary_power_w=0.0)
    for method in ("exact", "best-first"):
        found = tgvdp.search(train, track, method=method, energy="pantograph", segment_m=500.0, speeds=10)
        assert (found.front.energy_j < 0.0).all()
        assert (np.diff(found.front.energy_j) < 0.0).all()
        assert all(verdict.ok for verdict in found.verify())
        trip = found.trip
        assert replay(trip, fastest_run(trip)).ok
