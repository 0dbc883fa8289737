"""Rows of a run as a profile keeps them: none that are too short to drive, and those of the envelope whole."""

import math

import numpy as np

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.rows import ENVELOPE
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.forces import effort_at, mean_brake, mean_effort, mean_resistance

#: Rows shorter than this share of the distance are none, ...
_SLIVER = 1e-9
#: ... and rows shorter than this share of the one before, at an effort that differs by less than this share.
_SHORT_ROW = 0.05
_SAME_EFFORT = 0.01


@part
def _is_in(x_m, x):
    """Whether a position is one of increasing ones."""
    at = np.searchsorted(x_m, x)
    return at < x_m.shape[0] and x_m[at] == x


@part
def _excess(train, grade, air, d, w0, w1, little):
    """Share by which a row passes the mean of its effort limit, or comfort."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    gain = 0.5 * (w1 - w0) / d
    effort = duration_and_work(train, d, grade, air, w0, w1)[1] / d
    if effort > little:
        return max(gain / train.max_acceleration, effort / mean_effort(train.traction, v0, v1)) - 1.0
    if effort < -little:
        load = mean_resistance(train, air, v0, v1) + grade
        return max(-gain / train.max_deceleration, -effort / max(mean_brake(train, load, v0, v1), little)) - 1.0
    return -1.0


@kernel
def thin(train, course, rows, n, x, w, regime, fixed):
    """Rows of a run that a profile keeps.

    Left out are rows that are too short, but not at breaks of the line. Commands that change nothing cut rows of the
    envelope, whose efforts are right as means alone: these are whole. Runs join the envelope within one of its rows,
    and what is left of it, at the same effort, is part of the row before.

    Parameters
    ----------
    train, course
    rows : Rows
        Of ``n`` rows.
    x, w : (size,) float64, modified in place
        Positions and squared speeds.
    regime : (size,) int8, modified in place
        Regime along each row, at its start.
    fixed : (size,) int64, scratch

    Returns
    -------
    count : int
        Number of positions.
    excess : float
        Largest share by which a row passes its effort limit, or comfort.
    """
    sliver_m = _SLIVER * course.station_m[-1]
    kept = fixed[n:]  # indices
    count = 0
    for j in range(n):
        fixed[j] = j == 0 or j == n - 1 or _is_in(course.station_m, rows.x[j])
        rides = j < n - 1 and rows.regime[j] == ENVELOPE and rows.regime[j + 1] == ENVELOPE
        if rides and not fixed[j] and not _is_in(course.x_m, rows.x[j]):
            continue
        if count > 0 and rows.x[j] - rows.x[kept[count - 1]] < sliver_m:
            if not fixed[j]:
                continue
            if not fixed[kept[count - 1]]:
                count -= 1
        kept[count] = j
        count += 1
    size = 0
    excess = 0.0
    little = 1e-3 * effort_at(train.traction, 0.0)
    whole = True
    for i in range(count):
        j = kept[i]
        if 0 < i < count - 1 and whole and not fixed[j]:
            before = kept[i - 1]
            after = kept[i + 1]
            short = rows.x[after] - rows.x[j] < _SHORT_ROW * (rows.x[j] - rows.x[before])
            whole = not (short and abs(rows.effort[after] - rows.effort[j]) < _SAME_EFFORT * abs(rows.effort[j]))
            if not whole:
                continue
        whole = True
        x[size] = rows.x[j]
        w[size] = rows.w[j]
        if size > 0:
            k = rows.cell[j]
            regime[size - 1] = rows.regime[j]
            excess = max(
                excess,
                _excess(train, course.grade[k], course.air[k], x[size] - x[size - 1], w[size - 1], w[size], little),
            )
        size += 1
    return size, excess
