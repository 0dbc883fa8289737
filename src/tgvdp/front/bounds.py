"""The lower bound for given costates: exact 1-D minima of the Hamiltonian, summed over cells.

All quantities are per unit of inertia: f = F/m_eff the effort, ρ(v) = (A + G + B·v + C·v²)/m_eff the load, λ the price.
For p linear over a cell of length d with slope p', every run satisfies

    ∫ (f⁺ + λ/v) ds + Δ(p·w) = ∫ H ds,     H(s, v, f) = f⁺ + λ/v + p'·v² + 2p·(f − ρ(v))

and f⁺ + 2p·f ≥ κ·M(v), where M is the largest traction (κ = 1 + 2p, p < −½), nothing (κ = 0, −½ ≤ p ≤ 0) or the
largest braking effort (κ = −2p, p > 0). Every piece of M is P/v + c0 + c1·v + c2·v² + c3·v³, also where a comfort limit
on the acceleration takes over, so that on each piece

    H(v) ≥ a/v + b0 + b1·v + b2·v² + b3·v³,     v²·H' = −a + b1·v² + 2·b2·v³ + 3·b3·v⁴

whose extremes are separated by the roots of b1 + 3·b2·v + 6·b3·v² = 0. For fixed (v, f) H is linear in s, so its
minimum over them is concave in s, and the trapezoid of its values at the ends of the cell bounds the integral. The
derivation and what is proven stand in docs/certificate.md.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.front.phases import is_standstill
from tgvdp.front.pieces import largest_effort, merge_comfort

_UNIT_ROUNDOFF = 2.0**-53
#: Roundings in one evaluation of the Hamiltonian: coefficients and value, 40 at most; and a spare factor of 5.
_ROUNDINGS = 200.0


@leaf
def _value(a, b0, b1, b2, b3, v):
    return a / v + b0 + v * (b1 + v * (b2 + v * b3))


@leaf
def _slope(a, b1, b2, b3, v):
    """v² times the derivative of `_value`."""
    return -a + v * v * (b1 + v * (2.0 * b2 + v * 3.0 * b3))


@kernel
def _interior_minimum(a, b0, b1, b2, b3, lo, hi):
    """Lower bound of the minimum between ``lo`` and ``hi``, where `_slope` rises through its only root.

    Newton's rule with bisection as its guard. The slope is monotone, hence |v²·H'| between the root and the last
    point is at most its value g there: H at the root is at least H there − |g|·(width of the bracket)/(its lower end)².
    """
    v = 0.5 * (lo + hi)
    if b1 == 0.0 and b3 == 0.0:
        v = min(max((a / (2.0 * b2)) ** (1.0 / 3.0), lo), hi)
    for _ in range(60):
        g = _slope(a, b1, b2, b3, v)
        if g < 0.0:
            lo = v
        else:
            hi = v
        curve = v * (2.0 * b1 + v * (6.0 * b2 + v * 12.0 * b3))
        step = g / curve if curve > 0.0 else math.inf
        if abs(step) <= 1e-9 * v:
            break
        v -= step
        if not lo < v < hi:
            v = 0.5 * (lo + hi)
    below = v * (1.0 - 1e-8)
    above = v * (1.0 + 1e-8)
    if below > lo and _slope(a, b1, b2, b3, below) < 0.0:
        lo = below
    if above < hi and _slope(a, b1, b2, b3, above) > 0.0:
        hi = above
    g = abs(_slope(a, b1, b2, b3, v))
    return _value(a, b0, b1, b2, b3, v) - g * (hi - lo) / (lo * lo), v


@kernel
def _least(a, b0, b1, b2, b3, lo, hi, best, at):
    """Update the least value and where it is taken by those of a/v + b0 + b1·v + b2·v² + b3·v³ on [lo, hi]."""
    # Term by term: most pieces cannot hold the least value.
    rough = (
        min(a / lo if lo > 0.0 else 0.0, a / hi) + b0 + min(b1 * lo, b1 * hi)
        + min(b2 * lo * lo, b2 * hi * hi) + min(b3 * lo * lo * lo, b3 * hi * hi * hi)
    )  # fmt: skip
    if lo > 0.0 and rough > best + 1e-9 * abs(best):
        return best, at
    value = _value(a, b0, b1, b2, b3, hi)
    if value < best:
        best = value
        at = hi
    if lo > 0.0:
        value = _value(a, b0, b1, b2, b3, lo)
        if value < best:
            best = value
            at = lo
    # Between the roots of b1 + 3·b2·v + 6·b3·v² the slope is monotone.
    first = hi
    second = hi
    if b3 != 0.0:
        discriminant = 9.0 * b2 * b2 - 24.0 * b1 * b3
        if discriminant > 0.0:
            q = -0.5 * (3.0 * b2 + math.copysign(math.sqrt(discriminant), b2))
            first = min(q / (6.0 * b3), b1 / q) if q != 0.0 else 0.0
            second = max(q / (6.0 * b3), b1 / q) if q != 0.0 else 0.0
    elif b2 != 0.0:
        first = -b1 / (3.0 * b2)
    first = min(max(first, lo), hi)
    second = min(max(second, first), hi)
    for part in range(3):
        u = lo if part == 0 else (first if part == 1 else second)
        v = first if part == 0 else (second if part == 1 else hi)
        if v <= u:
            continue
        if u == 0.0:  # the slope is −a < 0 there
            u = v
            while _slope(a, b1, b2, b3, u) >= 0.0:
                u *= 0.5
            if u == v:
                continue
            v = 2.0 * u
        if _slope(a, b1, b2, b3, u) < 0.0 < _slope(a, b1, b2, b3, v):
            value, where = _interior_minimum(a, b0, b1, b2, b3, u, v)
            if value < best:
                best = value
                at = where
    return best, at


@kernel
def least_hamiltonian(pull, pulls, brake, brakes, r0, r1, r2, load, price, p, p_s, top_v):
    """Lower bound of the least H over all speeds up to ``top_v``, and a bound of its rounding error in units of 2⁻⁵³.

    ``pull`` and ``brake`` are the first ``pulls`` and ``brakes`` rows of tables made by `merge_comfort`; the load is
    r0 + r1·v + r2·v², and ``load`` the sum of the magnitudes that make up r0.
    """
    best = math.inf
    at = top_v
    kappa = 0.0
    b0 = -2.0 * p * r0
    b1 = -2.0 * p * r1
    b2 = p_s - 2.0 * p * r2
    if -0.5 <= p <= 0.0:
        best, at = _least(price, b0, b1, b2, 0.0, 0.0, top_v, best, at)
        effort = 0.0
    else:
        kappa = 1.0 + 2.0 * p if p < 0.0 else -2.0 * p
        table = pull if p < 0.0 else brake
        n = pulls if p < 0.0 else brakes
        for i in range(n - 1, -1, -1):
            hi = top_v if i == n - 1 else table[i + 1, 0]
            best, at = _least(
                price + kappa * table[i, 1], b0 + kappa * table[i, 2], b1 + kappa * table[i, 3],
                b2 + kappa * table[i, 4], kappa * table[i, 5], table[i, 0], hi, best, at,
            )  # fmt: skip
        i = n - 1
        while i > 0 and table[i, 0] > at:
            i -= 1
        effort = abs(table[i, 1]) / at + abs(table[i, 2])
        effort += at * (abs(table[i, 3]) + at * (abs(table[i, 4]) + at * abs(table[i, 5])))
    size = price / at + abs(kappa) * effort + (abs(p_s) + 2.0 * abs(p) * r2) * at * at
    size += 2.0 * abs(p) * (load + r1 * at)
    return best, _ROUNDINGS * size


@kernel
def standstill_cell(pieces, n, load0, load1, load2, start, length, price, slope, end_w, top_w):
    """Lower bound of time and work in a cell at whose one end w is (nearly) 0, plus slope·w at the other end.

    The gain of w per metre is at most 2g, g = sup(M − load) after a stop, sup(M + load) before one (``start`` False).
    So w ≤ end_w + 2·g·x, the time is at least 2d/(√end_w + √(end_w + 2gd)), and the work of starting at least
    ½(w − end_w) + d·load(0).
    """
    w = end_w + 4.0 * length * (max(largest_effort(pieces, n, 0.0), 0.0) + abs(load0))
    gain = 0.0
    while True:
        w = min(w, top_w)
        v = math.sqrt(w)
        gain = largest_effort(pieces, n, v)
        gain += -load0 if start else load0 + v * (load1 + v * load2)
        gain = max(gain, 0.0)
        if end_w + 2.0 * gain * length <= w or w >= top_w:
            break
        w *= 2.0
    reach = end_w + 2.0 * gain * length
    w = min(w, reach)
    least = price * 2.0 * length / (math.sqrt(end_w) + math.sqrt(reach)) if reach > 0.0 else 0.0
    if start:
        return least + min(0.0, (0.5 + slope) * w) - 0.5 * end_w + load0 * length
    return least + min(0.0, slope * w)


@kernel
def bound_kernel(train, length, grade, air, cap, w, price, left, right, pull, brake, bound):
    """Lower bound of E + λT, per unit of inertia.

    Parameters
    ----------
    train : KernelTrain
    length, grade, air : (K,) float64
        Cells: length in m, grade force in N, coefficient of v² in N/(m/s)².
    cap : (K,) float64
        Squared speed that no run passes in the cell, m²/s².
    w : (K + 1,) float64
        Squared speeds of the run that the costates belong to, m²/s²: of use are those at the two ends, and whether
        the cells there are cells of a standstill.
    price : float
        λ per unit of inertia.
    left, right : (K,) float64
        Costate p at the two ends of each cell.
    pull, brake : (2n, 6) float64
        Scratch for the pieces of the effort curves.
    bound : (K,) float64, modified in place
        Lower bound of ∫H over each cell, with the jump of p at its left end and the terms of the trip's ends.

    Returns
    -------
    total : float
        The bound: the sum over the cells.
    error : float
        Bound of its rounding error.
    """
    count = length.shape[0]
    last = count - 1
    mass = train.inertia_kg
    r1 = train.davis_b / mass
    first_stands = is_standstill(w[0], w[1])
    last_stands = is_standstill(w[count], w[last])
    pulls = 0
    brakes = 0
    total = 0.0
    sizes = 0.0
    error = 0.0
    for k in range(count):
        d = length[k]
        r0 = (train.davis_a_n + grade[k]) / mass
        r2 = air[k] / mass
        top_v = math.sqrt(cap[k]) * (1.0 + 4.0 * _UNIT_ROUNDOFF)
        if k == 0 or grade[k] != grade[k - 1] or air[k] != air[k - 1] or cap[k] != cap[k - 1]:
            pulls = merge_comfort(train.traction, 0.0, mass, train.max_acceleration, r0, r1, r2, top_v, pull)
            brakes = merge_comfort(
                train.braking, train.friction_n, mass, train.max_deceleration, -r0, -r1, -r2, top_v, brake
            )
        if k == 0 and first_stands:
            bound[k] = standstill_cell(pull, pulls, r0, r1, r2, True, d, price, left[1], w[0], cap[k])
            error += _ROUNDINGS * abs(bound[k])
        elif k == last and last_stands:
            bound[k] = standstill_cell(brake, brakes, r0, r1, r2, False, d, price, -right[k - 1], w[count], cap[k])
            error += _ROUNDINGS * abs(bound[k])
        else:
            ends = 0.0
            if k == 0:
                ends = left[0] * w[0]
            elif k > 1 or not first_stands:
                ends = min(0.0, left[k] - right[k - 1]) * min(cap[k - 1], cap[k])
            if k == last:
                ends -= right[k] * w[count]
                error += _ROUNDINGS * abs(right[k] * w[count])
            slope = (right[k] - left[k]) / d
            load = (train.davis_a_n + abs(grade[k])) / mass
            first, size0 = least_hamiltonian(pull, pulls, brake, brakes, r0, r1, r2, load, price, left[k], slope, top_v)
            second, size1 = least_hamiltonian(
                pull, pulls, brake, brakes, r0, r1, r2, load, price, right[k], slope, top_v
            )
            bound[k] = 0.5 * d * (first + second) + ends
            error += 0.5 * d * (size0 + size1) + _ROUNDINGS * abs(ends)
        total += bound[k]
        sizes += abs(bound[k])
    return total, (error + (count + 4.0) * sizes) * _UNIT_ROUNDOFF
