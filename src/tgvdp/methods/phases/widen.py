"""Phases that are too short, and that no neighbour can take over, last longer at a partial effort.

From before such a phase to after it v² changes evenly, for as long as a phase must last: of a dab of the brake before a
limit becomes a gentle one.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.plan import AT, LASTS_S, MAY_GO, REGIME, START_W
from tgvdp.methods.phases.track import stretch
from tgvdp.methods.phases.way import (
    SAME_M,
    cell_from,
    copy_rows,
    is_feasible,
    is_within,
    left_of,
    measure,
    row_at,
    total,
    w_on,
)
from tgvdp.physics.codes import HOLDING

#: Shares of what a phase gains that the one before it gives, the other one the rest.
_SHARES = (1.0, 0.5, 0.0)
#: Times as long as the least a phase becomes, as speeds beside it differ from its own.
_MARGIN = 1.1
#: Two squared speeds that differ by less than this share are one.
_SAME_W = 1e-9


@part
def _may_give(plan, c, gives_s, least_s):
    """Whether a phase may be so much shorter: one of partial effort goes on in what it gives to."""
    if gives_s == 0.0:
        return True
    left_s = plan[c, LASTS_S] - gives_s
    return plan[c, MAY_GO] > 0.0 and left_s >= (0.0 if plan[c, REGIME] == HOLDING else least_s)


@part
def _copied(way, run, n, until_m, i, out, m):
    """Copy rows from the end of row i of the run on, as far as they end before a position; returns row and rows."""
    last = i
    while last + 1 < n and run.x[last + 1] < until_m - SAME_M:
        last += 1
    copy_rows(run, i, last, out, m)
    measure(way, out, m - 1, min(m, m - 1 + last - i))  # it may be cut
    return last, m + last - i


@part
def _ramp(way, run, n, i, from_m, until_m, out, m):
    """Append rows from a position on row i of the run to another one along which v² changes evenly.

    Returns the row on which they end and their number; −1 where they ask for too much, or pass the envelope. So may
    what is left of the rows of the run that they cut, as the effort of a row is right as a mean alone.
    """
    ex = way.envelope.x
    ew = way.envelope.w
    w0 = w_on(run.x, run.w, i, from_m)
    last = row_at(run.x, n, until_m - SAME_M)
    w1 = w_on(run.x, run.w, last, until_m)
    cells = way.cells
    k = row_at(cells.station_m, cells.station_m.shape[0], out.x[m - 1] + SAME_M)
    if not is_feasible(way, k, from_m - out.x[m - 1], out.w[m - 1], w0):
        return last, -1
    out.x[m] = from_m
    out.w[m] = w0
    out.regime[m - 1] = run.regime[i]
    m += 1
    for j in range(i + 1, last + 2):
        x = run.x[j] if j <= last else until_m
        if x <= out.x[m - 1] + SAME_M:
            continue
        k = cell_from(cells, k, out.x[m - 1])
        w = w0 + (w1 - w0) * ((x - from_m) / (until_m - from_m)) if x < until_m else w1
        fits = w <= w_on(ex, ew, row_at(ex, ex.shape[0], x), x) * (1.0 + _SAME_W)
        if not fits or not is_feasible(way, k, x - out.x[m - 1], out.w[m - 1], w):
            return last, -1
        out.x[m] = x
        out.w[m] = w
        out.regime[m - 1] = HOLDING
        m += 1
    rest_m = run.x[last + 1] - until_m
    k = cell_from(cells, k, until_m)
    fits = rest_m <= SAME_M or is_feasible(way, k, rest_m, w1, run.w[last + 1])
    return last, m if fits else -1


@kernel
def widen(way, run, n, plan, count, price, least_s, room, out):
    """Let phases that are too short last longer at a partial effort, where that costs little.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows.
    plan : (count, PLAN_COLUMNS) float64, modified in place
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
        Rows of the new run; −1 if there is no room for them.
    room : Room
        What is left of it.
    """
    if 2 * count + n > out.x.shape[0]:
        return -1, room
    out.x[0] = run.x[0]
    out.w[0] = run.w[0]
    m = 1
    i = 0
    done_m = -1.0  # where the last one of them ends
    for c in range(1, count - 1):
        gains_s = _MARGIN * least_s - plan[c, LASTS_S]
        if plan[c, LASTS_S] >= least_s or plan[c, MAY_GO] == 0.0:
            continue
        # No ramp, of this phase or a later one, begins before this.
        i, m = _copied(way, run, n, plan[c, AT] - gains_s * math.sqrt(plan[c, START_W]), i, out, m)
        best = -1
        best_j = math.inf
        for option in range(len(_SHARES) + 1):
            final = option == len(_SHARES)
            if final and best < 0:
                break
            share = _SHARES[best if final else option]
            before_s = share * gains_s
            after_s = gains_s - before_s
            if not (_may_give(plan, c - 1, before_s, least_s) and _may_give(plan, c + 1, after_s, least_s)):
                continue
            from_m = plan[c, AT] - before_s * math.sqrt(plan[c, START_W])
            until_m = plan[c + 1, AT] + after_s * math.sqrt(plan[c + 1, START_W])
            if from_m < max(done_m, plan[c - 1, AT]) + SAME_M or until_m > run.x[n - 1] - SAME_M:
                continue
            first, size = _copied(way, run, n, from_m, i, out, m)
            start = size
            last, size = _ramp(way, run, n, first, from_m, until_m, out, size)
            if size < 0:
                continue
            # Whole rows of the run count: what a brake gives back is right as a row's mean, and less on parts of it.
            out.x[size] = run.x[last + 1]
            out.w[size] = run.w[last + 1]
            whole = size if run.x[last + 1] > until_m + SAME_M else size - 1
            measure(way, out, start - 1, whole)
            lasts_s, _ = total(out, start, size - 1)
            new_s, new_j = total(out, start - 1, whole)
            old_s, old_j, _ = stretch(way, run, first, out.x[start - 1], last, out.x[whole], -1, -1, 0.0)
            later_s = new_s - old_s
            dearer_j = new_j - old_j + price * later_s
            if final:
                room = left_of(room, dearer_j, later_s)
                m = size
                i = last + 1 if run.x[last + 1] <= until_m + SAME_M else last
                done_m = until_m
                plan[c, LASTS_S] = lasts_s
                plan[c + 1, LASTS_S] -= after_s
            elif lasts_s >= least_s and dearer_j <= best_j and is_within(room, dearer_j, later_s):
                best = option
                best_j = dearer_j
    i, m = _copied(way, run, n, math.inf, i, out, m)
    return m, room
