"""Drive along the envelope, for as long as the regime is strong enough for it."""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.drive import CELL, COUNT, DRIVEN, EDGE, GOES_ON, MODE, NO_ROOM
from tgvdp.methods.extremal.rows import ENVELOPE, SAME_M, account_rows, effort_of
from tgvdp.physics.codes import COASTING, HOLDING, TRACTION

#: An effort that exceeds the regime's by less than this (m/s²) is the regime's own.
_SAME_EFFORT = 1e-7
#: ... or, under the dynamic brake, by this share: the envelope's efforts are means of rows.
_SAME_BRAKE = 5e-3


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
def _copy_envelope(train, course, top, until, drive):
    """Go on along rows of the envelope for as long as nothing can happen along them; False where room ends."""
    now, place, rows = drive.now, drive.place, drive.rows
    k = now[CELL]
    e = now[EDGE]
    n = now[COUNT]
    has_room = True
    while _rides(train, course, now[DRIVEN], course.grade[k], course.air[k], e, place[1]):
        if not (e < course.x_m.shape[0] - 2 and place[0] == course.x_m[e] and course.x_m[e + 1] <= until):
            break
        if place[1] < top < course.w[e + 1]:
            break
        place[0] = course.x_m[e + 1]
        place[1] = course.w[e + 1]
        rows.x[n] = place[0]
        rows.w[n] = place[1]
        rows.regime[n] = ENVELOPE
        rows.cell[n] = k
        rows.time[n] = rows.time[n - 1] + course.duration[e]
        rows.energy[n] = rows.energy[n - 1] + course.energy[e]
        rows.effort[n] = course.effort[e]
        n += 1
        e += 1
        has_room = n + 1 < rows.x.shape[0]
        if not has_room:
            break
    now[EDGE] = e
    now[COUNT] = n
    return has_room


@part
def _envelope_part(train, course, pulled, until, drive):
    """Go on along a part of a row of the envelope: to its end, to a place, or to the speed that is held from there."""
    now, place, rows = drive.now, drive.place, drive.rows
    k = now[CELL]
    e = now[EDGE]
    n = now[COUNT]
    slope = (course.w[e + 1] - course.w[e]) / (course.x_m[e + 1] - course.x_m[e])
    x = min(course.x_m[e + 1], until)
    w = course.w[e + 1]
    if course.x_m[e + 1] - x >= SAME_M:
        w = max(course.w[e] + slope * (x - course.x_m[e]), 0.0)
    else:
        x = max(course.x_m[e + 1], x) if until - x < SAME_M else course.x_m[e + 1]
    if now[DRIVEN] == TRACTION and place[1] < pulled < w and course.effort[e] > 0.0:
        x = course.x_m[e] + (pulled - course.w[e]) / slope
        w = pulled
        now[MODE] = HOLDING
    if x <= place[0]:
        x = place[0] + 1e-10
    rows.x[n] = x
    rows.w[n] = w
    rows.regime[n] = ENVELOPE
    rows.cell[n] = k
    account_rows(train, course.returned, course.grade[k], course.air[k], rows, n, n + 1)
    now[COUNT] = n + 1
    place[0] = x
    place[1] = w


@part
def along_envelope(train, course, levels, until, enabled, drive):
    """Go on along the envelope, or leave it where the regime is too weak for it; returns how that ends."""
    now, place = drive.now, drive.place
    k = now[CELL]
    while now[EDGE] < course.x_m.shape[0] - 2 and course.x_m[now[EDGE] + 1] <= place[0] + SAME_M:
        now[EDGE] += 1
    pulled = levels[k, 0] if enabled else math.inf
    first = now[COUNT]
    if not _copy_envelope(train, course, pulled if now[DRIVEN] == TRACTION else math.inf, until, drive):
        return NO_ROOM
    if now[COUNT] > first:
        return GOES_ON
    if _rides(train, course, now[DRIVEN], course.grade[k], course.air[k], now[EDGE], place[1]):
        _envelope_part(train, course, pulled, until, drive)
    else:
        now[MODE] = now[DRIVEN]
    return GOES_ON
