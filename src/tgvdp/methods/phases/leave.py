"""Off a run and back onto it.

Off the run a train goes on in its regime until the plan has another. One that runs below takes the stronger of the two
and one that runs above the weaker, so that they meet again at the next change that brings them together. A speed that
the plan holds next is held as soon as it is reached; the envelope is ridden as far as the regime's effort allows.
"""

import math

from tgvdp._jit import part
from tgvdp.methods.phases.plan import AT, FROM_ABOVE, REGIME, START_W
from tgvdp.methods.phases.regimes import pull, regime_of_row
from tgvdp.methods.phases.way import SAME_M, cell_from, is_feasible, row_at, train_in, w_on
from tgvdp.model.track import POWERED
from tgvdp.physics.cell import Cell, Rows
from tgvdp.physics.codes import COASTING, HOLDING, TRACTION
from tgvdp.physics.march import march

#: Two squared speeds that differ by less than this share are one.
_SAME_W = 1e-9
#: ... and so are two runs under one regime that differ by less than this: they are rounded in other rows.
_SAME_CURVE_W = 1e-7
#: A hold may begin at a speed that differs from the run's by this share of w.
_NEAR_W = 5e-3
#: Rows of one march at most, and changes of the plan until the run must be met again.
_MOST_ROWS = 4096
_MOST_CHANGES = 8


@part
def _meets(run, n, start, out, first, last, regime, moves, rides):
    """Where new rows first meet a run whose regime there is that of the plan, or at its end.

    Rows of the regime in which the train ``moves`` run beside its own: they only seem to cross. One that ``rides`` on
    the envelope has that regime there, too. Returns the run's row, the new row that does, −1 for none, and where.
    """
    j = start
    for i in range(first, last):
        xa = out.x[i - 1]
        fa = out.w[i - 1] - w_on(run.x, run.w, j, xa)
        for j in range(start, n - 1):
            if j < n - 2 and run.x[j + 1] <= xa:
                continue
            xb = min(out.x[i], run.x[j + 1])
            top = w_on(run.x, run.w, j, xb)
            fb = w_on(out.x, out.w, i - 1, xb) - top
            joins = run.regime[j] == regime and (not rides or out.regime[i - 1] == regime)
            if joins or xb >= run.x[n - 1]:
                beside = run.regime[j] == moves
                if abs(fb) <= (_SAME_CURVE_W if beside else _SAME_W) * top:
                    return j, i, xb
                if not beside and abs(fa) > _SAME_W * top and fa * fb < 0.0:
                    return j, i, xa + (xb - xa) * fa / (fa - fb)
            fa = fb
            xa = xb
            if xb >= out.x[i]:
                break
        start = j
    return j, -1, 0.0


@part
def _clip(way, start, out, first, last):
    """Cut rows where they pass above the envelope; returns their number, its row, and whether they do."""
    ex = way.envelope.x
    ew = way.envelope.w
    e = start
    for i in range(first, last):
        xa = out.x[i - 1]
        fa = 0.0
        for e in range(start, ex.shape[0] - 1):
            if e < ex.shape[0] - 2 and ex[e + 1] <= xa:
                continue
            xb = min(out.x[i], ex[e + 1])
            top = w_on(ex, ew, e, xb)
            fb = w_on(out.x, out.w, i - 1, xb) - top
            if fb > _SAME_W * top:
                at = xa + (xb - xa) * (-fa) / (fb - fa) if fa < 0.0 else xa
                if at <= out.x[i - 1] + SAME_M:
                    return i, e, True
                out.x[i] = at
                out.w[i] = w_on(ex, ew, e, at)
                return i + 1, e, True
            fa = fb
            xa = xb
            if xb >= out.x[i]:
                break
        start = e
    return last, e, False


@part
def _ride(way, k, start, regime, after, until, out, m):
    """Append rows of the envelope as long as they take no more effort than a regime has; returns rows, and its row.

    They are whole, as their efforts are right as means alone, but where the regime ``after`` leaves the envelope.
    """
    ex = way.envelope.x
    ew = way.envelope.w
    e = start
    for e in range(start, ex.shape[0] - 1):
        if ex[e + 1] <= out.x[m - 1] + SAME_M:
            continue
        if out.x[m - 1] >= until - SAME_M or m == out.x.shape[0]:
            break
        own = regime_of_row(way, k, ex[e + 1] - ex[e], ew[e], ew[e + 1])
        if pull(way, k, own, out.w[m - 1]) > pull(way, k, regime, out.w[m - 1]):
            break
        stays = pull(way, k, own, out.w[m - 1]) <= pull(way, k, after, out.w[m - 1])
        out.x[m] = ex[e + 1] if stays else min(ex[e + 1], until)
        out.w[m] = w_on(ex, ew, e, out.x[m])
        out.regime[m - 1] = own
        m += 1
    return m, e


@part
def _target(plan, planned, c, regime, w):
    """Squared speed at which the plan's next hold begins, if a train comes to it from where the run does."""
    hold = c if plan[c, REGIME] == HOLDING else c + 1
    if hold < planned and plan[hold, REGIME] == HOLDING:
        from_above = plan[hold, FROM_ABOVE] > 0.0
        if from_above == (w > plan[hold, START_W]):
            return plan[hold, START_W]
        return 0.0 if from_above else math.inf
    return math.inf if regime == TRACTION else 0.0


@part
def drive(way, k, regime, until, target, out, m):
    """Append rows of a regime; returns their number, and whether the target is met; −1 where the train stalls."""
    x = out.x[m - 1]
    cell = Cell(x, until, until - x, way.cells.grade_n[k], way.cells.air[k], math.inf)
    last = m
    used, w, last = march(
        train_in(way, k), regime, 1.0, cell, cell.length_m, out.w[m - 1], target, Rows(out.x, out.w), m
    )
    if last < 0 or w <= 0.0:
        return -1, False
    for j in range(m, last):
        out.x[j] += x
    if used >= cell.length_m * (1.0 - 1e-12):
        out.x[last - 1] = until
    return last, w == target


@part
def _takes_over(way, run, n, k, other, now, x, w):
    """Whether the regime of the plan replaces the one in which a train is off its run: it brings the two together."""
    above = w > w_on(run.x, run.w, row_at(run.x, n, x), x)
    stronger = pull(way, k, other, w) - pull(way, k, now, w)
    return stronger < 0 if above else stronger > 0


@part
def _settled(way, k, run, i, row, at, out, first, m):
    """End rows, from ``first`` on, with the one that meets the run, if one does (`_meets`).

    Returns their number; −1 where one of them, or what is left of the run's row, asks for more effort than there is.
    """
    if row >= 0:
        joined = w_on(run.x, run.w, i, at)
        m = row
        if at - out.x[row - 1] > SAME_M:
            out.x[row] = at
            m = row + 1
        out.w[m - 1] = joined
    for j in range(first, m):
        if not is_feasible(way, k, out.x[j] - out.x[j - 1], out.w[j - 1], out.w[j]):
            return -1
    if row >= 0:
        rest_m = run.x[i + 1] - out.x[m - 1]
        if rest_m > SAME_M and not is_feasible(way, k, rest_m, out.w[m - 1], run.w[i + 1]):
            return -1
    return m


@part
def leave(way, run, n, i, plan, planned, c, out, m):
    """Drive off a run from the end of the new rows, until the two meet again.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows; the row ``i`` holds the position.
    plan : (planned, PLAN_COLUMNS) float64
        Of which the phase ``c`` is in force.
    out : Run, modified in place
        Of ``m`` rows so far.

    Returns
    -------
    m : int
        Rows now; −1 where the two do not meet, or a row asks for more effort than there is.
    i : int
        Row of the run on which they meet.
    """
    cells = way.cells
    now = int(plan[c, REGIME])
    held = now == HOLDING
    rides = False
    left_m = -1.0  # where the envelope was left last
    changes = 0
    k = row_at(cells.station_m, cells.station_m.shape[0], out.x[m - 1])
    e = row_at(way.envelope.x, way.envelope.x.shape[0], out.x[m - 1])
    # Each turn appends a row of more than `SAME_M`, or gets onto the envelope or off it, once at each position.
    while out.x[m - 1] < cells.station_m[-1] - SAME_M:
        x = out.x[m - 1]
        w = out.w[m - 1]
        k = cell_from(cells, k, x)
        while c + 1 < planned and plan[c + 1, AT] <= x + SAME_M:
            c += 1
            changes += 1
        if changes > _MOST_CHANGES or m + _MOST_ROWS > out.x.shape[0]:
            return -1, i
        other = int(plan[c, REGIME])
        if other != now and _takes_over(way, run, n, k, other, now, x, w):
            if other == HOLDING and abs(w - plan[c, START_W]) > _NEAR_W * w:
                return -1, i
            now = other
            held = other == HOLDING and not rides
        until = cells.station_m[k + 1]  # a row ends wherever the line may change
        if c + 1 < planned:
            until = min(until, plan[c + 1, AT])
        first = m
        regime = HOLDING if held else now
        moves = -1 if held or rides else now
        rode = rides
        if rode:
            after = int(plan[min(c + 1, planned - 1), REGIME])
            m, e = _ride(way, k, e, now, after, until, out, m)
            rides = m > first
            if not rides:
                if out.x[m - 1] == left_m:  # neither on the envelope nor below it
                    return -1, i
                left_m = out.x[m - 1]
                held = now == HOLDING
                continue
        else:
            if held:
                out.x[m] = until
                out.w[m] = w
                m += 1
            else:
                m, held = drive(way, k, now, until, _target(plan, planned, c, now, w), out, m)
                if m < 0:
                    return -1, i
            m, e, rides = _clip(way, e, out, first, m)
            held = held and not rides
            for j in range(first, m):
                dark = regime == TRACTION and cells.supply[k] != POWERED
                out.regime[j - 1] = COASTING if dark else regime
        i, row, at = _meets(run, n, i, out, first, m, int(plan[c, REGIME]), moves, rode)
        m = _settled(way, k, run, i, row, at, out, first, m)
        if m < 0 or row >= 0:
            return m, i
    return -1, i
