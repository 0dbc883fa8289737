"""Runs that take given times: the same on one core and on two, and whatever room there is for their rows."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fronts import front_to
from tests.helpers.trips import trip_on
from tgvdp import cores
from tgvdp.methods.costate import meet, mesh
from tgvdp.methods.costate.meet import _groups
from tgvdp.model.energy import EnergyModel

ENERGIES = ("wheel", "pantograph")
HILLS = trip_on([(0, 35), (6000, 22)], [(0, 0), (2000, 12), (4000, -9), (8000, 3)])


def front(energy):
    trip = replace(HILLS, energy=EnergyModel(energy))
    return front_to(trip, 0.25, 30)[1]


def assert_same(one, other):
    assert np.array_equal(one.duration_s, other.duration_s)
    assert np.array_equal(one.energy_j, other.energy_j)
    for index in range(len(one.duration_s)):
        for column, same in zip(one.rows(index), other.rows(index), strict=True):
            assert np.array_equal(column, same)


@pytest.mark.parametrize("energy", ENERGIES)
def test_two_cores_find_what_one_finds(energy, monkeypatch):
    monkeypatch.setattr(cores, "usable_cores", lambda: 2)
    with cores.on_one_core():
        alone = front(energy)
    for room in (meet, mesh):
        monkeypatch.setattr(room, "_LEAST_CELLS", 1)
    assert_same(front(energy), alone)


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("rows_per_cell", [0.01, 0.3])
def test_room_for_few_rows_changes_nothing(energy, rows_per_cell, monkeypatch):
    expected = front(energy)
    monkeypatch.setattr(meet, "_ROWS_PER_CELL", rows_per_cell)
    assert_same(front(energy), expected)


def test_groups_keep_together_what_is_between_the_same_extremals():
    second = np.array([1, 1, 1, 1, 1, 2, 3, 3, 4])
    for count in range(1, 6):
        groups = list(_groups(second, count))
        assert [i for group in groups for i in range(len(second))[group]] == list(range(len(second)))
        assert len(groups) <= count
        for group in groups[:-1]:
            assert second[group.stop] != second[group.stop - 1]
