"""Pins: switches from which the run just touches the envelope, where the cost has a kink.

Below the touch the run passes, above it rides the envelope, and the derivative of the cost jumps. Where it changes its
sign the switch is pinned: no longer a zero of a derivative, but of the distance to the envelope.
"""

import math

import numpy as np

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.command import AT, HOLDS_FROM, REGIME
from tgvdp.methods.extremal.rows import ENVELOPE, effort_of
from tgvdp.methods.extremal.switches import ACTIVE, CURVATURE, FIXED, GAIN, JUMP, PINNED
from tgvdp.methods.extremal.terms import cost_of, flow_over, force_balance
from tgvdp.physics.codes import TRACTION
from tgvdp.physics.forces import effort_at

#: A pinned run passes below where it touches the envelope by this share of w, and may miss that by ...
_BELOW = 5e-10
_TOUCHES = 3e-9
#: A run grazes the envelope within this share of w, and passes below it beyond ...
_GRAZES = 1e-5
_PASSES = 1e-6
#: ... and is too slow at the end by more than ...
_SHORT = 1e-6
#: What is released to ride the envelope is pushed above it by this share.
_PUSH = 1e-6
#: Share of the distance within which a run leaves the envelope where it meets it.
_APART = 1e-7
_NOWHERE_M = 1e-6


@part
def _top(course, x):
    """Squared speed of the envelope at a position."""
    e = min(max(np.searchsorted(course.x_m, x) - 1, 0), course.x_m.shape[0] - 2)
    share = (x - course.x_m[e]) / (course.x_m[e + 1] - course.x_m[e])
    return course.w[e] + (course.w[e + 1] - course.w[e]) * min(max(share, 0.0), 1.0)


@part
def fix_corners(course, commands, count, reach_m, pinned):
    """Fix traction that begins near the end of a braking curve there: a run that touches it goes on along the limit."""
    for i in range(count):
        x = commands[i, AT]
        if i == 0 or commands[i, REGIME] != TRACTION or commands[i - 1, REGIME] == TRACTION:
            continue
        at = np.searchsorted(course.corner_m, x)
        for j in range(max(at - 1, 0), min(at + 1, course.corner_m.shape[0])):
            corner = course.corner_m[j]
            alone = commands[i - 1, AT] < corner and (i + 1 >= count or commands[i + 1, AT] > corner)
            if abs(corner - x) <= reach_m and alone:
                if commands[i, HOLDS_FROM] == x:
                    commands[i, HOLDS_FROM] = corner
                commands[i, AT] = corner
                pinned[i] = FIXED
                break


@part
def _ride(course, rows, n, first):
    """Where a run meets the envelope after a switch, where it leaves it again, and where it grazes it before.

    It rides it as long as it coasts or brakes. A run that passes below meets it nowhere, which is infinitely far, and
    comes nearest to it where it leaves it.
    """
    j = first + 1
    nearest = rows.x[first]
    grazes = math.inf
    least = math.inf
    last = math.inf
    falling = False
    while j < n and rows.regime[j] == rows.regime[first + 1]:
        gap = _top(course, rows.x[j]) / rows.w[j] - 1.0
        if falling and gap > last and last < _GRAZES:
            grazes = rows.x[j - 1]
        falling = gap < last
        last = gap
        if gap < least:
            least = gap
            nearest = rows.x[j]
        j += 1
    if j >= n or rows.regime[j] != ENVELOPE:
        return math.inf, nearest, min(grazes, nearest) if least < _GRAZES else grazes
    meets = rows.x[j - 1]
    while j < n and rows.regime[j] == ENVELOPE and rows.effort[j] <= 0.0:
        j += 1
    return meets, rows.x[j - 1], grazes


@part
def _miss(train, course, rows, n, first, at):
    """By how much w misses the envelope at a position after a switch, were that no wall; and the flow to there."""
    j = first
    flow = 1.0
    regime = rows.regime[first + 1]
    while j + 1 < n and rows.x[j + 1] <= at + 1e-9 and rows.regime[j + 1] == regime:
        j += 1
        w = max(0.5 * (rows.w[j - 1] + rows.w[j]), 1e-9)
        flow *= flow_over(train, course, rows.cell[j], regime, w, rows.x[j] - rows.x[j - 1])
    w = rows.w[j]
    x = rows.x[j]
    k = rows.cell[j]
    while x < at - 1e-9:
        while k < course.grade.shape[0] - 1 and course.station_m[k + 1] <= x + 1e-9:
            k += 1
        d = min(at, course.station_m[k + 1]) - x
        middle = w + d * force_balance(train, course, k, regime, w)
        flow *= flow_over(train, course, k, regime, max(middle, 1e-9), d)
        w += 2.0 * d * force_balance(train, course, k, regime, max(middle, 1e-9))
        x += d
    return _top(course, at) * (1.0 - _BELOW) - w, flow


@part
def _above(train, course, rows, n, i, work):
    """Derivative of the cost by a pinned switch where its run touches the envelope, from that where it does not."""
    at = work.touch[i]
    e = max(np.searchsorted(course.x_m, at - 1e-6) - 1, 0)
    j = np.searchsorted(rows.x[:n], at - 1e-6)
    v = math.sqrt(rows.w[j])
    own = effort_of(train, rows.regime[j], course.grade[rows.cell[j]], course.air[rows.cell[j]], v)
    gap = own - course.effort[e]
    if not gap > 0.0:
        return math.inf
    brake = effort_at(train.braking, v)
    p = -0.5 * (cost_of(own, brake, course.returned) - cost_of(course.effort[e], brake, course.returned)) / gap
    p -= work.p_at[j] + work.stepped_at[j]
    return work.found[i, GAIN] + 2.0 * work.found[i, JUMP] * work.flow_on[i] * p


@leaf
def touches(course, work, i):
    """Whether the run of a pinned switch touches the envelope."""
    return abs(work.miss[i]) < _TOUCHES * _top(course, work.touch[i])


@leaf
def is_short(course, rows, n):
    """Whether a run is slower at the end than it must be."""
    return rows.w[n - 1] < course.w[-1] * (1.0 - _SHORT)


@part
def _ends_short(course, count, rows, n, work):
    """The last switch if the run from it ends too slow, or must not end slower; −1 if there is none."""
    if course.w[-1] == 0.0:
        return -1
    last = count - 1
    while last > 0 and work.found[last, ACTIVE] == 0.0:
        last -= 1
    bound = work.pinned[last] == PINNED and work.touch[last] == course.x_m[-1]
    return last if last > 0 and (bound or is_short(course, rows, n)) else -1


@part
def pin(train, course, count, rows, n, work, turn):
    """Pin switches from which the run just touches the envelope.

    That is where it leaves the envelope as soon as it meets it, or would pass it by its next step, or where the
    derivative of the cost changes its sign as the run begins to meet it.

    Returns
    -------
    fresh, lost, touching : bool
        Whether any was not pinned before, or has come to nothing as its step went beyond, and whether all that are
        pinned touch the envelope.
    """
    touching = True
    fresh = False
    lost = False
    last = _ends_short(course, count, rows, n, work)
    for i in range(1, count):
        row = work.found[i]
        if i == last and work.pinned[i] < FIXED:
            fresh |= work.pinned[i] != PINNED or work.touch[i] != course.x_m[-1]
            work.pinned[i] = PINNED
            work.touch[i] = course.x_m[-1]
            work.miss[i], work.flow_on[i] = _miss(train, course, rows, n, work.starts[i], work.touch[i])
            touching &= touches(course, work, i)
            continue
        if row[ACTIVE] == 0.0 or work.pinned[i] >= FIXED or row[JUMP] < 0.0:
            if row[ACTIVE] == 0.0 and work.pinned[i] == 0 and work.gain[i] < 0.0 and work.meets[i] == math.inf:
                work.pinned[i] = PINNED
                work.touch[i] = work.leaves[i]
                lost = True
            work.gain[i] = 0.0
            continue
        pinned = work.pinned[i]
        meets, leaves, grazes = _ride(course, rows, n, work.starts[i])
        if work.pinned[i] == 0 and abs(meets - leaves) < _APART * course.x_m[-1]:
            work.pinned[i] = PINNED
            work.touch[i] = leaves
        elif work.pinned[i] == 0 and row[GAIN] < 0.0 and grazes < meets:
            work.pinned[i] = PINNED
            work.touch[i] = grazes
        elif work.pinned[i] == 0 and turn > 0 and work.gain[i] * row[GAIN] < 0.0:
            if leaves + _NOWHERE_M < work.meets[i] and meets < math.inf:
                work.pinned[i] = PINNED
                work.touch[i] = leaves
            elif work.leaves[i] + _NOWHERE_M < meets and work.meets[i] < math.inf:
                work.pinned[i] = PINNED
                work.touch[i] = work.leaves[i]
        fresh |= work.pinned[i] != pinned
        work.gain[i] = row[GAIN]
        work.meets[i] = meets
        work.leaves[i] = leaves
        if work.pinned[i] == PINNED:
            if work.touch[i] < 0.0:
                work.touch[i] = min(grazes, leaves)
            if work.touch[i] >= course.x_m[-1] and course.w[-1] == 0.0:
                work.pinned[i] = 0
                continue
            work.miss[i], work.flow_on[i] = _miss(train, course, rows, n, work.starts[i], work.touch[i])
            touching &= work.shrink[i] == 0.0 or touches(course, work, i)
    return fresh, lost, touching


@part
def release(train, course, count, rows, n, work, little):
    """Release switches that would gain by passing below the envelope or by riding it; returns whether any is."""
    released = False
    for i in range(1, count):
        row = work.found[i]
        work.push[i] = 0.0
        if row[ACTIVE] == 0.0:
            continue
        if work.pinned[i] == PINNED and work.meets[i] > work.touch[i]:
            rides = _above(train, course, rows, n, i, work) < 0.0
            passes = row[GAIN] > 0.0 and work.touch[i] < course.x_m[-1]  # at the end it would be too slow
            if passes or rides:
                work.pinned[i] = 0
                released = True
            if rides and row[GAIN] < 0.0:  # just so far that the next run does
                work.push[i] = 0.5 * _PUSH * _top(course, work.touch[i]) / (row[JUMP] * work.flow_on[i])
        elif work.pinned[i] == FIXED and 0.5 * row[GAIN] * row[GAIN] > little * row[CURVATURE]:
            j = work.starts[i]
            if rows.w[j] < _top(course, rows.x[j]) * (1.0 - _PASSES):
                work.pinned[i] = 0
                released = True
    return released
