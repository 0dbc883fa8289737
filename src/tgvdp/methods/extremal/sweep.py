"""Carry the costate back over a run, with its slope and the tangent flow: Newton's step in all switches at once.

Along a row of regime f, with the price a of its work (1 under traction, r under the dynamic brake),

    p' = λ/(2v³) + 2p·ρ_w − (a + 2p)·f_w,      q' = ∂p'/∂w − 4(f_w − ρ_w)·q,      φ' = 2(f_w − ρ_w)·φ

for p = ∂V/∂w, q = dp/dw and the flow φ = ∂w/∂w_before. Where a run joins an anchor, a held speed or the envelope, the
rest of the run does not depend on it, and p follows from the efforts on both sides. Moving a switch from effort f1
to f2 changes the cost by g = Δε + 2pΔ per metre, Δ = f1 − f2, and g by A = 2Δ·p' + 4qΔ² per metre and B = 2Δq per dw.
Riccati's equation with jumps then carries V's slope over the switch: p − B·g/A, q − B²/A (docs/extremals.md).
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.methods.extremal.simulate import ENVELOPE, is_anchor
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, TRACTION

#: Columns of what a sweep says of a command: derivative g of the cost by its position while the switches after it take
#: their steps, its derivative A (its size where it is not positive), that by the squared speed B, the jump of effort Δ,
#: σ = g/Δ, the flow from the active switch before it, whether it is active, and the derivative of the cost while all
#: other switches stay.
GAIN, CURVATURE, CROSS, JUMP, SIGMA, FLOW, ACTIVE, SLOPE = range(8)
SWITCH_COLUMNS = 8
#: How a switch may be bound.
PINNED = 1
FIXED = 2

_LEAST_W = 1e-6


@leaf
def _terms(train, regime, grade, air, v):
    """Effort and load with their first two derivatives by w, at a speed: f, f_w, f_ww, ρ, ρ_w, ρ_ww."""
    load = train.davis_a_n + v * (train.davis_b + v * air) + grade
    per_v = 1.0 / v
    load_w = 0.5 * train.davis_b * per_v + air
    load_ww = -0.25 * train.davis_b * per_v * per_v * per_v
    f = 0.0
    f_w = 0.0
    f_ww = 0.0
    if regime in (TRACTION, DYNAMIC):
        table = train.traction if regime == TRACTION else train.braking
        i = table.shape[0] - 1
        while i > 0 and table[i, 0] > v:
            i -= 1
        h = table[i, 1] * per_v
        f = h + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))
        d1 = -h * per_v + table[i, 3] + v * (2.0 * table[i, 4] + 3.0 * v * table[i, 5])
        d2 = 2.0 * h * per_v * per_v + 2.0 * table[i, 4] + 6.0 * v * table[i, 5]
        f_w = 0.5 * d1 * per_v
        f_ww = 0.25 * (d2 - d1 * per_v) * per_v * per_v
        if regime == TRACTION:
            if f - load >= train.max_acceleration:
                f = load + train.max_acceleration
                f_w = load_w
                f_ww = load_ww
        else:
            f = -f
            f_w = -f_w
            f_ww = -f_ww
            most = train.max_deceleration
            if train.rates.shape[0] > 0:
                i = train.rates.shape[0] - 1
                while i > 0 and train.rates[i, 0] > v:
                    i -= 1
                most = min(most, train.rates[i, 2])
            if f - load <= -most:
                f = min(load - most, 0.0)
                f_w = load_w if f < 0.0 else 0.0
                f_ww = load_ww if f < 0.0 else 0.0
    return f, f_w, f_ww, load, load_w, load_ww


@leaf
def _rates(train, regime, worth, grade, air, price, w, p, q):
    """p', q' and the logarithmic slope of the flow."""
    v = math.sqrt(w)
    _, f_w, f_ww, _, load_w, load_ww = _terms(train, regime, grade, air, v)
    cubed = 1.0 / (v * w)
    sum_ = worth + 2.0 * p
    slope = 0.5 * price * cubed + 2.0 * p * load_w - sum_ * f_w
    bend = -0.75 * price * cubed / w + 2.0 * p * load_ww - sum_ * f_ww
    return slope, bend - 4.0 * (f_w - load_w) * q, 2.0 * (f_w - load_w)


@leaf
def cost_of(effort, brake, returned):
    """Energy per metre of an effort, in that of traction; ``brake`` is the dynamic brake's largest effort."""
    return effort if effort >= 0.0 else returned * max(effort, -brake)


@leaf
def _brake_effort(train, v):
    table = train.braking
    i = table.shape[0] - 1
    while i > 0 and table[i, 0] > v:
        i -= 1
    hyperbolic = table[i, 1] / v if table[i, 1] != 0.0 else 0.0
    return hyperbolic + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))


@part
def _row_back(train, regime, worth, grade, air, price, d, w0, w, p, q):
    """p, q at the start of a row from those at its end, and the flow over it: Runge and Kutta's rule."""
    wm = 0.5 * (w0 + w)
    a1, b1, _ = _rates(train, regime, worth, grade, air, price, w, p, q)
    a2, b2, _ = _rates(train, regime, worth, grade, air, price, wm, p - 0.5 * d * a1, q - 0.5 * d * b1)
    a3, b3, c3 = _rates(train, regime, worth, grade, air, price, wm, p - 0.5 * d * a2, q - 0.5 * d * b2)
    a4, b4, _ = _rates(train, regime, worth, grade, air, price, w0, p - d * a3, q - d * b3)
    p -= d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    q -= d / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    return p, q, math.exp(d * c3)


@leaf
def _effort_jump(train, regime, v):
    """Piece of a regime's effort curve that begins at a speed; 0 if none does."""
    table = train.traction if regime == TRACTION else train.braking
    for i in range(1, table.shape[0]):
        if abs(table[i, 0] - v) <= 1e-9 * v:
            return i
    return 0


@kernel
def sweep(train, course, price, commands, low, count, rows, n, starts, pinned, found, p_at, q_at):
    """Costate of a run, and Newton's terms for its switches.

    Parameters
    ----------
    train, course, commands, rows, starts
        As of `simulate`, which drove them.
    low, count : int
        Only commands from ``low`` up to ``count`` are looked at.
    price : float
        λ per unit of inertia, in energy of traction.
    n : int
        Number of rows.
    pinned : (size,) int64
        `PINNED` for switches from which the run just touches the envelope: the run before one joins that after it;
        `FIXED` for those that stay where they are.
    found : (size, SWITCH_COLUMNS) float64, modified in place
        For each command, see above; zeros where the switch is not active.
    p_at, q_at : (size,) float64, modified in place
        p, without the steps of switches, and q at the end of each row; not a number on the envelope.
    """
    c = count - 1
    for i in range(low, count):
        for column in range(SWITCH_COLUMNS):
            found[i, column] = 0.0
    p = math.nan
    q = 0.0
    flow = 0.0
    stepped = 0.0  # what the steps of the switches downstream add to p
    after = -1
    for j in range(n - 1, 0, -1):
        up = rows.regime[j]
        k = rows.cell[j]
        w = rows.w[j]
        v = math.sqrt(w)
        free = not is_anchor(up)
        if j < n - 1:
            down = rows.regime[j + 1]
            kd = rows.cell[j + 1]
            while c >= low and (starts[c] > j or starts[c] < 0):
                c -= 1
            if free and is_anchor(down):
                f1, _, _, _, _, _ = _terms(train, up, course.grade[k], course.air[k], v)
                worth = course.returned if up == DYNAMIC else 1.0
                brake = _brake_effort(train, v)
                f2 = rows.effort[j + 1]
                q = 0.0
                if down == HOLDING:
                    p = -0.5
                elif down == HELD_BACK:
                    p = 0.0
                elif down < ENVELOPE:
                    p = -0.5 * course.returned
                else:
                    gap = 2.0 * (f1 - f2)
                    p = -0.5
                    if gap > 0.0:
                        p = -(cost_of(f1, brake, course.returned) - cost_of(f2, brake, course.returned)) / gap
                        slope, _, _ = _rates(train, up, worth, course.grade[k], course.air[k], price, w, p, 0.0)
                        q = slope / gap
                flow = 0.0
                stepped = 0.0
            active = c >= low and starts[c] == j and not is_anchor(down) and up != down and p == p
            if active:
                f2, _, _, _, _, _ = _terms(train, down, course.grade[kd], course.air[kd], v)
                f1 = rows.effort[j]
                if free:
                    f1, _, _, _, _, _ = _terms(train, up, course.grade[k], course.air[k], v)
                active = up != ENVELOPE or f1 > f2 + 1e-6 * abs(f1)
            if active:
                brake = _brake_effort(train, v)
                jump = f1 - f2
                worth = course.returned if down == DYNAMIC else 1.0
                slope, _, _ = _rates(train, down, worth, course.grade[kd], course.air[kd], price, w, p, q)
                g = cost_of(f1, brake, course.returned) - cost_of(f2, brake, course.returned) + 2.0 * p * jump
                a = 2.0 * jump * slope + 4.0 * q * jump * jump
                row = found[c]
                least = max(abs(2.0 * jump * slope), abs(4.0 * q * jump * jump))
                row[GAIN] = g
                row[CURVATURE] = a if a > 1e-3 * least else max(least, 1e-30)
                row[JUMP] = jump
                row[SIGMA] = g / jump if jump != 0.0 else 0.0
                row[SLOPE] = g - 2.0 * stepped * jump
                row[ACTIVE] = 1.0
            if active and pinned[c] != FIXED:
                if after >= 0:
                    found[after, FLOW] = flow
                after = c
                flow = 1.0
                if free:
                    row[CROSS] = 2.0 * jump * q
                    if pinned[c] == PINNED:
                        worth = course.returned if up == DYNAMIC else 1.0
                        p -= 0.5 * g / jump
                        stepped -= 0.5 * g / jump
                        slope, _, _ = _rates(train, up, worth, course.grade[k], course.air[k], price, w, p, 0.0)
                        q = 0.5 * slope / jump
                        row[CROSS] = 0.0
                    else:
                        b = row[CROSS]
                        p -= b * g / row[CURVATURE]
                        stepped -= b * g / row[CURVATURE]
                        q -= b * b / row[CURVATURE]
            elif free and not is_anchor(down) and up == down and up != COASTING:
                i = _effort_jump(train, up, v)
                if i > 0:  # effort and its slope jump: the Hamiltonian does not
                    worth = course.returned if up == DYNAMIC else 1.0
                    rises = rows.w[j + 1] > w
                    side = 1e-8 if rises else -1e-8
                    f2, w2, _, load, _, _ = _terms(train, up, course.grade[kd], course.air[kd], v * (1.0 + side))
                    f1, w1, _, _, _, _ = _terms(train, up, course.grade[k], course.air[k], v * (1.0 - side))
                    if kd == k and (f1 - load) * (f2 - load) > 0.0:
                        p = (worth * (f2 - f1) + 2.0 * p * (f2 - load)) / (2.0 * (f1 - load))
                        stepped *= (f2 - load) / (f1 - load)
                        q = q * ((f2 - load) / (f1 - load)) ** 2
                        q += (worth + 2.0 * p) * (w2 - w1) / (2.0 * (f1 - load))
        elif free:
            p = 0.0
            q = 0.0
        p_at[j] = p - stepped
        q_at[j] = q
        if free:
            w0 = max(rows.w[j - 1], _LEAST_W * w)
            worth = course.returned if up == DYNAMIC else 1.0
            p, q, growth = _row_back(
                train, up, worth, course.grade[k], course.air[k], price, rows.x[j] - rows.x[j - 1], w0, w, p, q
            )
            flow *= growth
            stepped *= growth
        elif up == HOLDING:
            p = -0.5
            q = 0.0
            flow = 0.0
        elif up == HELD_BACK:
            p = 0.0
            flow = 0.0
        elif up < ENVELOPE:
            p = -0.5 * course.returned
            flow = 0.0
        else:
            p = math.nan
            flow = 0.0
    p_at[0] = p - stepped
    q_at[0] = q
    return after


@kernel
def lift(train, course, commands, count, rows, n, starts, pinned, found, p_at):
    """Add to the costate between pinned switches and where the run touches the envelope what the touch is worth.

    As much as makes p at the switch its level: p' is linear in p, so that it grows as the flow shrinks.
    """
    e = 0
    for c in range(1, count):
        if pinned[c] != PINNED or found[c, ACTIVE] == 0.0:
            continue
        first = starts[c]
        touch = first
        least = math.inf
        j = first + 1
        while j < n and not is_anchor(rows.regime[j]) and rows.regime[j] == rows.regime[first + 1]:
            while e < course.x_m.shape[0] - 2 and course.x_m[e + 1] <= rows.x[j]:
                e += 1
            share = (rows.x[j] - course.x_m[e]) / (course.x_m[e + 1] - course.x_m[e])
            top = course.w[e] + (course.w[e + 1] - course.w[e]) * share
            if top - rows.w[j] < least * (1.0 + 1e-9):
                least = top - rows.w[j]
                touch = j
            j += 1
        lifted = -0.5 * found[c, SIGMA]
        p_at[first] += lifted
        for j in range(first + 1, touch):
            k = rows.cell[j]
            v = math.sqrt(0.5 * (rows.w[j - 1] + rows.w[j]))
            _, f_w, _, _, load_w, _ = _terms(train, rows.regime[j], course.grade[k], course.air[k], v)
            lifted *= math.exp(-2.0 * (f_w - load_w) * (rows.x[j] - rows.x[j - 1]))
            p_at[j] += lifted
