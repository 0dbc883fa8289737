"""Nodes of a map may lie anywhere, and the front does not hang on how many say the same."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.trips import HILLS
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.refine.extremals import Extremals
from tgvdp.methods.refine.mesh import mesh_for
from tgvdp.model.energy import EnergyMap
from tgvdp.physics.energy import energy_tables
from tgvdp.runs.fastest import fastest_run

EMU = tgvdp.load_train("alstom-emu")
GENTLE = replace(EMU, max_acceleration_mps2=0.3, max_deceleration_mps2=0.3)
TRACK = tgvdp.Track(length_m=3000.0, speed_limits=((0.0, 14.0),))


def map_of(demand, top_mps=60.0):
    """Losses rise steeply at little effort, so that partial effort is dear."""
    speeds = np.linspace(0.0, top_mps, 61)
    rows = []
    for v in speeds.tolist():
        limits_w = [v * (EMU.traction if d >= 0.0 else EMU.braking).effort_n(v) for d in demand]
        rows.append(tuple(p * (d + 0.3 * abs(d) ** 0.5) for p, d in zip(limits_w, demand, strict=True)))
    return EnergyMap(speed_mps=tuple(speeds.tolist()), demand=tuple(demand), power_w=tuple(rows))


@pytest.mark.parametrize("demand", [(-1.0, 1.0), (0.9, 1.0), (-1.0, -0.5)])
def test_all_nodes_may_lie_beyond_what_comfort_allows(demand):
    """There was nothing to take a hull of, and numpy's error came through."""
    result = tgvdp.search(GENTLE, TRACK, energy=map_of(demand), points=4)
    assert all(verdict.ok for verdict in result.verify())


@pytest.mark.parametrize("train", [EMU, GENTLE], ids=["strong", "comfort"])
def test_a_map_of_few_nodes_is_that_of_many_which_say_the_same(train):
    """The hull ended at the last node that comfort allows: at 10 % where 30 % were allowed, and the next node full."""
    few = map_of((-1.0, -0.1, 0.1, 1.0))
    demand = np.union1d(np.linspace(-1.0, 1.0, 101), few.demand)
    rows = tuple(tuple(np.interp(demand, few.demand, row).tolist()) for row in few.power_w)
    many = EnergyMap(speed_mps=few.speed_mps, demand=tuple(demand.tolist()), power_w=rows)
    wanted = {"at_margin": (0.1, 0.2)}
    by_few, by_many = (tgvdp.search(train, TRACK, energy=one, **wanted) for one in (few, many))
    late_j = by_many.price_kwh_per_min * 6e4 * (by_few.front.time_s - by_many.front.time_s)
    assert by_few.front.energy_j + late_j == pytest.approx(by_many.front.energy_j, rel=1e-3)


def test_runs_that_are_beaten_at_their_own_multiplier_are_no_bound():
    """Nothing was sought between two such runs, and a blend of them was taken: here 4 % too dear."""
    fastest = fastest_run(HILLS)

    def found(spoilt):
        front = Extremals(mesh_for(HILLS, fastest, 6.0), fastest, energy_tables(HILLS.train, HILLS.energy))
        front.asked(0.05, {"extremals": 0, "sweeps": 0, "blends": 0}, SearchBudget().start(), holds=True)
        front.reach(2.0 * fastest.duration_s)
        if spoilt:
            last = front.extremals[-1]
            before = front.extremals[1]._replace(multiplier=last.multiplier)
            front.extremals[:] = [front.extremals[0], before, last]
        return front.point(1.5 * fastest.duration_s).energy_j

    assert found(True) == pytest.approx(found(False), rel=1e-3)
