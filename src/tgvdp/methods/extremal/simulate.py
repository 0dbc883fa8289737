"""Drive a list of commands: rows, their regimes, times and energies, and where a hold had to end.

A command sets the regime from its position on. What follows by geometry is not commanded:

- a regime that brings the train to a speed that the multiplier holds, holds it, from the command's third number on;
- a run that meets the envelope rides it as long as the regime's effort is no less than what that takes.

Every run is feasible: where a hold is out of reach the regime that comes next to it takes over, and an event says so.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.command import AT, HOLDS_FROM, REGIME
from tgvdp.methods.extremal.course import account
from tgvdp.physics.cell import Cell
from tgvdp.physics.cell import Rows as PlainRows
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.physics.forces import effort_at, resistance_at
from tgvdp.physics.motion import march, net_force_at

#: Regime of rows on the envelope, besides those of `physics.codes`.
ENVELOPE = 8
#: Columns of an event, (n, 3): the regime that took over, where, and w if that was on the envelope, else 0.
MOST_EVENTS = 64

_SAME_M = 1e-9
_SAME_W = 1e-12
_ON_CURVE = 1e-9
#: An effort that exceeds the regime's by less than this (m/s²) is the regime's own.
_SAME_EFFORT = 1e-7
#: ... or, under the dynamic brake, by this share: the envelope's efforts are means of rows.
_SAME_BRAKE = 5e-3
#: Slopes that differ by less than this share are of the same effort, until w differs by this share.
_ALONG = 0.02
_ALONG_W = 2e-5
_MOST_ROWS = 4096


class Rows(NamedTuple):
    """Rows of a run, (size,) each: position, squared speed, time and energy since the start; of the row that ends
    there: regime, cell and mean effort.
    """

    x: NDArray[np.float64]
    w: NDArray[np.float64]
    time: NDArray[np.float64]
    energy: NDArray[np.float64]
    effort: NDArray[np.float64]
    regime: NDArray[np.int64]
    cell: NDArray[np.int64]


def rows_of(size: int) -> Rows:
    """Room for the rows of a run."""
    return Rows(*np.empty((5, size)), *np.zeros((2, size), dtype=np.int64))


@leaf
def is_anchor(regime):
    """Whether a run that meets a row of a regime goes on as that row does: on a held speed, or on the envelope."""
    return regime == HOLDING or regime >= RETARDED


@part
def effort_of(train, regime, grade, air, v):
    """Effort of a regime at a speed, comfort limits included."""
    net = net_force_at(train, regime, Cell(0.0, 0.0, 0.0, grade, air, math.inf), v)
    return net + resistance_at(train, air, v) + grade


@part
def _clip(course, e, xs, ws, first, n, tol):
    """Cut rows first … n − 1 where they pass above the envelope; returns n, its row, and whether they do."""
    ex = course.x_m
    ew = course.w
    last = ex.shape[0] - 2
    for j in range(first, n):
        x0 = xs[j - 1]
        w0 = ws[j - 1]
        x1 = xs[j]
        slope = (ws[j] - w0) / (x1 - x0) if x1 > x0 else 0.0
        xa = x0
        while True:
            while e < last and ex[e + 1] <= xa:
                e += 1
            xb = min(x1, ex[e + 1])
            es = (ew[e + 1] - ew[e]) / (ex[e + 1] - ex[e])
            fb = w0 + slope * (xb - x0) - (ew[e] + es * (xb - ex[e]))
            # What runs along the envelope at the same effort joins it where that changes: not within one of its rows.
            along = es != 0.0 and abs(slope - es) < _ALONG * abs(es)
            if fb > (_ALONG_W if along else tol) * ew[e]:
                fa = w0 + slope * (xa - x0) - (ew[e] + es * (xa - ex[e]))
                xh = xa if fa >= 0.0 else xa + (xb - xa) * (-fa) / (fb - fa)
                xs[j] = xh
                ws[j] = ew[e] + es * (xh - ex[e])
                return (j if xh <= x0 + _SAME_M else j + 1), e, True
            if xb >= x1:
                break
            xa = xb
    return n, e, False


@part
def _account(train, returned, grade, air, rows, first, n):
    """Time, energy and effort of rows first … n − 1."""
    for j in range(first, n):
        d = rows.x[j] - rows.x[j - 1]
        duration, energy, rows.effort[j] = account(train, returned, grade, air, d, rows.w[j - 1], rows.w[j])
        rows.time[j] = rows.time[j - 1] + duration
        rows.energy[j] = rows.energy[j - 1] + energy


@leaf
def _hold_regime(train, load, v, level):
    """Regime that takes over where a level cannot be held under a load; negative where it can."""
    if level == HOLDING:
        if load < 0.0:
            return COASTING
        return TRACTION if load > effort_at(train.traction, v) else -1
    brake = effort_at(train.braking, v)
    if level == RETARDED:
        if load > 0.0:
            return COASTING
        return DYNAMIC if -load > brake else -1
    return DYNAMIC if -load < brake else -1


@leaf
def _target(regime, load, brake, w, pulled, retarded, braked):
    """Squared speed that a regime brings the train to and may hold there, and by what; none is (−1, 0)."""
    if regime == TRACTION:
        if w < pulled * (1.0 - _SAME_W):
            return pulled, HOLDING
    elif regime == COASTING:
        if load > 0.0:
            if w > pulled * (1.0 + _SAME_W):
                return pulled, HOLDING
        elif w < retarded * (1.0 - _SAME_W):
            return retarded, RETARDED
    elif -load <= brake:
        if load <= 0.0 and w > retarded * (1.0 + _SAME_W):
            return retarded, RETARDED
    elif w < braked * (1.0 - _SAME_W):
        return braked, HELD_BACK
    return -1.0, 0


@leaf
def _slowest(train, course, k, x):
    """Squared speed below which full traction might not carry the train over what follows cell k."""
    low = course.low[k + 1]
    if low <= 0.0:
        return 0.0
    v = math.sqrt(low)
    cell = Cell(0.0, 0.0, 0.0, course.grade[k], course.air[k], math.inf)
    return low - 2.0 * net_force_at(train, TRACTION, cell, v) * (course.station_m[k + 1] - x)


@leaf
def _rides(train, course, regime, grade, air, e, w):
    """Whether a run that is on the envelope's row e follows it under a regime."""
    if regime == TRACTION:
        return True
    if regime == COASTING:
        return course.effort[e] <= _SAME_EFFORT
    if course.effort[e] > 0.0:
        return False
    own = effort_of(train, regime, grade, air, math.sqrt(max(w, 1e-12)))
    return course.effort[e] <= own * (1.0 - _SAME_BRAKE) + _SAME_EFFORT


@part
def simulate(train, course, levels, commands, count, start_w, rows, starts, events):
    """Drive commands from the start to the end.

    Parameters
    ----------
    train : KernelTrain
        Per unit of inertia.
    course : Course
    levels : (K, 3) float64
        As of `held_speeds`.
    commands : (size, COMMAND_COLUMNS) float64
        ``count`` commands in order; the first starts at 0.
    count : int
    start_w : float
    rows : Rows, modified in place
    starts : (size,) int64, modified in place
        Row at whose start each command sets the regime; −1 of a command that was never reached.
    events : (MOST_EVENTS, 3) float64, modified in place
        Regimes that took over without a command, and where.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small, −2 when the train stalls.
    happened : int
        Number of events.
    """
    for i in range(count):
        starts[i] = -1
    starts[0] = 0
    c = 0
    regime = int(commands[0, REGIME])
    mode = ENVELOPE if start_w >= course.w[0] * (1.0 - _ON_CURVE) else regime
    station = course.station_m
    cells = station.shape[0] - 1
    end = station[cells]
    xs = rows.x
    ws = rows.w
    rows.time[0] = 0.0
    rows.energy[0] = 0.0
    rows.effort[0] = 0.0
    rows.regime[0] = ENVELOPE
    rows.cell[0] = 0
    n = 1
    x = 0.0
    w = start_w
    xs[0] = x
    ws[0] = w
    k = 0
    e = 0
    happened = 0
    turns = 0
    while x < end:
        turns += 1
        if n + _MOST_ROWS > xs.shape[0] or turns > xs.shape[0]:
            return -1, happened
        while k < cells - 1 and x >= station[k + 1] - _SAME_M:
            k += 1
        while c + 1 < count and x >= commands[c + 1, AT] - _SAME_M:
            c += 1
            starts[c] = n - 1
            regime = int(commands[c, REGIME])
            if mode != ENVELOPE:
                mode = regime
        grade = course.grade[k]
        air = course.air[k]
        until = station[k + 1]
        if c + 1 < count:
            until = min(until, max(commands[c + 1, AT], x + _SAME_M))
        enabled = x >= commands[c, HOLDS_FROM] - _SAME_M
        if not enabled:
            until = min(until, max(commands[c, HOLDS_FROM], x + _SAME_M))
        first = n
        if mode == ENVELOPE:
            while e < course.x_m.shape[0] - 2 and course.x_m[e + 1] <= x + _SAME_M:
                e += 1
            # As long as nothing can happen along its rows they are copied.
            top = levels[k, 0] if enabled and regime == TRACTION else math.inf
            while _rides(train, course, regime, grade, air, e, w):
                if not (e < course.x_m.shape[0] - 2 and x == course.x_m[e] and course.x_m[e + 1] <= until):
                    break
                if w < top < course.w[e + 1]:
                    break
                x = course.x_m[e + 1]
                w = course.w[e + 1]
                xs[n] = x
                ws[n] = w
                rows.regime[n] = ENVELOPE
                rows.cell[n] = k
                rows.time[n] = rows.time[n - 1] + course.duration[e]
                rows.energy[n] = rows.energy[n - 1] + course.energy[e]
                rows.effort[n] = course.effort[e]
                n += 1
                e += 1
                if n + 1 >= xs.shape[0]:
                    return -1, happened
            if n > first:
                continue
            if not _rides(train, course, regime, grade, air, e, w):
                mode = regime
                continue
            ex0 = course.x_m[e]
            ew0 = course.w[e]
            slope = (course.w[e + 1] - ew0) / (course.x_m[e + 1] - ex0)
            xb = min(course.x_m[e + 1], until)
            wb = course.w[e + 1]
            if course.x_m[e + 1] - xb >= _SAME_M:
                wb = max(ew0 + slope * (xb - ex0), 0.0)
            else:
                xb = max(course.x_m[e + 1], xb) if until - xb < _SAME_M else course.x_m[e + 1]
            pulled = levels[k, 0]
            if regime == TRACTION and enabled and w < pulled < wb and course.effort[e] > 0.0:
                xb = ex0 + (pulled - ew0) / slope
                wb = pulled
                mode = HOLDING
            if xb <= x:
                xb = x + 1e-10
            xs[n] = xb
            ws[n] = wb
            rows.regime[n] = ENVELOPE
            rows.cell[n] = k
            n += 1
            _account(train, course.returned, grade, air, rows, first, n)
            x = xb
            w = wb
            continue
        v = math.sqrt(w)
        load = resistance_at(train, air, v) + grade
        if is_anchor(mode):
            held = levels[k, 0 if mode == HOLDING else mode - RETARDED + 1]
            other = _hold_regime(train, load, v, mode)
            if abs(w - held) > _ON_CURVE * held:  # another cell holds another speed
                other = TRACTION if w < held else COASTING
            if other >= 0:
                if happened < events.shape[0]:
                    events[happened, 0] = other
                    events[happened, 1] = x
                    events[happened, 2] = 0.0
                    happened += 1
                mode = other
                regime = other
                continue
            xs[n] = until
            ws[n] = w
            rows.regime[n] = mode
            rows.cell[n] = k
            n, e, hit = _clip(course, e, xs, ws, first, n + 1, _ON_CURVE)
            _account(train, course.returned, grade, air, rows, first, n)
            x = xs[n - 1]
            w = ws[n - 1]
            if hit:
                braked = course.effort[e] < 0.0 and course.w[e + 1] < course.w[e]
                if braked and mode == HOLDING and happened < events.shape[0]:
                    events[happened, 0] = COASTING
                    events[happened, 1] = x
                    events[happened, 2] = w
                    happened += 1
                mode = ENVELOPE
            continue
        least = min(course.least_w, 0.5 * w)
        target = math.inf if regime == TRACTION else least
        level = 0
        if enabled:
            brake = effort_at(train.braking, v)
            aim, level = _target(regime, load, brake, w, levels[k, 0], levels[k, 1], levels[k, 2])
            if level > 0:
                target = aim
        here = Cell(0.0, until - x, until - x, grade, air, math.inf)
        used, w, m = march(train, regime, 1.0, here, until - x, w, target, PlainRows(xs, ws), n)
        if m < 0:
            return -1, happened
        for j in range(n, m):
            xs[j] += x
            rows.regime[j] = regime
            rows.cell[j] = k
        if used >= (until - x) * (1.0 - 1e-12):
            xs[m - 1] = until
        if regime != TRACTION:
            for j in range(n, m):
                if ws[j] <= least or ws[j] < _slowest(train, course, k, xs[j]):
                    if j == n and xs[j] - x < 1e-3 and ws[j] <= 0.0:
                        return -2, happened
                    m = j + 1 if ws[j] > 0.0 else j
                    level = 0
                    if happened < events.shape[0]:
                        events[happened, 0] = TRACTION
                        events[happened, 1] = xs[m - 1]
                        events[happened, 2] = 0.0
                        happened += 1
                    regime = TRACTION
                    mode = TRACTION
                    break
        elif w <= 0.0:
            return -2, happened
        n, e, hit = _clip(course, e, xs, ws, first, m, _ON_CURVE)
        _account(train, course.returned, grade, air, rows, first, n)
        x = xs[n - 1]
        w = ws[n - 1]
        if hit:
            mode = ENVELOPE
            regime = int(commands[c, REGIME])
        elif level > 0 and w == target:
            mode = level
    return n, happened
