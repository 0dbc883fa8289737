"""Keep commands near a run that they were told from: no error of a guess grows along the line.

Where the train leaves a band around the run, the regime below or above the one in force is commanded from where the
two were last the same.
"""

import numpy as np

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.command import AT, HOLDS_FROM, REGIME, copy_command, write_command
from tgvdp.methods.extremal.rows import ENVELOPE
from tgvdp.methods.extremal.simulate import simulate
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION

#: Two runs are the same within this share of w, ...
_SAME = 3e-3
#: ... and of the greatest: near standstill rows are coarse.
_FLOOR = 1e-3
#: Commands are no nearer to each other.
_APART_M = 1e-3
_MOST_RUNS = 60


@part
def _leaves(x, w, n, rows, count, from_m, band, least_w):
    """Where a run was last the same as another, and where it leaves the band around that; infinitely far if nowhere.

    With the row in which it does, and whether to the upper side.
    """
    i = 1
    j = 1
    at = 0.0
    apart = 0.0
    narrow = 0.0
    top = 0.0
    same_m = 0.0
    while i < n and j < count:
        before = at
        apart_before = apart
        narrow_before = narrow
        top_before = top
        at = min(x[i], rows.x[j])
        top = w[i - 1] + (w[i] - w[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1])
        mine = rows.w[j]
        if rows.x[j] > at:
            mine = rows.w[j - 1] + (rows.w[j] - rows.w[j - 1]) * (at - rows.x[j - 1]) / (rows.x[j] - rows.x[j - 1])
        apart = mine - top
        narrow = _SAME * top + _SAME * least_w
        if abs(apart) <= narrow:
            same_m = at
        elif apart * apart_before < 0.0:
            same_m = before + (at - before) * apart_before / (apart_before - apart)
        elif abs(apart_before) <= narrow_before and at > before:
            excess = abs(apart_before) - narrow_before
            same_m = before + (at - before) * excess / (excess - (abs(apart) - narrow))
        wide = band * top + least_w
        if at > from_m and abs(apart) > wide and abs(apart) * top_before >= abs(apart_before) * top:
            excess = abs(apart_before) - wide
            share = excess / (excess - (abs(apart) - wide)) if excess < 0.0 else 0.0
            return same_m, max(before + (at - before) * share, from_m), j, apart > 0.0
        if x[i] <= at:
            i += 1
        if rows.x[j] <= at:
            j += 1
    return same_m, np.inf, -1, False


@part
def _other(regime, now, above, returned):
    """The regime below or above one; −1 where there is none."""
    if regime == ENVELOPE:
        regime = now
    if above:
        if regime in (TRACTION, HOLDING):
            return COASTING
        return DYNAMIC if returned > 0.0 and regime in (COASTING, RETARDED) else -1
    if regime in (DYNAMIC, RETARDED, HELD_BACK):
        return COASTING
    return TRACTION if regime != TRACTION else -1


@part
def _insert(commands, count, at, regime, from_m):
    """Insert a command; returns the number of all."""
    for i in range(count, at, -1):
        copy_command(commands, i - 1, commands, i)
    write_command(commands, at, regime, from_m, from_m)
    return count + 1


@kernel
def follow_run(train, course, levels, x, w, n, band, start_w, work, commands, count):
    """Add commands until a run stays within a band of squared speed around another.

    Parameters
    ----------
    train, course, levels, start_w
        As of `simulate`.
    x, w : (n,) float64
        Positions and squared speeds of the run to follow.
    n : int
    band : float
        As a share of w.
    work : Work, scratch
    commands : (size, COMMAND_COLUMNS) float64, modified in place
    count : int

    Returns
    -------
    count : int
        Number of commands.
    runs : int
    """
    least_w = 0.0
    for i in range(n):
        least_w = max(least_w, _FLOOR * w[i])
    rows = work.whole
    from_m = 0.0
    runs = 0
    while count < commands.shape[0] - 1 and runs < _MOST_RUNS:
        size, _ = simulate(train, course, levels, commands, count, start_w, rows, work)
        runs += 1
        if size <= 0:
            break
        other = -1
        j = 1
        c = 0
        while j >= 0 and other < 0:
            same_m, out_m, j, above = _leaves(x, w, n, rows, size, from_m, band, least_w)
            if j >= 0:
                from_m = max(rows.x[j], from_m)
                while c + 1 < count and commands[c + 1, AT] <= out_m:
                    c += 1
                other = _other(rows.regime[j], int(commands[c, REGIME]), above, course.returned)
        if j < 0:
            break
        last_m = commands[c, AT]
        if rows.regime[j] == HOLDING and other == int(commands[c, REGIME]):
            begins = j
            while begins > 1 and rows.regime[begins - 1] == HOLDING:
                begins -= 1
            if rows.x[begins - 1] > last_m and commands[c, HOLDS_FROM] < rows.x[begins - 1]:
                commands[c, HOLDS_FROM] = rows.x[begins - 1] + _APART_M  # passes what it might hold
                from_m = last_m
                continue
        from_m = same_m if same_m > last_m + _APART_M else out_m
        count = _insert(commands, count, c + 1, other, from_m)
    return count, runs
