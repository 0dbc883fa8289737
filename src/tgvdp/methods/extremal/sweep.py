"""Carry the costate back over a run, with its slope and the tangent flow: Newton's step in all switches at once.

Along a row of regime f, with the price a of its work (1 under traction, r under the dynamic brake),

    p' = λ/(2v³) + 2p·ρ_w − (a + 2p)·f_w,      q' = ∂p'/∂w − 4(f_w − ρ_w)·q,      φ' = 2(f_w − ρ_w)·φ

for p = ∂V/∂w, q = dp/dw and the flow φ = ∂w/∂w_before. Where a run joins an anchor, a held speed or the envelope, the
rest of the run does not depend on it, and p follows from the efforts on both sides. Moving a switch from effort f1
to f2 changes the cost by g = Δε + 2pΔ per metre, Δ = f1 − f2, and g by A = 2Δ·p' + 4qΔ² per metre and B = 2Δq per dw.
Riccati's equation with jumps then carries V's slope over the switch: p − B·g/A, q − B²/A (docs/extremals.md).
"""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.rows import ENVELOPE, is_anchor
from tgvdp.methods.extremal.switches import (
    ACTIVE,
    BY_MULTIPLIER,
    CROSS,
    CURVATURE,
    FIXED,
    FLOW,
    GAIN,
    HELD_W,
    JUMP,
    OF_TIME,
    PINNED,
    SIGMA,
    SLOPE,
    SWITCH_COLUMNS,
)
from tgvdp.methods.extremal.terms import (
    cost_of,
    effort_jump,
    held_slope,
    row_back,
    slope_of,
    terms_of,
    worth_of,
)
from tgvdp.physics.codes import COASTING, HELD_BACK, HOLDING, RETARDED
from tgvdp.physics.forces import effort_at

#: What is carried back over a run, (CARRIED,) float64: p and q; the flow to the active switch behind; what the steps of
#: the switches behind add to p; the derivative τ of the time to go by w; what the steps that a change of the multiplier
#: asks for add to it in dp/dλ; and the derivative of the running time by the multiplier through speeds that are held.
_P, _Q, _FLOW, _STEPPED, _TAU, _MOVED, _HELD = range(7)
CARRIED = 7
_LEAST_W = 1e-6


@leaf
def _begin(count, work):
    """Nothing is known at the end of a run."""
    at = work.carried
    for i in range(CARRIED):
        at[i] = 0.0
    at[_P] = math.nan
    for i in range(1, count):
        for column in range(SWITCH_COLUMNS):
            work.found[i, column] = 0.0


@part
def _join(train, course, price, rows, j, at):
    """Where row j joins an anchor the rest of the run does not depend on it: p follows from both efforts there."""
    up = rows.regime[j]
    down = rows.regime[j + 1]
    k = rows.cell[j]
    v = math.sqrt(rows.w[j])
    f1 = terms_of(train, up, course.grade[k], course.air[k], v)[0]
    f2 = rows.effort[j + 1]
    at[_Q] = 0.0
    if down == HOLDING:
        at[_P] = -0.5
    elif down == HELD_BACK:
        at[_P] = 0.0
    elif down < ENVELOPE:
        at[_P] = -0.5 * course.returned
    else:
        gap = 2.0 * (f1 - f2)
        at[_P] = -0.5
        if gap > 0.0:
            brake = effort_at(train.braking, v)
            at[_P] = -(cost_of(f1, brake, course.returned) - cost_of(f2, brake, course.returned)) / gap
            worth = worth_of(course, up)
            slope = slope_of(train, up, worth, course.grade[k], course.air[k], price, rows.w[j], at[_P], 0.0)
            at[_Q] = slope / gap
    at[_FLOW] = 0.0
    at[_STEPPED] = 0.0
    at[_TAU] = 0.0
    at[_MOVED] = 0.0


@part
def _efforts(train, course, rows, j):
    """Efforts before and behind the switch at the end of row j, and whether it is one: from the envelope only down."""
    up = rows.regime[j]
    down = rows.regime[j + 1]
    k = rows.cell[j]
    kd = rows.cell[j + 1]
    v = math.sqrt(rows.w[j])
    f2 = terms_of(train, down, course.grade[kd], course.air[kd], v)[0]
    f1 = rows.effort[j]
    if not is_anchor(up):
        f1 = terms_of(train, up, course.grade[k], course.air[k], v)[0]
    return f1, f2, up != ENVELOPE or f1 > f2 + 1e-6 * abs(f1)


@part
def _describe(train, course, price, rows, j, f1, f2, at, row):
    """Fill in what is known of the switch at the end of row j."""
    up = rows.regime[j]
    down = rows.regime[j + 1]
    kd = rows.cell[j + 1]
    w = rows.w[j]
    v = math.sqrt(w)
    brake = effort_at(train.braking, v)
    jump = f1 - f2
    p = at[_P]
    q = at[_Q]
    slope = slope_of(train, down, worth_of(course, down), course.grade[kd], course.air[kd], price, w, p, q)
    g = cost_of(f1, brake, course.returned) - cost_of(f2, brake, course.returned) + 2.0 * p * jump
    a = 2.0 * jump * slope + 4.0 * q * jump * jump
    least = max(abs(2.0 * jump * slope), abs(4.0 * q * jump * jump))
    row[GAIN] = g
    row[CURVATURE] = a if a > 1e-3 * least else max(least, 1e-30)
    row[JUMP] = jump
    row[SIGMA] = g / jump if jump != 0.0 else 0.0
    row[SLOPE] = g - 2.0 * at[_STEPPED] * jump
    row[ACTIVE] = 1.0 if a > 1e-3 * least else -1.0
    row[BY_MULTIPLIER] = 2.0 * jump * (at[_TAU] + at[_MOVED])
    row[OF_TIME] = 2.0 * jump * at[_TAU]
    if up in (HOLDING, RETARDED):
        row[HELD_W] = held_slope(train, course.returned, up, course.air[rows.cell[j]], v)
        row[CROSS] = 2.0 * jump * q


@part
def _cross(train, course, price, rows, j, is_pinned, at, row):
    """Carry p and q over the switch at the end of row j, by Riccati's equation with jumps; a pinned one joins."""
    up = rows.regime[j]
    k = rows.cell[j]
    g = row[GAIN]
    jump = row[JUMP]
    row[CROSS] = 2.0 * jump * at[_Q]
    if is_pinned:
        at[_P] -= 0.5 * g / jump
        at[_STEPPED] -= 0.5 * g / jump
        slope = slope_of(
            train, up, worth_of(course, up), course.grade[k], course.air[k], price, rows.w[j], at[_P], 0.0
        )  # fmt: skip
        at[_Q] = 0.5 * slope / jump
        row[CROSS] = 0.0
        at[_MOVED] = -at[_TAU]
    else:
        b = row[CROSS]
        at[_P] -= b * g / row[CURVATURE]
        at[_STEPPED] -= b * g / row[CURVATURE]
        at[_MOVED] -= b * row[BY_MULTIPLIER] / row[CURVATURE]
        at[_Q] -= b * b / row[CURVATURE]


@part
def _over_effort_jump(train, course, rows, j, at):
    """Where effort and its slope jump at the end of row j the Hamiltonian does not."""
    up = rows.regime[j]
    k = rows.cell[j]
    kd = rows.cell[j + 1]
    v = math.sqrt(rows.w[j])
    if effort_jump(train, up, v) == 0:
        return
    side = 1e-8 if rows.w[j + 1] > rows.w[j] else -1e-8
    f2, w2, _, load, _, _ = terms_of(train, up, course.grade[kd], course.air[kd], v * (1.0 + side))
    f1, w1, _, _, _, _ = terms_of(train, up, course.grade[k], course.air[k], v * (1.0 - side))
    if kd == k and (f1 - load) * (f2 - load) > 0.0:
        worth = worth_of(course, up)
        at[_P] = (worth * (f2 - f1) + 2.0 * at[_P] * (f2 - load)) / (2.0 * (f1 - load))
        at[_STEPPED] *= (f2 - load) / (f1 - load)
        at[_Q] = at[_Q] * ((f2 - load) / (f1 - load)) ** 2
        at[_Q] += (worth + 2.0 * at[_P]) * (w2 - w1) / (2.0 * (f1 - load))


@part
def _back_over_row(train, course, price, rows, j, at):
    """Carry all back over row j: by the costate equation where it is free, else to the level of its anchor."""
    up = rows.regime[j]
    k = rows.cell[j]
    w = rows.w[j]
    v = math.sqrt(w)
    d = rows.x[j] - rows.x[j - 1]
    if not is_anchor(up):
        w0 = max(rows.w[j - 1], _LEAST_W * w)
        at[_P], at[_Q], growth = row_back(
            train, up, worth_of(course, up), course.grade[k], course.air[k], price, d, w0, w, at[_P], at[_Q]
        )
        wm = 0.5 * (w0 + w)
        at[_TAU] = growth * at[_TAU] - 0.5 * d * math.sqrt(growth) / (wm * math.sqrt(wm))
        at[_FLOW] *= growth
        at[_STEPPED] *= growth
        at[_MOVED] *= growth
        return
    at[_FLOW] = 0.0
    if up == HOLDING:
        at[_P] = -0.5
        at[_Q] = 0.0
    elif up == HELD_BACK:
        at[_P] = 0.0
    elif up < ENVELOPE:
        at[_P] = -0.5 * course.returned
    else:
        at[_P] = math.nan
    if up in (HOLDING, RETARDED):
        at[_HELD] -= 0.5 * d / (v * w) * held_slope(train, course.returned, up, course.air[k], v)


@part
def sweep(train, course, price, count, rows, n, work):
    """Costate of a run, and Newton's terms for its switches.

    Parameters
    ----------
    train, course, rows
        As of `simulate`, which drove them.
    count : int
        Number of commands.
    price : float
        λ per unit of inertia, in energy of traction.
    n : int
        Number of rows.
    work : Work, modified in place
        ``pinned`` are switches from which the run just touches the envelope (`PINNED`): the run before one joins that
        after it; and those that stay where they are (`FIXED`, `FROZEN`). ``found`` gets what `switches` tells, zeros
        where a switch is not active; ``p_at`` and ``stepped_at`` p at the end of each row, and what the steps of the
        switches after it add to that; p is not a number on the envelope.

    Returns
    -------
    by_multiplier : float
        Derivative of the running time by the multiplier while all switches stay: that of the speeds that are held.
    """
    at = work.carried
    found = work.found
    _begin(count, work)
    c = count - 1
    after = -1
    for j in range(n - 1, 0, -1):
        up = rows.regime[j]
        if j < n - 1:
            down = rows.regime[j + 1]
            while c >= 1 and (work.starts[c] > j or work.starts[c] < 0):
                c -= 1
            if not is_anchor(up) and is_anchor(down):
                _join(train, course, price, rows, j, at)
            active = c >= 1 and work.starts[c] == j and not is_anchor(down) and up != down and at[_P] == at[_P]
            if active:
                f1, f2, active = _efforts(train, course, rows, j)
                if active:
                    _describe(train, course, price, rows, j, f1, f2, at, found[c])
            if active and work.pinned[c] < FIXED:
                if after >= 0:
                    found[after, FLOW] = at[_FLOW]
                after = c
                at[_FLOW] = 1.0
                if not is_anchor(up):
                    _cross(train, course, price, rows, j, work.pinned[c] == PINNED, at, found[c])
            elif not is_anchor(up) and up == down and up != COASTING:
                _over_effort_jump(train, course, rows, j, at)
            if up in (HOLDING, RETARDED) and not is_anchor(down):
                v = math.sqrt(rows.w[j])
                at[_HELD] += at[_TAU] * held_slope(train, course.returned, up, course.air[rows.cell[j]], v)
        elif not is_anchor(up):
            at[_P] = 0.0
            at[_Q] = 0.0
        work.p_at[j] = at[_P] - at[_STEPPED]
        work.stepped_at[j] = at[_STEPPED]
        _back_over_row(train, course, price, rows, j, at)
    work.p_at[0] = at[_P] - at[_STEPPED]
    work.stepped_at[0] = at[_STEPPED]
    return at[_HELD]
