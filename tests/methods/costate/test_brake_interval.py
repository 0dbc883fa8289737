"""Dynamic brakes that work in an interval of lower speeds, too: they begin at a speed, or rise with it.

Runs coast down to the interval, brake through it, and coast on. With one speed from which on they brake they were up to
12 % dearer than by value iteration, which shares nothing with the engine.
"""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.brake_case import HILLY, LEVEL, metro
from tests.helpers.value_iteration import least_cost_j
from tgvdp import Gradient
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.energy import EnergyModel
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run


def _of_power(from_mps):
    """A brake that begins at a speed, and is of limited power from there on."""
    curve = tuple((v_mps, from_mps * 150e3 / v_mps) for v_mps in np.linspace(from_mps, 22.0, 12).tolist())
    return ((0.0, 0.0), (from_mps, 0.0), *curve)


def _ramp(from_mps, to_mps):
    """A brake that rises from nothing over a few metres per second."""
    return ((0.0, 0.0), (from_mps, 0.0), (to_mps, 150e3), (14.0, 150e3), (22.0, 95e3))


def _flat(from_mps):
    """A brake that begins at a speed with all of its effort."""
    return ((0.0, 0.0), (from_mps, 0.0), (from_mps, 150e3), (22.0, 150e3))


DOWN = replace(LEVEL, gradients=(Gradient(0.0, 0.0), Gradient(1000.0, -10.0)))
UP = replace(LEVEL, gradients=(Gradient(0.0, 0.0), Gradient(1000.0, 10.0)))
#: A brake of which there is little at low speeds, and one that is a saw-tooth.
LITTLE = ((0.0, 2e3), (9.0, 2e3), (9.0, 150e3), (22.0, 150e3))
SAW = ((0.0, 0.0), (5.0, 0.0), (5.0, 60e3), (9.0, 40e3), (9.0, 90e3), (14.0, 60e3), (14.0, 120e3), (22.0, 80e3))


def _mesh(points, track):
    trip = Trip(
        train=metro(points), track=track, origin_m=0.0, destination_m=track.length_m, energy=EnergyModel("pantograph")
    )
    return Mesh.of(trip, fastest_run(trip))


def _extremal(mesh, multiplier):
    return mesh.extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0})


@pytest.mark.parametrize(
    ("points", "track", "share"),
    [
        (_of_power(8.5), LEVEL, 0.15),
        (_of_power(10.0), HILLY, 0.2),
        (_of_power(12.0), LEVEL, 0.5),
        (_ramp(6.0, 10.0), LEVEL, 0.15),
        (_ramp(9.5, 10.5), LEVEL, 0.7),
        (_ramp(9.5, 10.5), HILLY, 0.3),
        (LITTLE, LEVEL, 0.2),
        (SAW, LEVEL, 0.3),
    ],
)
def test_extremals_cost_what_value_iteration_says(points, track, share):
    mesh = _mesh(points, track)
    multiplier = share * mesh.usual_multiplier
    cost_j = _extremal(mesh, multiplier).cost_j(multiplier)
    assert cost_j == pytest.approx(least_cost_j(metro(points), track, multiplier, 10.0, 0.2), rel=4e-3)


@pytest.mark.parametrize(
    ("points", "track"),
    [
        (_of_power(8.5), LEVEL),
        (_ramp(6.0, 10.0), LEVEL),
        (_ramp(9.5, 10.5), LEVEL),
        (LITTLE, LEVEL),
        (SAW, LEVEL),
        (_of_power(7.0), DOWN),  # runs come to 7 m/s from both sides
        (_of_power(7.0), UP),  # all is braked from 7 m/s on, at some places
        (_flat(12.0), DOWN),
        (_flat(12.0), UP),
    ],
)
def test_and_as_much_on_finer_meshes(points, track):
    mesh = _mesh(points, track)
    for share in (0.7, 0.3, 0.15, 0.06):
        multiplier = share * mesh.usual_multiplier
        meshes = (mesh, mesh.finer.finer, mesh.finer.finer.finer)
        costs_j = [_extremal(one, multiplier).cost_j(multiplier) for one in meshes]
        drawn_j = mesh.usual_multiplier * 200.0
        assert costs_j[0] == pytest.approx(costs_j[-1], abs=5e-4 * drawn_j)
        assert costs_j[1] == pytest.approx(costs_j[-1], abs=5e-5 * drawn_j)


@pytest.mark.parametrize(
    ("points", "track", "energy_kwh", "cells"),
    [
        (_of_power(10.0), LEVEL, (8.39, 7.535), 1000),
        (_of_power(10.0), HILLY, (5.11, 3.715), 400),
        (_ramp(9.5, 10.5), LEVEL, (8.22, 7.435), 400),
    ],
    ids=["power-level", "power-hilly", "ramp"],
)
def test_fronts_of_such_trains(points, track, energy_kwh, cells):
    result = tgvdp.search(metro(points), track, at_margin=(0.15, 0.25), energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    assert np.all(result.front.energy_j <= np.array(energy_kwh) * 3.6e6)
    assert result.counters["cells"] < cells
