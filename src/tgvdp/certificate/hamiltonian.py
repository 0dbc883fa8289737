"""The least value of the Hamiltonian of the certificate over all speeds and efforts, exactly.

All quantities are per unit of inertia: f = F/m_eff the effort, ρ(v) = (A + G + B·v + C·v²)/m_eff the load, λ the
multiplier. Effort costs e(f) = a·f for traction and gives back η·|f| as far as the dynamic brake does it (wheel: a = 1,
η = 0). For p linear over a cell of length d with slope p', every run satisfies

    ∫ (e(f) + λ/v) ds + Δ(p·w) = ∫ H ds,     H(s, v, f) = e(f) + λ/v + p'·v² + 2p·(f − ρ(v))

and, with the largest traction M, dynamic braking D and braking B of all kinds at speed v, e(f) + 2p·f is at least

    (a + 2p)·M if 2p < −a      0 if −a ≤ 2p ≤ −η      −(η + 2p)·D if −η < 2p ≤ 0      −η·D − 2p·B if p > 0.

All factors of an effort are negative. Every piece of an effort is P/v + c0 + c1·v + c2·v² + c3·v³, also where a comfort
limit on the acceleration takes over, so that on each piece

    H(v) ≥ a/v + b0 + b1·v + b2·v² + b3·v³,     v²·H' = −a + b1·v² + 2·b2·v³ + 3·b3·v⁴

whose extremes are separated by the roots of b1 + 3·b2·v + 6·b3·v² = 0.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import Load, piece_at
from tgvdp.physics.minimum import least_on_piece

#: Roundings in one evaluation of the Hamiltonian: coefficients and value, 40 at most; and a spare factor of 5.
ROUNDINGS = 200.0


class Hamiltonian(NamedTuple):
    """What H is made of in one cell, per unit of inertia.

    Attributes
    ----------
    pieces : (3, 3n, 6) float64
        Effort pieces of traction, all brakes and the dynamic brake, from `merge_tables`.
    pulls, brakes, dynamics : int
        Numbers of their rows.
    traction, regeneration : float
        a and η of the energy, as in `EnergyTables`.
    load : Load
    size : float
        Sum of the magnitudes that make up r0 of the load.
    multiplier : float
        λ.
    """

    pieces: NDArray[np.float64]
    pulls: int
    brakes: int
    dynamics: int
    traction: float
    regeneration: float
    load: Load
    size: float
    multiplier: float


@leaf
def effort_size(table, n, v):
    """Sum of the magnitudes of the terms of an effort at v."""
    i = piece_at(table, n, v)
    return (
        abs(table[i, 1]) / v + abs(table[i, 2]) + v * (abs(table[i, 3]) + v * (abs(table[i, 4]) + v * abs(table[i, 5])))
    )


@kernel
def _least_over(first, n, factor, second, m, other, terms, low_v, top_v):
    """Least of a/v + b0 + b1·v + b2·v² + factor·first(v) + other·second(v) in a range of v, and where it is.

    ``first`` and ``second`` are tables of ``n`` and ``m`` pieces; without a ``second`` m is 0. ``terms`` are a, b0, b1
    and b2.
    """
    best = math.inf
    at = top_v
    hi = top_v
    i = piece_at(first, n, top_v)
    j = piece_at(second, m, top_v) if m > 0 else 0
    while True:
        lo = max(first[i, 0], low_v)
        a = terms[0] + factor * first[i, 1]
        c0 = terms[1] + factor * first[i, 2]
        c1 = terms[2] + factor * first[i, 3]
        c2 = terms[3] + factor * first[i, 4]
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
def least_hamiltonian(h, p, p_s, low_v, top_v):
    """Lower bound of the least H over all speeds from ``low_v`` to ``top_v``, a bound of its rounding error in units of
    2⁻⁵³, and the speed of the least H; for costate p and its slope.
    """
    pull, brake, dynamic = h.pieces[0], h.pieces[1], h.pieces[2]
    load = h.load
    terms = (h.multiplier, -2.0 * p * load.r0, -2.0 * p * load.r1, p_s - 2.0 * p * load.r2)
    effort = 0.0
    if 2.0 * p < -h.traction:
        factor = h.traction + 2.0 * p
        best, at = _least_over(pull, h.pulls, factor, pull, 0, 0.0, terms, low_v, top_v)
        effort = -factor * effort_size(pull, h.pulls, at)
    elif 2.0 * p <= -h.regeneration:
        best, at = least_on_piece(*terms, 0.0, low_v, top_v, math.inf, top_v)
    elif p <= 0.0:
        factor = -(h.regeneration + 2.0 * p)
        best, at = _least_over(dynamic, h.dynamics, factor, dynamic, 0, 0.0, terms, low_v, top_v)
        effort = -factor * effort_size(dynamic, h.dynamics, at)
    else:
        factor = -2.0 * p
        others = h.dynamics if h.regeneration > 0.0 else 0
        best, at = _least_over(brake, h.brakes, factor, dynamic, others, -h.regeneration, terms, low_v, top_v)
        effort = -factor * effort_size(brake, h.brakes, at)
        if h.regeneration > 0.0:
            effort += h.regeneration * effort_size(dynamic, h.dynamics, at)
    size = h.multiplier / at + effort + (abs(p_s) + 2.0 * abs(p) * load.r2) * at * at
    size += 2.0 * abs(p) * (h.size + load.r1 * at)
    return best, ROUNDINGS * size, at
