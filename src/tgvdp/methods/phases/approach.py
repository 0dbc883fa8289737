"""Phases that are too short go because the one before them begins later, or earlier, and comes to where they end.

A train that coasts to a lower limit and brakes for the last hand's breadth coasts a little earlier instead; one that
reaches a limit just before it rises pulls a little later. The way there is followed backwards from the end of the short
phase until it meets the run.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.plan import AT, LASTS_S, MAY_GO, REGIME, START_W
from tgvdp.methods.phases.way import (
    SAME_M,
    copy_rows,
    is_feasible,
    is_within,
    left_of,
    measure,
    row_at,
    total,
    train_in,
    w_on,
)
from tgvdp.physics.cell import Cell, Rows
from tgvdp.physics.codes import HOLDING
from tgvdp.physics.march import march

#: Two squared speeds that differ by less than this share are one.
_SAME_W = 1e-9
#: No squared speed at which a march ends.
_NONE = -1.0
#: How many phases before the short one the run may be left.
_PHASES = 3


@part
def _worth_trying(plan, c, price, room):
    """Whether a phase may be so cheap to do without: what it changes of the speed takes time beside it."""
    w0 = plan[c, START_W]
    w1 = plan[c + 1, START_W]
    faster = math.sqrt(max(w0, w1))
    least_j = price * abs(math.sqrt(w1) - math.sqrt(w0)) * plan[c, LASTS_S] / (2.0 * faster)
    return least_j <= max(room.most_j, room.each_j)


@part
def _back(way, run, n, regime, x, w, until_m, out, free):
    """Rows of a regime that come to a squared speed at a position, backwards, until they meet a run from below.

    They are appended to ``out`` from its row ``free`` on. Returns the row of the run on which they meet, where, and the
    row behind the last one; −1 where they do not meet it behind ``until_m``.
    """
    stations_m = way.cells.station_m
    i = row_at(run.x, n, x - SAME_M)
    k = row_at(stations_m, stations_m.shape[0], x - SAME_M)
    out.x[free] = x
    out.w[free] = w
    m = free + 1
    while x > until_m and k >= 0:
        length_m = x - stations_m[k]
        cell = Cell(stations_m[k], x, length_m, way.cells.grade_n[k], way.cells.air[k], math.inf)
        first = m
        _, w, m = march(train_in(way, k), regime, -1.0, cell, length_m, w, _NONE, Rows(out.x, out.w), m)
        if m < 0 or w <= 0.0:
            return -1, 0.0, -1
        for j in range(first, m):
            out.x[j] = x - out.x[j]
        out.x[m - 1] = stations_m[k]
        for j in range(first, m):
            xb = out.x[j - 1]
            fb = out.w[j - 1] - w_on(run.x, run.w, i, xb)
            while xb > out.x[j]:
                xa = max(run.x[i], out.x[j])
                fa = w_on(out.x, out.w, j - 1, xa) - w_on(run.x, run.w, i, xa)
                if fa > _SAME_W * w:
                    if fb >= 0.0:  # above the run
                        return -1, 0.0, -1
                    at = xb - (xb - xa) * fb / (fb - fa)
                    return i, at, j
                fb = fa
                xb = xa
                if i > 0 and run.x[i] >= xb:
                    i -= 1
                elif xb > out.x[j]:
                    return -1, 0.0, -1
        x = out.x[m - 1]
        k -= 1
    return -1, 0.0, -1


@part
def _join(way, run, i, start, at, regime, free, behind, out, m):
    """Append rows of a run, from its row ``i`` on, to where it is left on its row ``start``, and those of the march.

    Returns their number, and the one with which it is left.
    """
    copy_rows(run, i, start, out, m)
    size = m + start - i
    first = size - 1
    if at > run.x[start] + SAME_M:
        out.x[size] = at
        out.w[size] = w_on(run.x, run.w, start, at)
        out.regime[size - 1] = run.regime[start]
        size += 1
    left = size - 1
    for j in range(behind - 1, free - 1, -1):
        if out.x[j] > out.x[size - 1] + SAME_M:
            out.x[size] = out.x[j]
            out.w[size] = out.w[j]
            out.regime[size - 1] = regime
            size += 1
    measure(way, out, first, size - 1)
    return size, left


@part
def _lasts(run, n, plan, c, start, at, least_s, out, first, left, size):
    """Whether the phase that is left, and the one that comes to the end of phase ``c``, are long, or as they were."""
    p = max(c - _PHASES, 0)
    while plan[p + 1, AT] <= at:
        p += 1
    before_s = total(run, row_at(run.x, n, plan[p, AT]), start)[0] + total(out, first, left)[0]
    if before_s < min(least_s, plan[p, LASTS_S]):
        return False
    lasts_s = total(out, left, size - 1)[0]
    return lasts_s >= min(least_s, plan[c - 1, LASTS_S]) or plan[c + 1, REGIME] == plan[c - 1, REGIME]


@part
def _fits(way, run, start, out, first, left):
    """Whether a train gives the effort of what is left of the row on which a run is left: it was right as a mean."""
    stations_m = way.cells.station_m
    k = row_at(stations_m, stations_m.shape[0], run.x[start] + SAME_M)
    fits = True
    for j in range(first, left):
        fits = fits and is_feasible(way, k, out.x[j + 1] - out.x[j], out.w[j], out.w[j + 1])
    return fits


@kernel
def approach(way, run, n, plan, count, price, least_s, room, out):
    """Leave out phases that are too short where the one before them may come to their end.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows.
    plan : (count, PLAN_COLUMNS) float64
        Of its phases.
    price : float
        What a second is worth, J/s, auxiliaries included.
    least_s : float
        How long a phase must last, s.
    room : Room
    out : Run, modified in place

    Returns
    -------
    m : int
        Rows of the new run; 0 where nothing changes.
    room : Room
        What is left of it.
    """
    free = out.x.shape[0] // 2
    out.x[0] = run.x[0]
    out.w[0] = run.w[0]
    m = 1
    i = 0  # row of the run on which the new rows end
    for c in range(2, count - 1):
        regime = int(plan[c - 1, REGIME])
        goes = plan[c, LASTS_S] < least_s and plan[c, MAY_GO] > 0.0 and plan[c - 1, MAY_GO] > 0.0
        if not goes or regime == HOLDING or not _worth_trying(plan, c, price, room):
            continue
        end = row_at(run.x, n, plan[c + 1, AT])
        first_m = max(run.x[i], plan[max(c - _PHASES, 0), AT])
        start, at, behind = _back(way, run, n, regime, run.x[end], run.w[end], first_m, out, free)
        if behind < 0 or at <= first_m + SAME_M:
            continue
        if m + n - i + behind - free > free:
            break
        size, left = _join(way, run, i, start, at, regime, free, behind, out, m)
        first = m + start - i - 1
        new_s, new_j = total(out, first, size - 1)
        old_s, old_j = total(run, start, end)
        later_s = new_s - old_s
        dearer_j = new_j - old_j + price * later_s
        lasts = _lasts(run, n, plan, c, start, at, least_s, out, first, left, size)
        if lasts and _fits(way, run, start, out, first, min(left, size - 1)) and is_within(room, dearer_j, later_s):
            room = left_of(room, dearer_j, later_s)
            m = size
            i = end
    if i == 0:
        return 0, room
    copy_rows(run, i, n - 1, out, m)
    return m + n - 1 - i, room
