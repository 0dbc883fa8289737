"""The lower bound for given costates: exact 1-D minima of the Hamiltonian, summed over cells.

All quantities are per unit of inertia: f = F/m_eff the effort, ρ(v) = (A + G + B·v + C·v²)/m_eff the load, λ the price.
Effort costs e(f) = a·f for traction and gives back η·|f| as far as the dynamic brake does it (wheel: a = 1, η = 0). For
p linear over a cell of length d with slope p', every run satisfies

    ∫ (e(f) + λ/v) ds + Δ(p·w) = ∫ H ds,     H(s, v, f) = e(f) + λ/v + p'·v² + 2p·(f − ρ(v))

and, with the largest traction M, dynamic braking D and braking B of all kinds at speed v, e(f) + 2p·f is at least

    (a + 2p)·M if 2p < −a      0 if −a ≤ 2p ≤ −η      −(η + 2p)·D if −η < 2p ≤ 0      −η·D − 2p·B if p > 0.

All factors of an effort are negative. Every piece of an effort is P/v + c0 + c1·v + c2·v² + c3·v³, also where a comfort
limit on the acceleration takes over, so that on each piece

    H(v) ≥ a/v + b0 + b1·v + b2·v² + b3·v³,     v²·H' = −a + b1·v² + 2·b2·v³ + 3·b3·v⁴

whose extremes are separated by the roots of b1 + 3·b2·v + 6·b3·v² = 0. For fixed (v, f) H is linear in s, so its
minimum over them is concave in s, and the trapezoid of its values at the ends of the cell bounds the integral. The
derivation and what is proven stand in docs/certificate.md.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.front.minimum import least_on_piece
from tgvdp.front.phases import is_standstill
from tgvdp.front.pieces import largest_effort, merge_tables, piece_at

_UNIT_ROUNDOFF = 2.0**-53
#: Roundings in one evaluation of the Hamiltonian: coefficients and value, 40 at most; and a spare factor of 5.
_ROUNDINGS = 200.0


@leaf
def _size(table, n, v):
    """Sum of the magnitudes of the terms of an effort at v."""
    i = piece_at(table, n, v)
    return (
        abs(table[i, 1]) / v + abs(table[i, 2]) + v * (abs(table[i, 3]) + v * (abs(table[i, 4]) + v * abs(table[i, 5])))
    )


@kernel
def _least_over(first, n, factor, second, m, other, price, b0, b1, b2, top_v, best, at):
    """Least of price/v + b0 + b1·v + b2·v² + factor·first(v) + other·second(v) up to ``top_v``, and where it is.

    ``first`` and ``second`` are tables of ``n`` and ``m`` pieces; without a ``second`` m is 0.
    """
    hi = top_v
    i = piece_at(first, n, top_v)
    j = piece_at(second, m, top_v) if m > 0 else 0
    while True:
        lo = first[i, 0]
        a = price + factor * first[i, 1]
        c0 = b0 + factor * first[i, 2]
        c1 = b1 + factor * first[i, 3]
        c2 = b2 + factor * first[i, 4]
        c3 = factor * first[i, 5]
        if m > 0:
            lo = max(lo, second[j, 0])
            a += other * second[j, 1]
            c0 += other * second[j, 2]
            c1 += other * second[j, 3]
            c2 += other * second[j, 4]
            c3 += other * second[j, 5]
        best, at = least_on_piece(a, c0, c1, c2, c3, lo, hi, best, at)
        if lo <= 0.0:
            return best, at
        hi = lo
        if first[i, 0] == lo:
            i -= 1
        if m > 0 and second[j, 0] == lo:
            j -= 1


@kernel
def least_hamiltonian(pieces, pulls, brakes, dynamics, worth, back, r0, r1, r2, load, price, p, p_s, top_v):
    """Lower bound of the least H over all speeds up to ``top_v``, a bound of its rounding error in units of 2⁻⁵³, and
    the speed of the least H.

    ``pieces`` (3, 2n, 6) and the numbers of their rows come from `merge_tables`; ``worth`` and ``back`` are a and η of
    the energy; the load is r0 + r1·v + r2·v², and ``load`` the sum of the magnitudes that make up r0.
    """
    best = math.inf
    at = top_v
    b0 = -2.0 * p * r0
    b1 = -2.0 * p * r1
    b2 = p_s - 2.0 * p * r2
    effort = 0.0
    if 2.0 * p < -worth:
        factor = worth + 2.0 * p
        best, at = _least_over(pieces[0], pulls, factor, pieces[0], 0, 0.0, price, b0, b1, b2, top_v, best, at)
        effort = -factor * _size(pieces[0], pulls, at)
    elif 2.0 * p <= -back:
        best, at = least_on_piece(price, b0, b1, b2, 0.0, 0.0, top_v, best, at)
    elif p <= 0.0:
        factor = -(back + 2.0 * p)
        best, at = _least_over(pieces[2], dynamics, factor, pieces[2], 0, 0.0, price, b0, b1, b2, top_v, best, at)
        effort = -factor * _size(pieces[2], dynamics, at)
    else:
        factor = -2.0 * p
        others = dynamics if back > 0.0 else 0
        best, at = _least_over(pieces[1], brakes, factor, pieces[2], others, -back, price, b0, b1, b2, top_v, best, at)
        effort = -factor * _size(pieces[1], brakes, at)
        if back > 0.0:
            effort += back * _size(pieces[2], dynamics, at)
    size = price / at + effort + (abs(p_s) + 2.0 * abs(p) * r2) * at * at
    size += 2.0 * abs(p) * (load + r1 * at)
    return best, _ROUNDINGS * size, at


@kernel
def standstill_cell(pieces, n, load0, load1, load2, start, length, price, slope, end_w, top_w, worth):
    """Lower bound of time and energy in a cell at whose one end w is (nearly) 0, plus slope·w at the other end.

    The gain of w per metre is at most 2g, g = sup(M − load) after a stop, sup(B + load) before one (``start`` False).
    So w ≤ end_w + 2·g·x, and the time is at least 2d/(√end_w + √(end_w + 2gd)). The energy is at least ``worth`` times
    the work, ½(w − end_w) + d·load(0) of starting and ½(end_w − w) + d·load(0) of stopping: a and η are the slopes of a
    convex e(f).
    """
    w = end_w + 4.0 * length * (max(largest_effort(pieces, n, 0.0, 0.0), 0.0) + abs(load0))
    gain = 0.0
    while True:
        w = min(w, top_w)
        v = math.sqrt(w)
        gain = largest_effort(pieces, n, 0.0, v)
        gain += -load0 if start else load0 + v * (load1 + v * load2)
        gain = max(gain, 0.0)
        if end_w + 2.0 * gain * length <= w or w >= top_w:
            break
        w *= 2.0
    reach = end_w + 2.0 * gain * length
    w = min(w, reach)
    least = price * 2.0 * length / (math.sqrt(end_w) + math.sqrt(reach)) if reach > 0.0 else 0.0
    sign = 0.5 * worth if start else -0.5 * worth
    return least + min(0.0, (sign + slope) * w) - sign * end_w + worth * load0 * length


@kernel
def bound_kernel(train, tables, length, grade, air, cap, node_cap, w, price, left, right, top_v, pieces, bound):
    """Lower bound of E + λT, per unit of inertia.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        Of a kind without a map. Auxiliary power is part of the price.
    length, grade, air : (K,) float64
        Cells: length in m, grade force in N, coefficient of v² in N/(m/s)².
    cap, node_cap : (K,), (K + 1,) float64
        Squared speed that no run passes in the cell, and at its ends, m²/s².
    w : (K + 1,) float64
        Squared speeds of the run that the costates belong to, m²/s²: of use are those at the two ends, and whether
        the cells there are cells of a standstill.
    price : float
        λ per unit of inertia.
    left, right : (K,) float64
        Costate p at the two ends of each cell.
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 2n, 6) float64
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
    worth = tables.traction
    back = tables.regeneration
    r1 = train.davis_b / mass
    first_stands = is_standstill(w[0], w[1])
    last_stands = is_standstill(w[count], w[last])
    pulls = 0
    brakes = 0
    dynamics = 0
    total = 0.0
    sizes = 0.0
    error = 0.0
    for k in range(count):
        d = length[k]
        r0 = (train.davis_a_n + grade[k]) / mass
        r2 = air[k] / mass
        if k == 0 or grade[k] != grade[k - 1] or air[k] != air[k - 1]:
            pulls, brakes, dynamics = merge_tables(train, r0, r1, r2, top_v, pieces)
        if k == 0 and first_stands:
            bound[k] = standstill_cell(pieces[0], pulls, r0, r1, r2, True, d, price, left[1], w[0], cap[k], worth)
            error += _ROUNDINGS * (abs(bound[k]) + worth * (w[0] + abs(r0) * d))
        elif k == last and last_stands:
            bound[k] = standstill_cell(
                pieces[1], brakes, r0, r1, r2, False, d, price, -right[k - 1], w[count], cap[k], back
            )
            error += _ROUNDINGS * (abs(bound[k]) + back * (w[count] + abs(r0) * d))
        else:
            ends = 0.0
            if k == 0:
                ends = left[0] * w[0]
            elif k > 1 or not first_stands:
                ends = min(0.0, left[k] - right[k - 1]) * node_cap[k]
            if k == last:
                ends -= right[k] * w[count]
                error += _ROUNDINGS * abs(right[k] * w[count])
            slope = (right[k] - left[k]) / d
            load = (train.davis_a_n + abs(grade[k])) / mass
            cell_v = min(math.sqrt(cap[k]) * (1.0 + 4.0 * _UNIT_ROUNDOFF), top_v)
            value = 0.0
            for end in range(2):
                p = right[k] if end == 1 else left[k]
                least, size, _ = least_hamiltonian(
                    pieces, pulls, brakes, dynamics, worth, back, r0, r1, r2, load, price, p, slope, cell_v
                )
                value += least
                error += 0.5 * d * size
            bound[k] = 0.5 * d * value + ends
            error += _ROUNDINGS * abs(ends)
        total += bound[k]
        sizes += abs(bound[k])
    return total, (error + (count + 4.0) * sizes) * _UNIT_ROUNDOFF
