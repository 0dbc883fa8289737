"""Extremals of one mesh where running times jump, for which a train of three runs alone stands; and when time is up."""

import math
from types import SimpleNamespace

import numpy as np

from tests.helpers.trips import trip_on
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.multipliers import ExtremalFront, OutOfTime
from tgvdp.runs.fastest import fastest_run

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
        extremals=lambda multipliers, counters, least_w: [extremal(one, counters) for one in multipliers],
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


def test_runs_of_a_round_are_kept_where_the_time_is_up_behind_it(monkeypatch):
    """They were thrown away where an extremal was still to be solved elsewhere: 49 of 50."""
    trip = trip_on([(0, 22.2), (3000, 16.7)], [(0, 3), (2000, -16), (2265, 3)], length_m=5000.0)
    fastest = fastest_run(trip)
    counters = dict.fromkeys(("cells", "extremals", "runs", "costates"), 0)
    front = ExtremalFront(Mesh.of(trip, fastest, 0.125), 1e-3, 0.0, counters, SearchBudget().start())
    target_s = fastest.duration_s * np.linspace(1.01, 1.2, 20)
    front.reach(float(target_s[-1]))
    monkeypatch.setattr(ExtremalFront, "foresee", lambda self, target_s: None)

    def ends(self, seconds, closed):
        assert seconds
        raise OutOfTime

    monkeypatch.setattr(ExtremalFront, "_split", ends)
    found, complete = front.points(target_s)
    assert not complete and found.rows.size > 0
    np.testing.assert_allclose(found.outcome[:, 0], target_s[: found.rows.size], atol=1e-3)
