"""What the costate equation of a row is made of: effort, load and their derivatives, costs, and one step back."""

import math

from tgvdp._jit import leaf, part
from tgvdp.physics.codes import DYNAMIC, HOLDING, RETARDED, TRACTION
from tgvdp.physics.forces import piece_at


@part
def terms_of(train, regime, grade, air, v):
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
def slope_of(train, regime, worth, grade, air, price, w, p, q):
    """Derivative p' at a squared speed."""
    v = math.sqrt(w)
    return _slopes(terms_of(train, regime, grade, air, v), worth, price, v, w, p, q)[0]


@leaf
def cost_of(effort, brake, returned):
    """Energy per metre of an effort, in that of traction; ``brake`` is the dynamic brake's largest effort."""
    return effort if effort >= 0.0 else returned * max(effort, -brake)


@part
def row_back(train, regime, worth, grade, air, price, d, w0, w, p, q):
    """p, q at the start of a row from those at its end, and the flow over it: Runge and Kutta's rule."""
    wm = 0.5 * (w0 + w)
    v0 = math.sqrt(w0)
    vm = math.sqrt(wm)
    v = math.sqrt(w)
    middle = terms_of(train, regime, grade, air, vm)
    a1, b1 = _slopes(terms_of(train, regime, grade, air, v), worth, price, v, w, p, q)
    a2, b2 = _slopes(middle, worth, price, vm, wm, p - 0.5 * d * a1, q - 0.5 * d * b1)
    a3, b3 = _slopes(middle, worth, price, vm, wm, p - 0.5 * d * a2, q - 0.5 * d * b2)
    a4, b4 = _slopes(terms_of(train, regime, grade, air, v0), worth, price, v0, w0, p - d * a3, q - d * b3)
    p -= d / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    q -= d / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    return p, q, math.exp(2.0 * d * (middle[1] - middle[4]))


@leaf
def held_slope(train, returned, regime, air, v):
    """Derivative of the squared speed that a multiplier holds by that multiplier: λ = V²·R'(V), or r times that."""
    if regime == HOLDING:
        return 1.0 / (train.davis_b + 3.0 * air * v)
    return 1.0 / (returned * (train.davis_b + 3.0 * air * v)) if regime == RETARDED else 0.0


@leaf
def flow_over(train, course, k, regime, w, d):
    """Growth of a difference in w over so many metres of a regime."""
    _, f_w, _, _, load_w, _ = terms_of(train, regime, course.grade[k], course.air[k], math.sqrt(w))
    return math.exp(2.0 * (f_w - load_w) * d)


@leaf
def force_balance(train, course, k, regime, w):
    """Effort less load of a regime."""
    f, _, _, load, _, _ = terms_of(train, regime, course.grade[k], course.air[k], math.sqrt(w))
    return f - load


@leaf
def effort_jump(train, regime, v):
    """Piece of a regime's effort curve that begins at a speed; 0 if none does."""
    table = train.traction if regime == TRACTION else train.braking
    for i in range(1, table.shape[0]):
        if abs(table[i, 0] - v) <= 1e-9 * v:
            return i
    return 0


@leaf
def worth_of(course, regime):
    """Price of a regime's work, in that of traction."""
    return course.returned if regime == DYNAMIC else 1.0
