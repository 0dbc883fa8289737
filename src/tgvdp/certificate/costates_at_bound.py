"""Costates of full traction along the ceiling: no run is faster there, so that H need not be stationary at the run.

With H(v) = h(v) + p'·v² and h(v) = κ·M(v) + λ/v − 2p·ρ(v), κ = a + 2p < 0, the least value over all speeds up to the
run's, v̄, is H(v̄) as long as p' is at most every chord (h(v) − h(v̄))/(v̄² − v²). The tangent at v̄ is the costate
equation; it is the least chord where h is a convex function of w = v², as it is for P/v. Where effort falls steeply it
is not: behind a drop slower trains pull harder, and with the tangent the least value of H lies before the drop.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import merge_tables, piece_at, piece_value
from tgvdp.certificate.regimes import TRACTION

#: A run is at the ceiling if its w is less than this share below: the ceiling lies a little outside of all runs.
_AT_CEILING = 0.02
#: Chords begin this share below v̄, then further by this factor each, and at the ends of the effort pieces.
_NEAREST, _FURTHER = 1e-4, 1.5
#: Steps by which the least of these chords is closed in on.
_CLOSER = 8
#: Chords below the costate equation by less than this share of λ/v³ tell only how exact its quadrature is.
_SPARE = 0.001


@leaf
def _bare(pieces, i, v, factor, price, p, r0, r1, r2):
    """The part h(v) of the Hamiltonian that p' has no share in, on piece ``i``."""
    return factor * piece_value(pieces, i, v) + price / v - 2.0 * p * (r0 + v * (r1 + v * r2))


@kernel
def tangent_and_excess(pieces, n, worth, price, p, r0, r1, r2, v):
    """Chord of h from just below v, −dh/dw, and how far the least chord from a lower speed is below it.

    ``pieces`` (n, 6) are those of traction, ``worth`` is a, and the load is r0 + r1·v + r2·v².
    """
    factor = worth + 2.0 * p
    i = piece_at(pieces, n, v)
    here = _bare(pieces, i, v, factor, price, p, r0, r1, r2)
    tangent = math.nan
    least = math.inf
    before = v
    fast = v
    slow = v
    u = v * (1.0 - _NEAREST)
    while u > 0.0:
        while i > 0 and pieces[i, 0] >= u:
            i -= 1
        chord = (_bare(pieces, i, u, factor, price, p, r0, r1, r2) - here) / (v * v - u * u)
        further = max(v - _FURTHER * (v - u), pieces[i, 0])
        if math.isnan(tangent):
            tangent = chord
        if chord < least:
            least = chord
            fast = before
            slow = further
        before = u
        u = further
    if least == tangent:
        return tangent, 0.0
    for _ in range(_CLOSER):  # by thirds: it lies between the neighbours of the least one
        left = slow + (fast - slow) / 3.0
        right = fast - (fast - slow) / 3.0
        i = piece_at(pieces, n, left)
        j = piece_at(pieces, n, right)
        chord = (_bare(pieces, i, left, factor, price, p, r0, r1, r2) - here) / (v * v - left * left)
        other = (_bare(pieces, j, right, factor, price, p, r0, r1, r2) - here) / (v * v - right * right)
        least = min(least, chord, other)
        if chord < other:
            fast = right
        else:
            slow = left
    return tangent, tangent - least


@kernel
def raise_costates(train, worth, price, hold, length, grade, air, cap, w, label, top_v, pieces, left, right):
    """Integrate p anew where a chord is below the costate equation, back to the start of the phase.

    Parameters
    ----------
    train : KernelTrain
    worth : float
        Price a of a joule of traction work.
    price : float
        λ per unit of inertia.
    hold : float
        Level −a/2 of p. Above it full traction would cost more than it is worth: p stays at or below.
    length, grade, air, cap : (K,) float64
        Cells: length in m, grade force in N, coefficient of v² in N/(m/s)², squared speed that no run passes, m²/s².
    w : (K + 1,) float64
        Squared speed of the run at their ends, m²/s².
    label : (K,) int8
        Regimes (`certificate.regimes`).
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 2n, 6) float64
        Scratch for the pieces of the effort curves.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell.
    """
    mass = train.inertia_kg
    r1 = train.davis_b / mass
    r0 = 0.0
    r2 = 0.0
    pulls = 0
    merged = 0
    raised = False
    p = 0.0
    after = 0.0
    for k in range(length.shape[0] - 1, -1, -1):
        at_ceiling = w[k] > 0.0 and max(w[k], w[k + 1]) >= cap[k] * (1.0 - _AT_CEILING)
        if not raised or right[k] > after:  # p may jump down where the run touches the limit
            p = right[k]
            raised = False
        after = left[k]
        if label[k] != TRACTION or not at_ceiling or p > hold:  # above the level: regimes too short to be seen
            raised = False
            continue
        if pulls == 0 or grade[k] != grade[merged] or air[k] != air[merged]:
            merged = k
            r0 = (train.davis_a_n + grade[k]) / mass
            r2 = air[k] / mass
            pulls, _, _ = merge_tables(train, r0, r1, r2, top_v, pieces)
        d = length[k]
        fast = math.sqrt(w[k + 1])
        tangent, excess = tangent_and_excess(pieces[0], pulls, worth, price, p, r0, r1, r2, fast)
        raised = raised or excess > _SPARE * price / (fast * fast * fast)
        if not raised:
            continue
        before = min(p - d * (tangent - excess), hold)
        other, excess_before = tangent_and_excess(pieces[0], pulls, worth, price, before, r0, r1, r2, math.sqrt(w[k]))
        right[k] = p
        p = min(p - d * (0.5 * (tangent + other) - max(excess, excess_before)), hold)
        left[k] = p
