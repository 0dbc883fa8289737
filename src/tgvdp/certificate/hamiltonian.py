"""The least value of the Hamiltonian of the certificate over all speeds and efforts, exactly.

All quantities are per unit of inertia: f = F/m_eff the effort, ρ(v) = (A + G + B·v + C·v²)/m_eff the load, λ the price.
Effort costs e(f) = a·f for traction and gives back η·|f| as far as the dynamic brake does it (wheel: a = 1, η = 0). For
p linear over a cell of length d with slope p', every run satisfies

    ∫ (e(f) + λ/v) ds + Δ(p·w) = ∫ H ds,     H(s, v, f) = e(f) + λ/v + p'·v² + 2p·(f − ρ(v))

and, with the largest traction M, dynamic braking D and braking B of all kinds at speed v, e(f) + 2p·f is at least

    (a + 2p)·M if 2p < −a      0 if −a ≤ 2p ≤ −η      −(η + 2p)·D if −η < 2p ≤ 0      −η·D − 2p·B if p > 0.

All factors of an effort are negative. Every piece of an effort is P/v + c0 + c1·v + c2·v² + c3·v³, also where a comfort
limit on the acceleration takes over, so that on each piece

    H(v) ≥ a/v + b0 + b1·v + b2·v² + b3·v³,     v²·H' = −a + b1·v² + 2·b2·v³ + 3·b3·v⁴

whose extremes are separated by the roots of b1 + 3·b2·v + 6·b3·v² = 0.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import piece_at
from tgvdp.certificate.minimum import least_on_piece

#: Roundings in one evaluation of the Hamiltonian: coefficients and value, 40 at most; and a spare factor of 5.
ROUNDINGS = 200.0


@leaf
def _size(table, n, v):
    """Sum of the magnitudes of the terms of an effort at v."""
    i = piece_at(table, n, v)
    return (
        abs(table[i, 1]) / v + abs(table[i, 2]) + v * (abs(table[i, 3]) + v * (abs(table[i, 4]) + v * abs(table[i, 5])))
    )


@kernel
def _least_over(first, n, factor, second, m, other, price, b0, b1, b2, low_v, top_v, best, at):
    """Least of price/v + b0 + b1·v + b2·v² + factor·first(v) + other·second(v) in a range of v, and where it is.

    ``first`` and ``second`` are tables of ``n`` and ``m`` pieces; without a ``second`` m is 0.
    """
    hi = top_v
    i = piece_at(first, n, top_v)
    j = piece_at(second, m, top_v) if m > 0 else 0
    while True:
        lo = max(first[i, 0], low_v)
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
        if lo <= low_v:
            return best, at
        hi = lo
        if first[i, 0] == lo:
            i -= 1
        if m > 0 and second[j, 0] == lo:
            j -= 1


@kernel
def least_hamiltonian(pieces, pulls, brakes, dynamics, worth, back, r0, r1, r2, load, price, p, p_s, low_v, top_v):
    """Lower bound of the least H over all speeds from ``low_v`` to ``top_v``, a bound of its rounding error in units of
    2⁻⁵³, and the speed of the least H.

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
        best, at = _least_over(pieces[0], pulls, factor, pieces[0], 0, 0.0, price, b0, b1, b2, low_v, top_v, best, at)
        effort = -factor * _size(pieces[0], pulls, at)
    elif 2.0 * p <= -back:
        best, at = least_on_piece(price, b0, b1, b2, 0.0, low_v, top_v, best, at)
    elif p <= 0.0:
        factor = -(back + 2.0 * p)
        best, at = _least_over(
            pieces[2], dynamics, factor, pieces[2], 0, 0.0, price, b0, b1, b2, low_v, top_v, best, at
        )
        effort = -factor * _size(pieces[2], dynamics, at)
    else:
        factor = -2.0 * p
        others = dynamics if back > 0.0 else 0
        best, at = _least_over(
            pieces[1], brakes, factor, pieces[2], others, -back, price, b0, b1, b2, low_v, top_v, best, at
        )
        effort = -factor * _size(pieces[1], brakes, at)
        if back > 0.0:
            effort += back * _size(pieces[2], dynamics, at)
    size = price / at + effort + (abs(p_s) + 2.0 * abs(p) * r2) * at * at
    size += 2.0 * abs(p) * (load + r1 * at)
    return best, ROUNDINGS * size, at
