"""Commands from the rows of a run: its regimes, told from efforts and speeds with generous tolerances."""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.command import HOLDS_FROM, REGIME, write_command
from tgvdp.methods.extremal.rows import ENVELOPE, effort_of, is_anchor
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.physics.forces import effort_at

#: Shares of w within which a run is on the envelope, and at a held speed; efforts that are partial, of their limit.
_ON_ENVELOPE = 2e-4
_HELD = 1.5e-2
_LITTLE = 0.02
_NEARLY_ALL = 0.9
#: A run has crossed a held speed when w has passed it by this share.
_CROSSED = 8e-3
#: Shares of the starting effort beyond which a ride of the envelope takes effort.
_EFFORT_TO_STAY = 0.004
#: Label of a row that rides the envelope at its start and coasts off it.
_RIDES = 9


@part
def _label(train, course, k, e, x0, x1, w0, w1, levels):
    """Regime of a row; e is the envelope's row at its start."""
    ex = course.x_m
    ew = course.w
    while e < ex.shape[0] - 2 and ex[e + 1] <= x0 + 1e-9:
        e += 1
    on0 = ew[e] + (ew[e + 1] - ew[e]) * (x0 - ex[e]) / (ex[e + 1] - ex[e])
    i = e
    while i < ex.shape[0] - 2 and ex[i + 1] < x1 - 1e-9:
        i += 1
    on1 = ew[i] + (ew[i + 1] - ew[i]) * (x1 - ex[i]) / (ex[i + 1] - ex[i])
    d = x1 - x0
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    grade = course.grade[k]
    air = course.air[k]
    effort = duration_and_work(train, d, grade, air, w0, w1)[1] / d
    v = 0.5 * (v0 + v1)
    most = effort_of(train, TRACTION, grade, air, v)
    if w0 >= on0 * (1.0 - _ON_ENVELOPE) and w1 >= on1 * (1.0 - _ON_ENVELOPE):
        return (TRACTION if effort > 0.97 * most else ENVELOPE), e, effort
    w = 0.5 * (w0 + w1)
    gain = abs(w1 - w0) * 0.5 / d
    if effort > 0.0:
        steady = _LITTLE * most < effort < _NEARLY_ALL * most
        if steady and abs(w - levels[k, 0]) < _HELD * 2.0 * levels[k, 0]:
            return HOLDING, e, effort
        if steady and gain < 0.4 * effort and abs(w1 - w0) < 2e-3 * w:
            return HOLDING, e, effort
        if w0 >= on0 * (1.0 - 0.1 * _ON_ENVELOPE) and course.effort[e] > 0.0 and effort > 0.05 * course.effort[e]:
            return _RIDES, e, min(effort / course.effort[e], 1.0)
        return (TRACTION if effort > 0.5 * most else COASTING), e, effort
    brake = effort_at(train.braking, v)
    if course.returned > 0.0 and brake > 0.0:
        steady = _LITTLE * brake < -effort < _NEARLY_ALL * brake
        if steady and abs(w - levels[k, 1]) < _HELD * 2.0 * levels[k, 1]:
            return RETARDED, e, effort
        if steady and gain < -0.4 * effort and abs(w1 - w0) < 2e-3 * w:
            return RETARDED, e, effort
        if -effort > 1.02 * brake and abs(w1 - w0) < 2e-3 * w:
            return HELD_BACK, e, effort
        return (DYNAMIC if -effort > 0.5 * brake else COASTING), e, effort
    return COASTING, e, effort


@part
def _merge(phases, count, at):
    """Make phases ``at`` and ``at`` + 1 one, in the first; returns their number."""
    phases[at, 2] = phases[at + 1, 2]
    phases[at, 3] += phases[at + 1, 3]
    for i in range(at + 1, count - 1):
        for column in range(phases.shape[1]):
            phases[i, column] = phases[i + 1, column]
    return count - 1


@part
def _absorb(phases, count, short_s):
    """Let phases that are shorter than ``short_s`` go into their longer neighbours."""
    while count > 1:
        least = 0
        for i in range(1, count):
            if phases[i, 3] < phases[least, 3]:
                least = i
        if phases[least, 3] >= short_s:
            break
        into = least - 1 if least > 0 else least + 1
        if 0 < least < count - 1:
            before = phases[least - 1, 3] * (0.01 if phases[least - 1, 0] == ENVELOPE else 1.0)
            after = phases[least + 1, 3] * (0.01 if phases[least + 1, 0] == ENVELOPE else 1.0)
            into = least - 1 if before >= after else least + 1
        phases[least, 0] = phases[into, 0]
        count = _merge(phases, count, min(least, into))
        i = 1
        while i < count:
            if phases[i, 0] == phases[i - 1, 0]:
                count = _merge(phases, count, i - 1)
            else:
                i += 1
    return count


@part
def _smooth(phases, count, w, cell, levels):
    """Let what departs from a held speed by little be part of the hold."""
    i = 1
    while i < count:
        if phases[i, 0] == HOLDING and i >= 2 and phases[i - 2, 0] == HOLDING and phases[i - 1, 0] != ENVELOPE:
            near = True
            for j in range(int(phases[i - 1, 1]), int(phases[i - 1, 2]) + 1):
                near &= abs(w[j] / levels[cell[max(j, 1)], 0] - 1.0) < 2.0 * _HELD
            if near:
                count = _merge(phases, count, i - 2)
                count = _merge(phases, count, i - 2)
                i -= 2
        i += 1
    return count


@part
def _holds_from(x, w, cell, first, last, levels, column, sign):
    """From where a phase that ends in a hold may hold: after it last left the level on the other side."""
    from_m = -1.0
    for j in range(first, last + 1):
        k = cell[max(j, 1)]
        if sign * (w[j] / levels[k, column] - 1.0) > _CROSSED:
            from_m = x[j]
    return from_m


@part
def _add(phases, count, kind, row, from_m, duration):
    """Let a row, or what is behind a position in it, be of a phase; returns their number, −1 when they are too many."""
    if count == 0 or phases[count - 1, 0] != kind:
        if count >= phases.shape[0]:
            return -1
        phases[count, 0] = kind
        phases[count, 1] = row - 1
        phases[count, 3] = 0.0
        phases[count, 4] = from_m
        count += 1
    phases[count - 1, 2] = row
    phases[count - 1, 3] += duration
    return count


@part
def _phases(train, course, levels, x, w, n, cell, phases):
    """Phases of a run, and the cells that its rows end in; returns their number, −1 when there are too many."""
    k = 0
    e = 0
    count = 0
    last_cell = course.grade.shape[0] - 1
    cell[0] = 0
    for j in range(1, n):
        middle = 0.5 * (x[j - 1] + x[j])
        while k < last_cell and course.station_m[k + 1] <= middle:
            k += 1
        cell[j] = k
        label, e, effort = _label(train, course, k, e, x[j - 1], x[j], w[j - 1], w[j], levels)
        duration = 2.0 * (x[j] - x[j - 1]) / (math.sqrt(w[j]) + math.sqrt(w[j - 1]))
        if label == _RIDES:
            count = _add(phases, count, TRACTION, j, x[j - 1], effort * duration)
            if count > 0:
                off_m = x[j - 1] + effort * (x[j] - x[j - 1])
                count = _add(phases, count, COASTING, j, off_m, (1.0 - effort) * duration)
        else:
            count = _add(phases, count, label, j, x[j - 1], duration)
        if count < 0:
            return count
    return count


@part
def _may_hold(levels, x, w, cell, label, first, last, at_m, after):
    """From where on the regime of a phase may turn into a hold; infinite where it may not."""
    from_m = at_m
    if label == TRACTION and w[first] < levels[cell[first + 1], 0] * (1.0 + _CROSSED):
        over = _holds_from(x, w, cell, first, last, levels, 0, 1.0)
        if over >= 0.0:
            from_m = over if after == HOLDING else math.inf
    elif label == COASTING and after != HOLDING and after != RETARDED:
        if w[first] > levels[cell[first + 1], 0] * (1.0 - _CROSSED):
            under = _holds_from(x, w, cell, first, last, levels, 0, -1.0)
            if under >= 0.0:
                from_m = math.inf
        if w[first] < levels[cell[first + 1], 1]:
            over = _holds_from(x, w, cell, first, last, levels, 1, 1.0)
            if over >= 0.0:
                from_m = math.inf
    return from_m


@part
def _off_envelope(train, course, x, w, cell, first, last):
    """Row of a ride of the envelope from which on it takes effort; −1 if none."""
    start = effort_at(train.traction, 0.0)
    for j in range(first, last):
        d = x[j + 1] - x[j]
        k = cell[j + 1]
        effort = duration_and_work(train, d, course.grade[k], course.air[k], w[j], w[j + 1])[1] / d
        if effort > _EFFORT_TO_STAY * start:
            return j
    return -1


@kernel
def extract(train, course, levels, x, w, n, short_s, cell, phases, commands):
    """Commands from the rows of a run.

    Parameters
    ----------
    train, course, levels
        As of `simulate`.
    x, w : (n,) float64
    n : int
    short_s : float
        Phases shorter than this, s, are absorbed.
    cell : (size,) int64, scratch
    phases : (size, 5) float64, scratch
        Regime, first and last row, duration, position of its start.
    commands : (size, COMMAND_COLUMNS) float64, modified in place

    Returns
    -------
    count : int
        Number of commands; −1 when there are too many.
    """
    count = _phases(train, course, levels, x, w, n, cell, phases)
    if count < 0:
        return -1
    count = _smooth(phases, count, w, cell, levels)
    count = _absorb(phases, count, short_s)
    count = _smooth(phases, count, w, cell, levels)
    m = write_command(commands, 0, TRACTION, 0.0, 0.0)
    for i in range(count):
        label = int(phases[i, 0])
        first = int(phases[i, 1])
        last = int(phases[i, 2])
        if m + 2 > commands.shape[0]:
            return -1
        now = int(commands[m - 1, REGIME])
        if not is_anchor(label):
            after = int(phases[i + 1, 0]) if i + 1 < count else -1
            before = int(phases[i - 1, 0]) if i > 0 else -1
            at_m = phases[i, 4]
            from_m = _may_hold(levels, x, w, cell, label, first, last, at_m, after)
            if label != now or not (i == 0 or before in (ENVELOPE, label)):
                m = write_command(commands, m, label, at_m, from_m)
            elif from_m != at_m:
                commands[m - 1, HOLDS_FROM] = from_m
        elif label == ENVELOPE and now != TRACTION:
            # What coasts or brakes leaves the envelope where that needs effort: to stay takes traction.
            row = _off_envelope(train, course, x, w, cell, first, last)
            if row >= 0:
                m = write_command(commands, m, TRACTION, x[row], x[row])
        elif label == HOLDING and now != TRACTION:
            # What coasts holds a speed that it falls to; to one that it has fallen below it takes traction.
            under = w[first] < levels[cell[first + 1], 0]
            if under or now == DYNAMIC:
                m = write_command(commands, m, TRACTION if under else COASTING, x[first], x[first])
    if commands[m - 1, REGIME] != TRACTION:
        commands[m - 1, HOLDS_FROM] = math.inf
    return m
