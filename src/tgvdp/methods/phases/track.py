"""Drive a plan along a run: off it where the two differ, where that is worth it."""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.leave import drive, leave
from tgvdp.methods.phases.plan import AT, REGIME
from tgvdp.methods.phases.way import SAME_M, copy_rows, is_within, left_of, measure, row_at, total, w_on
from tgvdp.physics.codes import HOLDING, TRACTION


@part
def _lacking_s(run, first, last, before, after, least_s):
    """Seconds that phases within rows ``first`` to ``last`` − 1 lack of the least; what goes on beyond lacks none."""
    lacking = 0.0
    lasts_s = least_s
    regime = before
    for j in range(first, last):
        if run.regime[j] != regime:
            lacking += max(least_s - lasts_s, 0.0)
            regime = run.regime[j]
            lasts_s = 0.0
        lasts_s += run.time[j]
    return lacking + (max(least_s - lasts_s, 0.0) if regime != after else 0.0)


@part
def stretch(way, run, i, from_m, j, until_m, before, after, least_s):
    """Time, energy and `_lacking_s` from a position on row i of a run, which is cut for it, to one on its row j."""
    x0 = run.x[i]
    w0 = run.w[i]
    x1 = run.x[j + 1]
    w1 = run.w[j + 1]
    at_end = w_on(run.x, run.w, j, until_m)
    run.w[i] = w_on(run.x, run.w, i, from_m)
    run.x[i] = from_m
    run.x[j + 1] = until_m
    run.w[j + 1] = at_end
    last = j + 1 if until_m > run.x[j] + SAME_M else j
    measure(way, run, i, i + 1)
    measure(way, run, j, j + 1)
    time, energy = total(run, i, last)
    lacking = _lacking_s(run, i, last, before, after, least_s)
    run.x[i] = x0
    run.w[i] = w0
    run.x[j + 1] = x1
    run.w[j + 1] = w1
    measure(way, run, i, i + 1)
    measure(way, run, j, j + 1)
    return time, energy, lacking


@part
def _until(way, run, i, until, out, m):
    """Drive as a run does on its row i, up to a position on it; returns the rows, −1 where the train stalls."""
    regime = run.regime[i]
    if regime == HOLDING:
        out.x[m] = until
        out.w[m] = w_on(run.x, run.w, i, until)
        last = m + 1
    else:
        stations_m = way.cells.station_m
        k = row_at(stations_m, stations_m.shape[0], out.x[m - 1] + SAME_M)
        last, _ = drive(way, k, regime, until, math.inf if regime == TRACTION else 0.0, out, m)
    for j in range(m, last):
        out.regime[j - 1] = regime
    return last


@kernel
def track(way, run, n, plan, planned, price, least_s, room, out):
    """Drive a plan along a run; where that costs too much, or leaves phases shorter, the run stays.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows.
    plan : (planned, PLAN_COLUMNS) float64
    price : float
        What a second is worth, J/s, auxiliaries included.
    least_s : float
        How long phases should last, s.
    room : Room
        What all stretches on which the two differ may cost together, and how much later they may be.
    out : Run, modified in place

    Returns
    -------
    m : int
        Rows of the new run; −1 if there is no room for them.
    refused : int
        On how many stretches the run stays although the plan differs.
    room : Room
        What is left of it.
    """
    m, _, refused, room = track_part(way, run, n, 0, n - 1, plan, planned, price, least_s, room, out)
    return m, refused, room


@part
def track_part(way, run, n, i, end, plan, planned, price, least_s, room, out):
    """`track` from row ``i`` of the run on, up to the row ``end`` or that behind it on which the two meet again.

    Returns its row, too, behind the number of the new ones.
    """
    out.x[0] = run.x[i]
    out.w[0] = run.w[i]
    m = 1
    c = 0
    size = out.x.shape[0]
    refused = 0
    kept = 0  # the run stays up to here
    # Each turn goes on by rows of the run, or appends rows that advance, or refuses: then rows of the run follow.
    while i < end or (i < n - 1 and out.x[m - 1] != run.x[i]):
        x = out.x[m - 1]
        if m + 2 > size:
            return -1, i, 0, room
        while c + 1 < planned and plan[c + 1, AT] <= x + SAME_M:
            c += 1
        turn_m = plan[c + 1, AT] if c + 1 < planned else run.x[n - 1]
        now = int(plan[c, REGIME])
        turns = now == run.regime[i] and turn_m < run.x[i + 1] - SAME_M
        turns = turns and plan[min(c + 1, planned - 1), REGIME] != run.regime[i]
        if i < kept or (now == run.regime[i] and not turns):
            is_cut = x != run.x[i] or out.w[m - 1] != run.w[i]  # the two have met within it
            last = i + 1
            # As long as both go on: this is most of a run.
            while last < end and run.regime[last] == now and run.x[last + 1] < turn_m - 2.0 * SAME_M:
                last += 1
            last = min(last, i + size - m)
            copy_rows(run, i, last, out, m)
            if is_cut:
                measure(way, out, m - 1, m)
            m += last - i
            i = last
            continue
        first = m
        if turns:
            m = _until(way, run, i, turn_m, out, m)
        last, j = leave(way, run, n, i, plan, planned, c + 1 if turns else c, out, m) if m > 0 else (-1, i)
        if last > 0 and out.x[last - 1] > x + SAME_M:
            before = out.regime[first - 2] if first > 1 else -1
            whole = out.x[last - 1] >= run.x[j + 1] - SAME_M and j < n - 2
            after = run.regime[j + 1] if whole else run.regime[j]
            measure(way, out, first - 1, last - 1)
            new_s, new_j = total(out, first - 1, last - 1)
            old_s, old_j, old_lacking_s = stretch(way, run, i, x, j, out.x[last - 1], before, after, least_s)
            later_s = new_s - old_s
            dearer_j = new_j - old_j + price * later_s
            lacking_s = _lacking_s(out, first - 1, last - 1, before, after, least_s)
            if lacking_s <= old_lacking_s and is_within(room, dearer_j, later_s):
                room = left_of(room, dearer_j, later_s)
                m = last
                i = j
                if out.x[m - 1] >= run.x[i + 1] - SAME_M:
                    out.x[m - 1] = run.x[i + 1]
                    measure(way, out, m - 2, m - 1)
                    i += 1
                continue
        m = first
        refused += 1
        kept = i + 1
        while kept < n - 1 and run.regime[kept] == run.regime[i]:
            kept += 1
    return m, i, refused, room
