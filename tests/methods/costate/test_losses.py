"""What cells lose, against the same told by whole arrays, and what the shares of it add up to."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.fronts import counters
from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.costate.losses import losses_of
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run

HILLS = trip_on([(0, 22), (2500, 15)], [(0, 0), (900, 12), (1800, -14), (3000, 3)], length_m=6000.0, train=commuter())


def extremals_on(mesh, levels):
    return mesh.extremals([level * mesh.usual_multiplier for level in levels], counters())


def told_by_arrays(mesh, asked, finer):
    """Losses, (m, K), those as shares of what may be foretold, (m,), and what halves save, J, (m,)."""
    passed, halves = np.array([one.passed for one in asked]), np.array([one.passed[::2] for one in finer])
    multipliers = np.array([[one.multiplier] for one in asked])
    apart_w, apart_s, apart_j = np.moveaxis(passed - halves, 2, 0)
    stiff = apart_w**2 / np.maximum(np.maximum(passed[..., 0], halves[..., 0]), mesh.floor_w) ** 2.5
    bends = mesh.cells.length_m * (stiff[:, :-1] + stiff[:, 1:])
    saved_j = apart_j + multipliers * apart_s - 0.5 * mesh.train.inertia_kg * mesh.tables.traction * apart_w
    all_j = saved_j[:, -1:]
    local_j = np.maximum(np.copysign(1.0, all_j) * np.diff(saved_j), 0.0)
    shares = np.maximum(*(one / np.maximum(one.sum(axis=1, keepdims=True), 1e-300) for one in (bends, local_j)))
    loss = 4.0 / 3.0 * np.abs(all_j) / np.maximum(passed[:, -1, 2:], mesh.least_drawn_j)
    unknown = loss * np.where(all_j < 0.0, 3.0, 1.0) / 4e-4
    long = (unknown > 1.0) & (unknown * shares * shares.shape[1] > 1.0)
    lost = loss * shares / np.maximum(shares.sum(axis=1, keepdims=True), 1e-300)
    return lost, unknown[:, 0] > 1.0, long, all_j[:, 0]


@pytest.mark.parametrize("fineness", [0.03, 0.125, 1.0])
def test_losses_are_those_of_whole_arrays(fineness):
    mesh = Mesh.of(HILLS, fastest_run(HILLS), fineness)
    levels = (4.0, 1.5, 1.0, 0.5, 0.2)
    asked, finer = extremals_on(mesh, levels), extremals_on(mesh.finer, levels)
    found = losses_of(mesh, asked, finer)
    lost, unknown, long, all_j = told_by_arrays(mesh, asked, finer)
    assert found.lost == pytest.approx(lost, rel=1e-9, abs=1e-15)
    assert (found.unknown == (unknown | long.any(axis=1))).all()
    assert (found.long == long.any(axis=0)).all()
    cost_j = np.array([one.cost_j(one.multiplier) for one in asked])
    assert found.least_j == pytest.approx(cost_j - np.maximum(all_j, 0.0), rel=1e-12)
    assert all(one is other for one, other in zip(found.finer, finer, strict=True))


def test_runs_that_are_the_same_lose_nothing():
    mesh = Mesh.of(HILLS, fastest_run(HILLS), 0.125)
    asked = extremals_on(mesh, (2.0, 0.5))
    finer = [SimpleNamespace(passed=one.passed.repeat(2, axis=0)[:-1]) for one in asked]
    found = losses_of(mesh, asked, finer)
    assert not found.lost.any()
    assert not found.unknown.any()
    assert not found.long.any()


def test_runs_of_which_much_is_lost_do_not_foretell_what_shorter_cells_lose():
    mesh = Mesh.of(HILLS, fastest_run(HILLS), 0.125)
    (asked,) = extremals_on(mesh, (1.0,))
    half = asked.passed.repeat(2, axis=0)[:-1].copy()
    half[20:, 2] -= 1e-3 * asked.energy_j  # all of it in the cell that ends at station 10
    found = losses_of(mesh, [asked], [SimpleNamespace(passed=half)])
    assert found.unknown.all()
    assert np.flatnonzero(found.long).tolist() == [9]
    assert found.lost.sum() == pytest.approx(4.0 / 3.0 * 1e-3, rel=1e-9)
