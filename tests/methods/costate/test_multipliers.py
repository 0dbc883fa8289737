"""Extremals of one mesh where running times jump: a train that has three runs alone stands for one."""

import math
from types import SimpleNamespace

import numpy as np

from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.multipliers import ExtremalFront

#: Time, s, and energy, J, of its runs, and the least multiplier, J/s, for which each is the best one on its mesh: not
#: just where the slopes between them, 90 and 40 J/s, say.
RUNS = ((100.0, 5000.0, 130.0), (110.0, 4100.0, 25.0), (130.0, 3300.0, 0.0))
EMPTY = np.empty(0)


def mesh_of_three_runs(asked):
    def extremal(multiplier, counters):
        asked.append(multiplier)
        if math.isinf(multiplier):
            return Extremal(multiplier, EMPTY, 99.0, 6000.0, EMPTY)
        time_s, energy_j = next(run[:2] for run in RUNS if multiplier >= run[2])
        return Extremal(multiplier, EMPTY, time_s, energy_j, EMPTY)

    return SimpleNamespace(
        extremal=extremal,
        extremals=lambda multipliers, counters: [extremal(one, counters) for one in multipliers],
        usual_multiplier=60.0,
        least_energy_j=600.0,
        cells=SimpleNamespace(length_m=np.ones(10)),
    )


def test_a_run_between_two_jumps_is_asked_for_a_few_times():
    """It is known by the multipliers next to either jump; with one alone, moved by turns, that went on for ever."""
    asked = []
    front = ExtremalFront(mesh_of_three_runs(asked), 0.1, 0.0, {}, SearchBudget(time_limit_s=5.0).start())
    assert front.reach(129.0)
    front.foresee(np.linspace(101.0, 129.0, 15))
    assert len(asked) < 30
    known = {run[0]: [one.multiplier for one in front.extremals if one.time_s == run[0]] for run in RUNS}
    assert len(front.extremals) == 1 + sum(map(len, known.values()))
    assert max(map(len, known.values())) == 2
    assert 90.0 < max(known[110.0]) <= 130.0 and 25.0 <= min(known[110.0]) < 40.0
