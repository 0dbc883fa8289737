"""Drive a list of commands: rows, their regimes, times and energies, and where a hold had to end.

A command sets the regime from its position on. What follows by geometry is not commanded:

- a regime that brings the train to a speed that the multiplier holds, holds it, from the command's third number on;
- a run that meets the envelope rides it as long as the regime's effort is no less than what that takes.

Every run is feasible: where a hold is out of reach the regime that comes next to it takes over, and an event says so.
"""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.command import REGIME
from tgvdp.methods.extremal.drive import (
    CELL,
    COMMAND,
    COUNT,
    DRIVEN,
    EDGE,
    GOES_ON,
    HAPPENED,
    MODE,
    NO_ROOM,
    ON_CURVE,
    STALLS,
    Drive,
    begin,
    stretch,
    taken,
    tell,
)
from tgvdp.methods.extremal.ride import along_envelope
from tgvdp.methods.extremal.rows import ENVELOPE, is_anchor
from tgvdp.physics.cell import Cell
from tgvdp.physics.cell import Rows as PlainRows
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.physics.forces import effort_at, resistance_at
from tgvdp.physics.march import march
from tgvdp.physics.motion import net_force_at

_SAME_W = 1e-12
#: Rows that a stretch may take.
_MOST_ROWS = 4096


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


@part
def _hold(train, course, levels, until, drive):
    """Hold a speed up to a place, or say which regime takes over where it cannot be held."""
    now, rows = drive.now, drive.rows
    x = drive.place[0]
    w = drive.place[1]
    k = now[CELL]
    mode = now[MODE]
    n = now[COUNT]
    v = math.sqrt(w)
    load = resistance_at(train, course.air[k], v) + course.grade[k]
    held = levels[k, 0 if mode == HOLDING else mode - RETARDED + 1]
    other = _hold_regime(train, load, v, mode)
    if abs(w - held) > ON_CURVE * held:  # another cell holds another speed
        other = TRACTION if w < held else COASTING
    if other >= 0:
        tell(drive, other, x, 0.0)
        now[MODE] = other
        now[DRIVEN] = other
        return
    rows.x[n] = until
    rows.w[n] = w
    rows.regime[n] = mode
    rows.cell[n] = k
    if taken(train, course, n, n + 1, drive):
        e = now[EDGE]
        if course.effort[e] < 0.0 and course.w[e + 1] < course.w[e] and mode == HOLDING:
            tell(drive, COASTING, drive.place[0], drive.place[1])
        now[MODE] = ENVELOPE


@leaf
def _too_slow(train, course, least, first, end, drive):
    """The first of rows first … end − 1 that is too slow for what follows, ``end`` if none is."""
    rows = drive.rows
    for j in range(first, end):
        if rows.w[j] <= least or rows.w[j] < _slowest(train, course, drive.now[CELL], rows.x[j]):
            return j
    return end


@part
def _free(train, course, levels, commands, until, enabled, drive):
    """Drive a regime to a place, to a speed that it may hold, or to the envelope; returns how that ends."""
    now, rows = drive.now, drive.rows
    x = drive.place[0]
    w = drive.place[1]
    k = now[CELL]
    regime = now[DRIVEN]
    first = now[COUNT]
    v = math.sqrt(w)
    load = resistance_at(train, course.air[k], v) + course.grade[k]
    least = min(course.least_w, 0.5 * w)
    target = math.inf if regime == TRACTION else least
    level = 0
    if enabled:
        brake = effort_at(train.braking, v)
        aim, level = _target(regime, load, brake, w, levels[k, 0], levels[k, 1], levels[k, 2])
        if level > 0:
            target = aim
    here = Cell(0.0, until - x, until - x, course.grade[k], course.air[k], math.inf)
    used, w, m = march(train, regime, 1.0, here, until - x, w, target, PlainRows(rows.x, rows.w), first)
    if m < 0:
        return NO_ROOM
    for j in range(first, m):
        rows.x[j] += x
        rows.regime[j] = regime
        rows.cell[j] = k
    if used >= (until - x) * (1.0 - 1e-12):
        rows.x[m - 1] = until
    if regime == TRACTION:
        if w <= 0.0:
            return STALLS
    else:
        slow = _too_slow(train, course, least, first, m, drive)
        if slow < m:
            if slow == first and rows.x[slow] - x < 1e-3 and rows.w[slow] <= 0.0:
                return STALLS
            m = slow + 1 if rows.w[slow] > 0.0 else slow
            level = 0
            tell(drive, TRACTION, rows.x[m - 1], 0.0)
            now[DRIVEN] = TRACTION
            now[MODE] = TRACTION
    if taken(train, course, first, m, drive):
        now[MODE] = ENVELOPE
        now[DRIVEN] = int(commands[now[COMMAND], REGIME])
    elif level > 0 and drive.place[1] == target:
        now[MODE] = level
    return GOES_ON


@part
def simulate(train, course, levels, commands, count, start_w, rows, work):
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
    work : Work, modified in place
        ``starts`` get the row at whose start each command sets the regime, −1 of a command that was never reached;
        ``events`` the regimes that took over without a command, and where.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small, −2 when the train stalls.
    happened : int
        Number of events.
    """
    drive = Drive(work.place, work.now, rows, work.starts, work.events)
    now = drive.now
    begin(course, commands, start_w, drive)
    turns = 0
    ends = GOES_ON
    while drive.place[0] < course.station_m[-1]:
        turns += 1
        if now[COUNT] + _MOST_ROWS > rows.x.shape[0] or turns > rows.x.shape[0]:
            return NO_ROOM, now[HAPPENED]
        until, enabled = stretch(course, commands, count, drive)
        if now[MODE] == ENVELOPE:
            ends = along_envelope(train, course, levels, until, enabled, drive)
        elif is_anchor(now[MODE]):
            _hold(train, course, levels, until, drive)
        else:
            ends = _free(train, course, levels, commands, until, enabled, drive)
        if ends != GOES_ON:
            return ends, now[HAPPENED]
    return now[COUNT], now[HAPPENED]
