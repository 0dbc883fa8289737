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
from tgvdp.physics.codes import COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.physics.forces import effort_at, piece_at

#: Columns of what a sweep says of a command: derivative g of the cost by its position while the switches after it take
#: their steps, its derivative A (its size where it is not positive), that by the squared speed B, the jump of effort Δ,
#: σ = g/Δ, the flow from the active switch before it, whether it is active (−1: and A is not positive), the derivative
#: of the cost while all other switches stay, that of g by the multiplier, that of the running time, and what the
#: multiplier adds to the squared speed at a switch that leaves a hold.
GAIN, CURVATURE, CROSS, JUMP, SIGMA, FLOW, ACTIVE, SLOPE, BY_MULTIPLIER, OF_TIME, HELD_W = range(11)
SWITCH_COLUMNS = 11
#: How a switch may be bound: to where its run touches the envelope, to a corner of the envelope, or to where it is.
PINNED = 1
FIXED = 2
FROZEN = 3

_LEAST_W = 1e-6


@part
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
        i = piece_at(table, v)
        h = table[i, 1] * per_v
        f = h + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))
        d1 = -h * per_v + table[i, 3] + v * (2.0 * table[i, 4] + 3.0 * v * table[i, 5])
        d2 = 2.0 * h * per_v * per_v + 2.0 * table[i, 4] + 6.0 * v * table[i, 5]
        f_w = 0.5 * d1 * per_v
        f_ww = 0.25 * (d2 - d1 * per_v) * per_v * per_v
        if regime == TRACTION:
            if f - load >= train.max_acceleration:
                f = max(load + train.max_acceleration, 0.0)
                f_w = load_w if f > 0.0 else 0.0
                f_ww = load_ww if f > 0.0 else 0.0
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
def _slopes(terms, worth, price, v, w, p, q):
    """Derivatives p' and q' from the terms at a speed."""
    _, f_w, f_ww, _, load_w, load_ww = terms
    cubed = 1.0 / (v * w)
    sum_ = worth + 2.0 * p
    slope = 0.5 * price * cubed + 2.0 * p * load_w - sum_ * f_w
    bend = -0.75 * price * cubed / w + 2.0 * p * load_ww - sum_ * f_ww
    return slope, bend - 4.0 * (f_w - load_w) * q


@part
def _slope(train, regime, worth, grade, air, price, w, p, q):
    """Derivative p' at a squared speed."""
    v = math.sqrt(w)
    return _slopes(_terms(train, regime, grade, air, v), worth, price, v, w, p, q)[0]


@leaf
def cost_of(effort, brake, returned):
    """Energy per metre of an effort, in that of traction; ``brake`` is the dynamic brake's largest effort."""
    return effort if effort >= 0.0 else returned * max(effort, -brake)


@part
def _row_back(train, regime, worth, grade, air, price, d, w0, w, p, q):
    """p, q at the start of a row from those at its end, and the flow over it: Runge and Kutta's rule."""
    wm = 0.5 * (w0 + w)
    v0 = math.sqrt(w0)
    vm = math.sqrt(wm)
    v = math.sqrt(w)
    middle = _terms(train, regime, grade, air, vm)
    a1, b1 = _slopes(_terms(train, regime, grade, air, v), worth, price, v, w, p, q)
    a2, b2 = _slopes(middle, worth, price, vm, wm, p - 0.5 * d * a1, q - 0.5 * d * b1)
    a3, b3 = _slopes(middle, worth, price, vm, wm, p - 0.5 * d * a2, q - 0.5 * d * b2)
    a4, b4 = _slopes(_terms(train, regime, grade, air, v0), worth, price, v0, w0, p - d * a3, q - d * b3)
    p -= d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    q -= d / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    return p, q, math.exp(2.0 * d * (middle[1] - middle[4]))


@leaf
def _held_slope(train, returned, regime, air, v):
    """Derivative of the squared speed that a multiplier holds by that multiplier: λ = V²·R'(V), or r times that."""
    if regime == HOLDING:
        return 1.0 / (train.davis_b + 3.0 * air * v)
    return 1.0 / (returned * (train.davis_b + 3.0 * air * v)) if regime == RETARDED else 0.0


@leaf
def flow_over(train, course, k, regime, w, d):
    """Growth of a difference in w over so many metres of a regime."""
    _, f_w, _, _, load_w, _ = _terms(train, regime, course.grade[k], course.air[k], math.sqrt(w))
    return math.exp(2.0 * (f_w - load_w) * d)


@leaf
def force_balance(train, course, k, regime, w):
    """Effort less load of a regime."""
    f, _, _, load, _, _ = _terms(train, regime, course.grade[k], course.air[k], math.sqrt(w))
    return f - load


@leaf
def _effort_jump(train, regime, v):
    """Piece of a regime's effort curve that begins at a speed; 0 if none does."""
    table = train.traction if regime == TRACTION else train.braking
    for i in range(1, table.shape[0]):
        if abs(table[i, 0] - v) <= 1e-9 * v:
            return i
    return 0


@part
def sweep(train, course, price, count, rows, n, starts, pinned, found, p_at, stepped_at):
    """Costate of a run, and Newton's terms for its switches.

    Parameters
    ----------
    train, course, rows, starts
        As of `simulate`, which drove them.
    count : int
        Number of commands.
    price : float
        λ per unit of inertia, in energy of traction.
    n : int
        Number of rows.
    pinned : (size,) int64
        `PINNED` for switches from which the run just touches the envelope: the run before one joins that after it;
        `FIXED` and `FROZEN` for those that stay where they are.
    found : (size, SWITCH_COLUMNS) float64, modified in place
        For each command, see above; zeros where the switch is not active.
    p_at, stepped_at : (size,) float64, modified in place
        p at the end of each row, and what the steps of the switches after it add to that; p is not a number on the
        envelope.

    Returns
    -------
    by_multiplier : float
        Derivative of the running time by the multiplier while all switches stay: that of the speeds that are held.
    """
    c = count - 1
    for i in range(1, count):
        for column in range(SWITCH_COLUMNS):
            found[i, column] = 0.0
    p = math.nan
    q = 0.0
    flow = 0.0
    stepped = 0.0  # what the steps of the switches downstream add to p
    tau = 0.0  # derivative of the time to go by w
    moved = 0.0  # what the steps that a change of the multiplier asks for add to it in dp/dλ
    by_multiplier = 0.0
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
            while c >= 1 and (starts[c] > j or starts[c] < 0):
                c -= 1
            if free and is_anchor(down):
                f1, _, _, _, _, _ = _terms(train, up, course.grade[k], course.air[k], v)
                worth = course.returned if up == DYNAMIC else 1.0
                brake = effort_at(train.braking, v)
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
                        slope = _slope(train, up, worth, course.grade[k], course.air[k], price, w, p, 0.0)
                        q = slope / gap
                flow = 0.0
                stepped = 0.0
                tau = 0.0
                moved = 0.0
            active = c >= 1 and starts[c] == j and not is_anchor(down) and up != down and p == p
            if active:
                f2, _, _, _, _, _ = _terms(train, down, course.grade[kd], course.air[kd], v)
                f1 = rows.effort[j]
                if free:
                    f1, _, _, _, _, _ = _terms(train, up, course.grade[k], course.air[k], v)
                active = up != ENVELOPE or f1 > f2 + 1e-6 * abs(f1)
            if active:
                brake = effort_at(train.braking, v)
                jump = f1 - f2
                worth = course.returned if down == DYNAMIC else 1.0
                slope = _slope(train, down, worth, course.grade[kd], course.air[kd], price, w, p, q)
                g = cost_of(f1, brake, course.returned) - cost_of(f2, brake, course.returned) + 2.0 * p * jump
                a = 2.0 * jump * slope + 4.0 * q * jump * jump
                row = found[c]
                least = max(abs(2.0 * jump * slope), abs(4.0 * q * jump * jump))
                row[GAIN] = g
                row[CURVATURE] = a if a > 1e-3 * least else max(least, 1e-30)
                row[JUMP] = jump
                row[SIGMA] = g / jump if jump != 0.0 else 0.0
                row[SLOPE] = g - 2.0 * stepped * jump
                row[ACTIVE] = 1.0 if a > 1e-3 * least else -1.0
                row[BY_MULTIPLIER] = 2.0 * jump * (tau + moved)
                row[OF_TIME] = 2.0 * jump * tau
                if up in (HOLDING, RETARDED):
                    row[HELD_W] = _held_slope(train, course.returned, up, course.air[k], v)
                    row[CROSS] = 2.0 * jump * q
            if active and pinned[c] < FIXED:
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
                        slope = _slope(train, up, worth, course.grade[k], course.air[k], price, w, p, 0.0)
                        q = 0.5 * slope / jump
                        row[CROSS] = 0.0
                        moved = -tau
                    else:
                        b = row[CROSS]
                        p -= b * g / row[CURVATURE]
                        stepped -= b * g / row[CURVATURE]
                        moved -= b * row[BY_MULTIPLIER] / row[CURVATURE]
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
            if up in (HOLDING, RETARDED) and not is_anchor(down):
                by_multiplier += tau * _held_slope(train, course.returned, up, course.air[k], v)
        elif free:
            p = 0.0
            q = 0.0
        p_at[j] = p - stepped
        stepped_at[j] = stepped
        if free:
            w0 = max(rows.w[j - 1], _LEAST_W * w)
            worth = course.returned if up == DYNAMIC else 1.0
            d = rows.x[j] - rows.x[j - 1]
            p, q, growth = _row_back(train, up, worth, course.grade[k], course.air[k], price, d, w0, w, p, q)
            wm = 0.5 * (w0 + w)
            tau = growth * tau - 0.5 * d * math.sqrt(growth) / (wm * math.sqrt(wm))
            flow *= growth
            stepped *= growth
            moved *= growth
        elif up == HOLDING:
            p = -0.5
            q = 0.0
            flow = 0.0
            by_multiplier -= (
                0.5 * (rows.x[j] - rows.x[j - 1]) / (v * w) * _held_slope(train, course.returned, up, course.air[k], v)
            )
        elif up == HELD_BACK:
            p = 0.0
            flow = 0.0
        elif up < ENVELOPE:
            p = -0.5 * course.returned
            flow = 0.0
            by_multiplier -= (
                0.5 * (rows.x[j] - rows.x[j - 1]) / (v * w) * _held_slope(train, course.returned, up, course.air[k], v)
            )
        else:
            p = math.nan
            flow = 0.0
    p_at[0] = p - stepped
    stepped_at[0] = stepped
    return by_multiplier


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
