"""Stations of a mesh: breaks, switch points, and cells that are shorter next to the ends of the line."""

import numpy as np
import pytest

from tests.helpers.trips import HILLS, trip_on
from tgvdp.line.cells import breaks_of, cells_between, cells_of, cut, halved
from tgvdp.methods.costate.stations import fill_stations, graded_stations, switch_points
from tgvdp.runs.fastest import fastest_run

pytestmark = pytest.mark.nojit


def slow_stations(break_m, soft_m, cell_m):
    """A slow twin: stations by the inverse of the count of cells, C = ∫ dx / size(x), which is summed up."""
    distance_m = break_m[-1]
    gap_m = 1e-7 * distance_m
    soft = [
        x
        for i, x in enumerate(soft_m)
        if np.abs(break_m - x).min() > gap_m and (i == 0 or soft_m[i] - soft_m[i - 1] > gap_m)
    ]
    fixed_m = np.sort([*break_m, *soft])
    x = np.unique(np.concatenate((np.linspace(0.0, distance_m, 2_000_001), fixed_m)))
    middle_m = 0.5 * (x[1:] + x[:-1])
    size_m = np.minimum(0.1 * cell_m + 0.2 * np.minimum(middle_m, distance_m - middle_m), cell_m)
    count = np.concatenate(([0.0], np.cumsum(np.diff(x) / size_m)))
    station_m = [0.0]
    for end_m in fixed_m[1:]:
        first, last = np.interp([station_m[-1], end_m], x, count)
        parts = max(int(np.ceil(last - first - 1e-6)), 1)
        station_m += np.interp(first + (last - first) * np.arange(1, parts) / parts, count, x).tolist()
        station_m.append(end_m)
    return np.array(station_m)


@pytest.mark.parametrize("cell_m", [3e4, 4000.0, 700.0, 90.0])
def test_stations_are_those_of_a_slow_twin(cell_m):
    break_m = np.array([0.0, 300.0, 301.0, 4000.0, 9999.0, 10_000.0])
    soft_m = np.array([1e-5, 299.0, 2000.0, 2000.0005, 2100.0, 4000.0, 9500.0])
    station_m = np.empty(1000)
    count = fill_stations(break_m, soft_m, cell_m, station_m)
    twin_m = slow_stations(break_m, soft_m, cell_m)
    assert count == len(twin_m)
    np.testing.assert_allclose(station_m[:count], twin_m, atol=0.02)


@pytest.mark.parametrize("share", [3.0, 0.4, 0.01])
def test_breaks_and_switch_points_are_stations(share):
    profile = fastest_run(HILLS)
    cell_m = share * HILLS.distance_m
    station_m = graded_stations(HILLS, profile, cell_m)
    assert (np.diff(station_m) > 0.0).all() and np.diff(station_m).max() <= cell_m * (1.0 + 1e-9)
    assert np.isin(breaks_of(HILLS), station_m).all()
    assert np.isin(switch_points(profile), station_m).all()
    for ours, theirs in zip(cells_between(HILLS, station_m), cells_of(HILLS, station_m), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_there_is_room_for_stations_of_a_line_with_breaks_everywhere():
    trip = trip_on([(7.0 * i, 20 + i % 3) for i in range(150)], length_m=1050.0)
    station_m = graded_stations(trip, fastest_run(trip), 0.5)
    assert np.diff(station_m).max() <= 0.5 * (1.0 + 1e-9)


def test_halved_cells_are_cut_in_two():
    cells = cells_of(HILLS)
    for ours, theirs in zip(halved(cells), cut(cells, np.full(len(cells.length_m), 2)), strict=True):
        np.testing.assert_array_equal(ours, theirs)
