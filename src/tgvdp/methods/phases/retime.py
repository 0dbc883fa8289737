"""A run gets its time back: phases of coasting begin a little earlier, or later."""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.plan import AT, LASTS_S, REGIME, START_W, acceleration
from tgvdp.methods.phases.track import track, track_part
from tgvdp.methods.phases.way import Room, row_at, total
from tgvdp.physics.codes import COASTING, HOLDING, TRACTION

#: Trials of each phase of coasting, and the most that may be left of it, or taken of the phase before, as a share; in
#: the first trial so much of that.
_TRIES = 6
_MOST = 0.9
_FIRST = 0.5
#: What a phase before it gains on coasting at least, m/s²: one that holds a speed downhill gains nothing.
_LEAST_GAIN = 1e-3
#: Phases behind the one whose start is moved, at the end of which a trial ends unless it is off the run there.
_PHASES = 4
#: Whatever it costs, whenever it arrives.
_ALL = Room(math.inf, -math.inf, math.inf, 0.0, 0.0)


@part
def _start_of_coasting(plan, count, most_s):
    """The longest phase of coasting, of less than ``most_s``, that follows traction or a hold; −1 if there is none."""
    best = -1
    for c in range(1, count - 1):
        follows = plan[c - 1, REGIME] == TRACTION or plan[c - 1, REGIME] == HOLDING
        coasts = follows and plan[c, REGIME] == COASTING and plan[c, LASTS_S] < most_s
        if coasts and (best < 0 or plan[c, LASTS_S] > plan[best, LASTS_S]):
            best = c
    return best


@part
def _gains_m_per_s(way, plan, c):
    """How much later a phase of coasting begins for each second less that a run takes, about, m/s.

    What speed it has more is the same all along the phase but for the drag: v² differs by twice the way times the
    difference of the accelerations, and each second by half of that over v².
    """
    stations_m = way.cells.station_m
    w = plan[c, START_W]
    k = row_at(stations_m, stations_m.shape[0], plan[c, AT])
    gained = acceleration(way, k, int(plan[c - 1, REGIME]), w) - acceleration(way, k, COASTING, w)
    return 0.5 * (w + plan[c + 1, START_W]) / (max(gained, _LEAST_GAIN) * plan[c, LASTS_S])


@part
def _changed(way, run, n, first, end, plan, count, price, out):
    """By how much a run that is driven by a plan takes longer, s, and costs more, J; infinite where it cannot be.

    It differs from the row ``first`` on, and meets the run again at the row ``end`` or later.
    """
    m, last, refused, _ = track_part(way, run, n, first, end, plan, count, price, 0.0, _ALL, out)
    if m < 0 or refused > 0:
        return math.inf, math.inf
    before_s, before_j = total(run, first, last)
    after_s, after_j = total(out, 0, m - 1)
    return after_s - before_s, after_j - before_j


@part
def _shift_of(way, run, n, plan, count, c, price, most_j, late_s, tolerance_s, out):
    """By how much the start of a phase of coasting is moved so that the run is in time, or as nearly as it can be, m.

    0 where that brings the run no nearer to its time. The plan is left as it was.
    """
    start_m = plan[c, AT]
    first = row_at(run.x, n, plan[c - 1, AT])
    end = row_at(run.x, n, plan[c + _PHASES, AT]) if c + _PHASES < count else n - 1
    earliest_m = -_MOST * (start_m - plan[c - 1, AT])
    latest_m = _MOST * (plan[c + 1, AT] - start_m)
    best_m = last_m = 0.0
    best_s = last_s = late_s
    shift_m = min(max(late_s * _gains_m_per_s(way, plan, c), _FIRST * earliest_m), _FIRST * latest_m)
    for _ in range(_TRIES):
        plan[c, AT] = start_m + shift_m
        later_s, dearer_j = _changed(way, run, n, first, end, plan, count, price, out)
        now_s = late_s + later_s
        if now_s == math.inf or now_s == last_s:
            break
        if abs(now_s) < abs(best_s) and dearer_j + price * later_s <= most_j:
            best_m = shift_m
            best_s = now_s
        if abs(now_s) <= tolerance_s:
            break
        next_m = shift_m - now_s * (shift_m - last_m) / (now_s - last_s)
        last_m = shift_m
        last_s = now_s
        shift_m = min(max(next_m, earliest_m), latest_m)
        if shift_m == last_m:
            break
    plan[c, AT] = start_m
    return best_m


@kernel
def retime(way, run, n, plan, count, price, most_j, late_s, tolerance_s, longest_s, out):
    """Move the start of a long coasting until the run is no longer late, or early, or as far as that can be.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows.
    plan : (count, PLAN_COLUMNS) float64, modified in place
        Of its phases.
    price : float
        What a second is worth, J/s, auxiliaries included.
    most_j : float
        By how much E + λT may rise, J.
    late_s, tolerance_s : float
        By how much the run is late, s, and may be at most.
    longest_s : float
        Shorter phases of coasting alone are moved, s.
    out : Run, modified in place

    Returns
    -------
    m : int
        Rows of the new run; −1 where no start brings it nearer to its time.
    longest_s : float
        How long the phase lasts whose start was moved, s.
    """
    while True:  # each turn is for a shorter phase
        c = _start_of_coasting(plan, count, longest_s)
        if c < 0:
            return -1, longest_s
        longest_s = plan[c, LASTS_S]
        shift_m = _shift_of(way, run, n, plan, count, c, price, most_j, late_s, tolerance_s, out)
        if shift_m != 0.0:
            plan[c, AT] += shift_m
            m, refused, _ = track(way, run, n, plan, count, price, 0.0, _ALL, out)
            if refused == 0:
                return m, longest_s
            plan[c, AT] -= shift_m
