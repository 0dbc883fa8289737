"""A run without phases that are too short to drive, at the same running time."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, part
from tgvdp.line.cells import cells_of
from tgvdp.memory import scratch
from tgvdp.methods.phases.approach import approach
from tgvdp.methods.phases.held import join_holds
from tgvdp.methods.phases.plan import LASTS_S, MAY_GO, PLAN_COLUMNS, leave_out, plan_of, shortest
from tgvdp.methods.phases.regimes import tell_regimes, without_touches
from tgvdp.methods.phases.retime import retime
from tgvdp.methods.phases.track import track
from tgvdp.methods.phases.way import Room, Run, Way, copy_rows, is_sound, total, way_of
from tgvdp.methods.phases.widen import widen
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import BRAKING, DYNAMIC
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import kernel_train
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import USUAL_ROWS

_Floats = NDArray[np.float64]

#: What is done in turn: phases shorter than a share of the least duration are left out, or widened. First what is next
#: to nothing, so that it does not stand or fall with longer phases beside it; last what is long enough but might be
#: longer, with what is left to spend.
_APPROACHED, _LEFT_OUT, _WIDENED = 0, 1, 2
_PASSES = (
    (0.05, _LEFT_OUT),
    (1.0, _APPROACHED),
    (1.0, _LEFT_OUT),
    (1.0, _WIDENED),
    (3.0, _APPROACHED),
    (3.0, _LEFT_OUT),
    (3.0, _WIDENED),
)
#: What leaving out a single phase that is too short may cost besides what all may, as a share of that, and all of these
#: together.
_EACH = 0.2
_CHEAP = 1.0
#: A run gets its time back after all that, or else all that keeps to it, or else the run stays as it is.
_LATER_IN_TIME, _IN_TIME, _AS_IT_IS = _ATTEMPTS = (0, 1, 2)
_MOST_PHASES = 4000
#: Phases of coasting that begin earlier, or later, for a run to be in time.
_MOST_STARTS = 16
#: Phases of a plan that is not that of the run.
_UNKNOWN = -1
#: Rows that a run may gain.
_MORE_ROWS = 20_000


class Pruned(NamedTuple):
    """Runs without short phases.

    Attributes
    ----------
    runs : Batch
        n of them, of N rows in all.
    regime : (N,) int8
        Of the row that starts there, as of `runs.profile`: the dynamic brake brakes. −1 where a run ends.
    time_s, energy_j : (n,) float64
        By how much each takes longer, and costs more.
    short : int
        Phases that are too short and had to stay.
    """

    runs: Batch
    regime: NDArray[np.int8]
    time_s: _Floats
    energy_j: _Floats
    short: int


@part
def _short(plan, count, least_s):
    """Phases of a plan that are shorter than ``least_s`` although they might be left out."""
    short = 0
    for c in range(count - 1):
        if plan[c, LASTS_S] < least_s and plan[c, MAY_GO] > 0.0:
            short += 1
    return short


@part
def _phases(way, run, n, plan, least_s):
    """Phases of a run whose regimes are told row by row; −1 if there is no room for them."""
    count = plan_of(way, run, n, plan)
    if join_holds(run, n, plan, count, _PASSES[-1][0] * least_s):
        count = plan_of(way, run, n, plan)
    return count


@part
def _prune(way, here, there, n, plan, price, least_s, room, later_s, slack_s):
    """Do all passes on the run in ``here``, with its regimes, and give it back its running time.

    Returns
    -------
    n : int
        Rows; −1 where the run must stay as it is.
    swapped : bool
        Whether they are in ``there``.
    time, energy : float
    short : int
    """
    before_s, before_j = total(here, 0, n - 1)
    swapped = False
    count = _UNKNOWN
    for p in range(len(_PASSES)):
        share, how = _PASSES[p]
        longest_s = share * least_s
        if count < 0:
            n = without_touches(way, here, n)
            count = _phases(way, here, n, plan, least_s)
        if shortest(plan, count, longest_s) < 0:
            continue
        if share > 1.0:  # what is long enough goes for what is left alone
            room = Room(room.most_j, room.earliest_s, room.latest_s, 0.0, room.cheap_j)
        if how == _APPROACHED:
            rows, room = approach(way, here, n, plan, count, price, longest_s, room, there)
            if rows == 0:
                continue
            n = rows
        elif how == _WIDENED:
            n, room = widen(way, here, n, plan, count, price, longest_s, room, there)
        else:
            planned = leave_out(way, plan, count, longest_s)
            n, _, room = track(way, here, n, plan, planned, price, longest_s, room, there)
        if n < 0:
            return -1, False, 0.0, 0.0, 0
        here, there = there, here
        swapped = not swapped
        count = _UNKNOWN
    if count < 0:
        count = _phases(way, here, n, plan, least_s)
    now_s, now_j = total(here, 0, n - 1)
    most_j = room.most_j + room.cheap_j
    longest_s = math.inf
    for _ in range(_MOST_STARTS):
        late_s = now_s - before_s - later_s
        if abs(late_s) <= slack_s:
            break
        n, longest_s = retime(way, here, n, plan, count, price, most_j, late_s, slack_s, longest_s, there)
        if n < 0:
            break
        here, there = there, here
        swapped = not swapped
        most_j += now_j + price * now_s
        now_s, now_j = total(here, 0, n - 1)
        most_j -= now_j + price * now_s
        count = _phases(way, here, n, plan, least_s)
    if not abs(now_s - before_s - later_s) <= slack_s:  # no number is not in time
        return -1, False, 0.0, 0.0, 0
    return n, swapped, now_s - before_s, now_j - before_j, _short(plan, count, least_s)


@entry
def prune_runs(way, given, ends, price, least_s, most_j, later_s, slack_s, here, there, plan, out, found):
    """Prune runs one after the other.

    Parameters
    ----------
    way : Way
    given : Run, modified in place
        The rows of all of them, which are told here, and
    ends : (n + 1,) int64
        where each begins.
    price, most_j, later_s : (n,) float64
    least_s, slack_s : float
        As of `prune`.
    here, there : Run, modified in place
    plan : (size, PLAN_COLUMNS) float64, modified in place
    out : Run, modified in place
        The rows of all new runs.
    found : (n, 4) float64, modified in place
        Of each: where it ends in ``out``, by how much it takes longer and costs more, and its short phases.
    """
    m = 0
    before = 0
    for r in range(price.shape[0]):
        first = ends[r]
        n = ends[r + 1] - first
        last = first + n - 1
        tell_regimes(way, given, before, first, last)
        before = first
        most_rows = out.x.shape[0] - m - (ends[-1] - ends[r + 1])  # the rest fits as it is
        for attempt in _ATTEMPTS:
            here.x[0] = given.x[first]
            here.w[0] = given.w[first]
            copy_rows(given, first, last, here, 1)
            count = plan_of(way, here, n, plan)
            size, run, time_s, energy_j, short = n, here, 0.0, 0.0, 0
            if shortest(plan, count, _PASSES[-1][0] * least_s) < 0:
                break
            if attempt == _AS_IT_IS:
                short = _short(plan, _phases(way, here, n, plan, least_s), least_s)
                break
            by_s = math.inf if attempt == _LATER_IN_TIME else slack_s
            room = Room(most_j[r], later_s[r] - by_s, later_s[r] + by_s, _EACH * most_j[r], _CHEAP * most_j[r])
            size, swapped, time_s, energy_j, short = _prune(
                way, here, there, n, plan, price[r], least_s, room, later_s[r], slack_s
            )
            run = there if swapped else here
            if 0 < size <= most_rows and is_sound(way, run, size, given, first, last):
                break
        for j in range(size):
            out.x[m + j] = run.x[j]
            out.w[m + j] = run.w[j]
            out.regime[m + j] = BRAKING if run.regime[j] == DYNAMIC else run.regime[j]
        m += size
        found[r, 0] = m
        found[r, 1] = time_s
        found[r, 2] = energy_j
        found[r, 3] = short


def prune(
    way: Way, runs: Batch, price: _Floats, least_s: float, most_j: _Floats, later_s: _Floats, slack_s: float
) -> Pruned:
    """Leave out of runs what is too short to drive.

    Parameters
    ----------
    way : Way
    runs : Batch
        Of n runs, one at least.
    price : (n,) float64
        What a second is worth, J/s, auxiliaries included.
    least_s : float
        Phases that are shorter, s, are left out.
    most_j : (n,) float64
        By how much E + λT may rise, J.
    later_s : (n,) float64
        How much later than before each run is wanted, s,
    slack_s : float
        and how well that is to be met, s.

    Returns
    -------
    Pruned
    """
    most = int(runs.sizes.max())
    here, there, out = (
        Run.of(scratch(f"prune {name}", 5, 2 * size + _MORE_ROWS))
        for name, size in (("here", most), ("there", most), ("out", len(runs.x_m)))
    )
    plan, found = scratch("prune plan", _MOST_PHASES, PLAN_COLUMNS), np.empty((runs.size, 4))
    given = Run.of(scratch("prune given", 5, len(runs.x_m)))._replace(x=runs.x_m, w=runs.w)
    prune_runs(way, given, runs.first, price, least_s, most_j, later_s, slack_s, here, there, plan, out, found)
    first = np.zeros(runs.size + 1, dtype=np.int64)
    first[1:] = found[:, 0]
    size = first[-1]
    pruned = Batch(out.x[:size].copy(), out.w[:size].copy(), first)
    regime = out.regime[:size].astype(np.int8)
    regime[first[1:] - 1] = -1
    return Pruned(pruned, regime, found[:, 1], found[:, 2], int(found[:, 3].sum()))


def prune_fastest(trip: Trip, x_m: _Floats, w: _Floats, least_s: float) -> Pruned:
    """Leave short phases out of the fastest run, for nothing: all kernels are called, and no mesh is needed.

    Parameters
    ----------
    trip : Trip
    x_m, w : (n,) float64
        Rows of the run: positions from the origin, m, and squared speeds, m²/s².
    least_s : float
        Phases that are shorter, s, would be left out if that cost nothing.
    """
    train = kernel_train(trip.train)._replace(rows=USUAL_ROWS)
    way = way_of(train, cells_of(trip), Rows(x_m, w), energy_tables(trip.train, trip.energy))
    return prune(way, Batch.of([(x_m, w)]), np.ones(1), least_s, np.zeros(1), np.zeros(1), least_s)
