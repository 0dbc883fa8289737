"""Kernels end on whatever rows they are given: a loop in compiled code can be stopped by nobody."""

import numpy as np
import pytest

from tests.helpers.trips import trip_on
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.leave import leave
from tgvdp.methods.phases.plan import AT, PLAN_COLUMNS, REGIME, plan_of
from tgvdp.methods.phases.prune import prune
from tgvdp.methods.phases.regimes import tell_regimes
from tgvdp.methods.phases.track import track
from tgvdp.methods.phases.way import Room, Run, is_sound, way_of
from tgvdp.methods.phases.widen import widen
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import BRAKING, COASTING, HOLDING, TRACTION
from tgvdp.runs.batch import Batch
from tgvdp.runs.fastest import fastest_run

PRICE = 1e5
ANY = Room(np.inf, -np.inf, np.inf, 0.0, 0.0)


def doubled(x_m, w):
    """Each row is followed by one of no length."""
    return np.repeat(x_m, 2), np.repeat(w, 2)


def slivers(x_m, w):
    """Each row is followed by one that is shorter than what counts as the same position."""
    return np.sort(np.concatenate((x_m, x_m[1:-1] + 5e-10))), np.concatenate((w[:1], np.repeat(w[1:-1], 2), w[-1:]))


def short_of_the_end(x_m, w):
    """The last row ends before the line does."""
    return np.concatenate((x_m[:-1], [x_m[-1] - 1e-7])), w


def in_one_place(x_m, w):
    """No row has a length."""
    return np.full(len(x_m), x_m[len(x_m) // 2]), w


ROWS = (doubled, slivers, short_of_the_end, in_one_place)


@pytest.fixture(scope="module")
def fast():
    trip = trip_on([(0.0, 30.0), (4000.0, 20.0), (7000.0, 30.0)])
    mesh = Mesh.of(trip, fastest_run(trip))
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    return way, mesh.envelope.x_m, mesh.envelope.w


def room(size):
    run = Run.of(np.empty((5, size)))
    for column in run:
        column[:] = 0
    return run


def run_of(x_m, w, size=0):
    run = room(max(size, len(x_m)))
    run.x[: len(x_m)], run.w[: len(x_m)] = x_m, w
    return run


def planned(way, run, n):
    tell_regimes(way, run, 0, 0, n - 1)
    plan = np.empty((4000, PLAN_COLUMNS))
    return plan, plan_of(way, run, n, plan)


@pytest.mark.parametrize("regime", [TRACTION, HOLDING, COASTING, BRAKING])
@pytest.mark.parametrize("spoil", ROWS)
def test_tracking_ends_whatever_the_rows_and_the_plan(fast, spoil, regime):
    way, *rows = fast
    x_m, w = spoil(*rows)
    run, n = run_of(x_m, w), len(x_m)
    plan, count = planned(way, run, n)
    plan[:count, REGIME] = regime
    for most_j in (np.inf, -np.inf):
        out = room(n + 20_000)
        m, refused, _ = track(way, run, n, plan, count, PRICE, 0.0, Room(most_j, -np.inf, np.inf, 0.0, 0.0), out)
        assert -1 <= m <= len(out.x) and refused <= n
        if most_j < 0.0 and m > 0:  # all that differs is refused: the run stays as it is
            np.testing.assert_array_equal(out.x[:m], x_m)
            np.testing.assert_array_equal(out.w[:m], w)


@pytest.mark.parametrize("spoil", ROWS)
def test_a_plan_of_phases_of_no_length_ends(fast, spoil):
    way, *rows = fast
    x_m, w = spoil(*rows)
    run, n, out = run_of(x_m, w), len(x_m), room(len(x_m) + 20_000)
    plan, count = planned(way, run, n)
    plan[1:count, AT] = x_m[n // 3]
    plan[:count, REGIME] = np.resize((TRACTION, COASTING, HOLDING, BRAKING), count)
    m, refused, _ = track(way, run, n, plan, count, PRICE, 0.0, ANY, out)
    assert -1 <= m <= len(out.x) and refused <= n
    m, _ = widen(way, run, n, plan, count, PRICE, 1.0, ANY, out)
    assert -1 <= m <= len(out.x)


@pytest.mark.parametrize("spoil", ROWS)
@pytest.mark.parametrize("regime", [TRACTION, HOLDING, COASTING, BRAKING])
def test_leaving_ends_where_the_envelope_does_not_advance(fast, spoil, regime):
    way, x_m, w = fast
    way = way._replace(envelope=Rows(*spoil(x_m, w)))
    n, start = len(x_m), len(x_m) // 4
    run, out = run_of(x_m, w), room(n + 20_000)
    plan, _ = planned(way, run, n)
    plan[0, REGIME], plan[0, AT] = regime, 0.0
    out.x[0], out.w[0] = x_m[start], 0.9 * w[start]
    m, i = leave(way, run, n, start, plan, 1, 0, out, 1)
    assert -1 <= m <= len(out.x) and start <= i < n


def test_leaving_ends_where_there_is_no_room(fast):
    way, x_m, w = fast
    run, out, n = run_of(x_m, w), room(100), len(x_m)
    plan, _ = planned(way, run, n)
    plan[0, REGIME] = COASTING
    out.x[0], out.w[0] = x_m[n // 4], w[n // 4]
    assert leave(way, run, n, n // 4, plan, 1, 0, out, 1)[0] == -1
    assert track(way, run, n, plan, 1, PRICE, 0.0, ANY, room(10))[0] == -1


@pytest.mark.parametrize("least_s", [0.01, 1.0, 1e9, np.inf])
@pytest.mark.parametrize("spoil", ROWS[:3])
def test_pruning_ends_at_the_running_time(fast, spoil, least_s):
    way, *rows = fast
    x_m, w = spoil(*rows)
    pruned = prune(way, Batch.of([(x_m, w)]), np.array([PRICE]), least_s, np.array([1e3]), np.zeros(1), 0.1)
    assert abs(pruned.time_s[0]) <= 0.1
    assert pruned.energy_j[0] + PRICE * pruned.time_s[0] <= 1e3


def test_runs_that_the_referee_would_refuse_are_known(fast):
    """What is no run of the line stays unpruned, whatever went wrong on the way there."""
    way, x_m, w = fast
    x_m, w = x_m.copy(), w.copy()
    none = Rows(np.array([-2.0, -1.0]), np.zeros(2))

    def passes(x_m, w, given=none):
        return is_sound(way, run_of(x_m, w), len(x_m), given, 0, len(given.x) - 1)

    assert passes(x_m, w)
    assert not passes(*doubled(x_m, w))
    station = int(np.searchsorted(x_m, way.cells.station_m[1]))
    without = np.delete(x_m, station), np.delete(w, station)
    assert not passes(*without)  # a row passes a place where the line may change
    assert not passes(*without, Rows(x_m, w))
    faster = w.copy()
    faster[station] *= 1.01
    assert not passes(x_m, faster)  # that takes more than the train gives
    assert not passes(x_m, faster, Rows(x_m, w))
    assert passes(x_m, faster, Rows(x_m, faster))  # but is as it was given
