"""Blocks: parts of a run between anchors, whose costs at one multiplier do not depend on each other.

A step of all switches at once is kept block by block, where it makes E + λT fall: one that is hard to bring to rest
does not hold up the others, and where it never comes to rest it is frozen.
"""

from tgvdp._jit import part
from tgvdp.methods.extremal.command import AT, HOLDS_FROM
from tgvdp.methods.extremal.course import account
from tgvdp.methods.extremal.switches import ACTIVE, FIXED, FLOW

#: Where w of two runs differs by a smaller share they are the same.
_SAME_W = 1e-7
#: Where a step at a multiplier raises the cost, so much of it is tried next, down to so much of it.
_SHRINK = 0.25
_LEAST_STEP = 2e-3


@part
def cost_at(train, course, price, rows, n, x):
    """E + λT from the start up to a position, and the squared speed there."""
    lo = 0
    hi = n - 1
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if rows.x[middle] <= x:
            lo = middle
        else:
            hi = middle
    d = rows.x[hi] - rows.x[lo]
    part_m = min(max(x - rows.x[lo], 0.0), d)
    cost = rows.energy[lo] + price * rows.time[lo]
    if part_m <= 0.0:
        return cost, rows.w[lo]
    if part_m >= d:
        return rows.energy[hi] + price * rows.time[hi], rows.w[hi]
    w = rows.w[lo] + (rows.w[hi] - rows.w[lo]) * part_m / d
    k = rows.cell[hi]
    duration, energy, _ = account(train, course.returned, course.grade[k], course.air[k], part_m, rows.w[lo], w)
    return cost + energy + price * duration, w


@part
def remember(rows, n, kept):
    """Keep the rows of a run."""
    for j in range(n):
        kept.x[j] = rows.x[j]
        kept.w[j] = rows.w[j]
        kept.time[j] = rows.time[j]
        kept.energy[j] = rows.energy[j]
        kept.cell[j] = rows.cell[j]


@part
def compare_blocks(train, course, price, commands, count, n, best_n, little, work):
    """Tell in which blocks a run is dearer than the best one, whose commands are as many: in ``work.dearer``.

    Those that are cheaper may take their next step whole.

    Returns
    -------
    better, worse : int
        Number of commands in blocks that differ and are no dearer, and in those that are.
    """
    first = 0
    here0 = 0.0
    best0 = 0.0
    better = 0
    worse = 0
    for i in range(1, count + 1):
        x = course.station_m[-1]
        if i < count:
            if work.found[i, ACTIVE] == 0.0 or work.found[i, FLOW] > 0.0:
                continue
            x = min(commands[i, AT], work.best[i, AT])
        here, w = cost_at(train, course, price, work.whole, n, x)
        best, best_w = cost_at(train, course, price, work.kept, best_n, x)
        if i < count and abs(w - best_w) > _SAME_W * best_w:
            continue
        dearer = (here - here0) - (best - best0) > little
        for c in range(first, i):
            moved = commands[c, AT] != work.best[c, AT]
            work.dearer[c] = dearer
            if dearer:
                worse += 1
            elif moved:
                better += 1
                work.shrink[c] = 1.0
        first = i
        here0 = here
        best0 = best
    return better, worse


@part
def refuse(commands, count, work, shorter):
    """Take the commands of the best run where ``work.dearer`` says so; there the next step is to be shorter."""
    for c in range(count):
        if work.dearer[c]:
            if work.pinned[c] == FIXED and commands[c, AT] != work.best[c, AT]:
                work.pinned[c] = 0
            commands[c, AT] = work.best[c, AT]
            commands[c, HOLDS_FROM] = work.best[c, HOLDS_FROM]
            if shorter:
                work.shrink[c] *= _SHRINK
                if work.shrink[c] < _LEAST_STEP:
                    work.shrink[c] = 0.0
    for c in range(1, count):
        commands[c, AT] = max(commands[c, AT], commands[c - 1, AT])


@part
def refuse_all(count, work):
    """Say that a run is dearer everywhere."""
    for c in range(count):
        work.dearer[c] = True
