"""The least value of the Hamiltonian where the potential is curved in the speed.

With p·w + r·(2/3)·v³ in place of p·w, w = v², the slope of the potential in w is q(v) = p + r·v, and

    H(s, v, f) = e(f) + λ/v + p'·v² + r'·(2/3)·v³ + 2·q(v)·(f − ρ(v))

is still linear in s for fixed speed and effort where p and r are linear in a cell. For fixed speed the best effort
depends on q as on p elsewhere (`certificate.hamiltonian`): it changes where q passes one of the three levels −a/2, −η/2
and 0. As q is linear in v, and r is not 0, each level is passed at one speed at most, so that speeds are at most four
ranges of one regime each. In each of them and on each piece of an effort, with any factor F + G·v of one sign,

    H ≥ a/v + b0 + b1·v + b2·v² + b3·v³ + b4·v⁴,

b4 = G·c3. Few efforts have a c3; where one has, v⁴ is bounded by cubics on parts of the piece, and all least values are
those of `physics.minimum`. The speed at which a level is passed is rounded: what a neighbouring regime costs there
differs by the rounding of q times the effort, which the size of the rounding error counts.
"""

import math

import numpy as np

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.efforts import piece_at
from tgvdp.certificate.hamiltonian import ROUNDINGS, effort_size, least_hamiltonian
from tgvdp.physics.energy import EnergyTables
from tgvdp.physics.forces import KernelTrain
from tgvdp.physics.minimum import least_on_piece

#: Parts of a piece with a term in v⁴, on each of which that is bounded by a cubic. What this gives away is
#: |b4|·(length of the part/2)⁴ at most.
_PARTS = 8
#: Sum of the magnitudes of the terms of such a cubic, relative to the fourth power of the largest speed of its part.
_CUBIC = 16.0


@leaf
def _cubic_of(rises, lo, hi):
    """Coefficients of a cubic at or below v⁴ from ``lo`` to ``hi`` if the term ``rises`` with it, or at or above it.

    v⁴ less (v − lo)²·(v − hi)², or less (v − lo)·(v − middle)²·(v − hi).
    """
    total = lo + hi
    product = lo * hi
    inner = product if rises else 0.25 * total * total
    return -product * inner, total * (product + inner), -(total * total + product + inner), 2.0 * total


@part
def _least_on_quartic(a, b0, b1, b2, b3, b4, lo, hi, best, at):
    """As `least_on_piece`, of a function with a term b4·v⁴."""
    if b4 == 0.0:
        return least_on_piece(a, b0, b1, b2, b3, lo, hi, best, at)
    for i in range(_PARTS):
        u = lo + (hi - lo) * (i / _PARTS)
        v = lo + (hi - lo) * ((i + 1) / _PARTS) if i + 1 < _PARTS else hi
        c0, c1, c2, c3 = _cubic_of(b4 > 0.0, u, v)
        best, at = least_on_piece(
            a, b0 + b4 * c0, b1 + b4 * c1, b2 + b4 * c2, b3 + b4 * c3, u, v, best, at
        )  # fmt: skip
    return best, at


@part
def _least_over(first, n, factor, growth, second, m, other, terms, low_v, top_v, best, at, quartic):
    """Update the least value, where it is, and the largest |b4|·v⁴ by those of a range of v.

    Of the function with ``terms`` a to b3, (factor + growth·v)·first(v) and other·second(v); ``first`` and ``second``
    are tables of ``n`` and ``m`` pieces; without a ``second`` m is 0.
    """
    hi = top_v
    i = piece_at(first, n, top_v)
    j = piece_at(second, m, top_v) if m > 0 else 0
    while True:
        lo = max(first[i, 0], low_v)
        a = terms[0] + factor * first[i, 1]
        b0 = terms[1] + factor * first[i, 2] + growth * first[i, 1]
        b1 = terms[2] + factor * first[i, 3] + growth * first[i, 2]
        b2 = terms[3] + factor * first[i, 4] + growth * first[i, 3]
        b3 = terms[4] + factor * first[i, 5] + growth * first[i, 4]
        b4 = growth * first[i, 5]
        if m > 0:
            lo = max(lo, second[j, 0])
            a += other * second[j, 1]
            b0 += other * second[j, 2]
            b1 += other * second[j, 3]
            b2 += other * second[j, 4]
            b3 += other * second[j, 5]
        quartic = max(quartic, abs(b4) * hi**4)
        best, at = _least_on_quartic(a, b0, b1, b2, b3, b4, lo, hi, best, at)
        if lo <= low_v:
            return best, at, quartic
        hi = lo
        if first[i, 0] == lo:
            i -= 1
        if m > 0 and second[j, 0] == lo:
            j -= 1


@part
def _least_of_regime(h, regime, p, r, terms, low_v, top_v, best, at, quartic):
    """`_least_over` for the effort of a regime: full traction, none, the dynamic brake, or all brakes."""
    pull, brake, dynamic = h.pieces[0], h.pieces[1], h.pieces[2]
    if regime == 0:
        factor = h.traction + 2.0 * p
        return _least_over(pull, h.pulls, factor, 2.0 * r, pull, 0, 0.0, terms, low_v, top_v, best, at, quartic)
    if regime == 1:
        best, at = least_on_piece(*terms, low_v, top_v, best, at)
        return best, at, quartic
    if regime == 2:
        factor = -(h.regeneration + 2.0 * p)
        return _least_over(
            dynamic, h.dynamics, factor, -2.0 * r, dynamic, 0, 0.0, terms, low_v, top_v, best, at, quartic
        )  # fmt: skip
    others = h.dynamics if h.regeneration > 0.0 else 0
    return _least_over(
        brake, h.brakes, -2.0 * p, -2.0 * r, dynamic, others, -h.regeneration, terms, low_v, top_v, best, at, quartic
    )  # fmt: skip


@leaf
def _level(h, i):
    """Level i of q, above which the regime is i + 1."""
    return -0.5 * h.traction if i == 0 else (-0.5 * h.regeneration if i == 1 else 0.0)


@leaf
def regime_at(h, q):
    """Regime of a slope q of the potential: full traction, none, the dynamic brake, or all brakes."""
    regime = 0
    for i in range(3):
        if q > _level(h, i):
            regime = i + 1
    return regime


@kernel
def _least_curved(h, p, p_s, r, r_s, low_v, top_v):
    """`least_at`, with a curved potential."""
    load = h.load
    terms = (
        h.multiplier,
        -2.0 * p * load.r0,
        -2.0 * (p * load.r1 + r * load.r0),
        p_s - 2.0 * (p * load.r2 + r * load.r1),
        2.0 / 3.0 * r_s - 2.0 * r * load.r2,
    )
    best = math.inf
    at = top_v
    quartic = 0.0
    hi = top_v
    for step in range(4):  # from the fastest range of one regime to the slowest
        regime = 3 - step if r > 0.0 else step
        lo = low_v
        if r == 0.0:
            regime = regime_at(h, p)
        elif step < 3:
            lo = max((_level(h, regime - 1 if r > 0.0 else regime) - p) / r, low_v)
        if lo <= hi:
            best, at, quartic = _least_of_regime(h, regime, p, r, terms, lo, hi, best, at, quartic)
            hi = lo
        if lo <= low_v:
            break
    slope = abs(p) + abs(r) * at
    effort = (h.traction + 2.0 * slope) * effort_size(h.pieces[0], h.pulls, at)
    effort += 2.0 * slope * effort_size(h.pieces[1], h.brakes, at)
    effort += (h.regeneration + 2.0 * slope) * effort_size(h.pieces[2], h.dynamics, at)
    size = h.multiplier / at + effort + (abs(p_s) + abs(r_s) * at) * at * at + _CUBIC * quartic
    size += 2.0 * slope * (h.size + at * (load.r1 + at * load.r2))
    return best, ROUNDINGS * size, at


@leaf
def least_at(h, p, p_s, r, r_s, low_v, top_v):
    """Lower bound of the least H over all speeds from ``low_v`` to ``top_v``, a bound of its rounding error in units of
    2⁻⁵³, and the speed of the least H; for p and r and their slopes.
    """
    if r == 0.0 and r_s == 0.0:
        return least_hamiltonian(h, p, p_s, low_v, top_v)
    return _least_curved(h, p, p_s, r, r_s, low_v, top_v)


def is_concave(train: KernelTrain, energy: EnergyTables, price: float, top_mps: float) -> bool:
    """Whether H is concave in w at some speed, where a second costs a price, J/s.

    Of a train that coasts, if the linear part of its resistance falls with w more steeply than what time costs: at the
    highest price of a joule at which it does coast, a/2, that is a·B·v² > 3·λ. Of one that brakes, if braking longer
    returns more than its time costs: the dynamic brake returns η·D, and η·D' < −λ/v² where it falls steeply enough.
    """
    if energy.traction * train.davis_b * top_mps**2 > 3.0 * price:
        return True
    table = train.braking
    ends = np.append(table[1:, 0], np.inf).clip(max=top_mps), table[:, 0]
    falls = [table[:, 1] - v**2 * (table[:, 3] + v * (2.0 * table[:, 4] + v * 3.0 * table[:, 5])) for v in ends]
    used = table[:, 0] < top_mps
    return bool(energy.regeneration * np.max(falls, axis=0)[used].max() > price)
