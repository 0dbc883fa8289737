"""Costates of full traction along the speed bound: no run is faster there, so that H need not be stationary at the run.

With H(v) = h(v) + p'·v² and h(v) = κ·M(v) + λ/v − 2p·ρ(v), κ = a + 2p < 0, the least value over all speeds up to the
run's, v̄, is H(v̄) as long as p' is at most every chord (h(v) − h(v̄))/(v̄² − v²). The tangent at v̄ is the costate
equation; it is the least chord where h is a convex function of w = v², as it is for P/v. Where effort falls steeply it
is not: behind a drop slower trains pull harder, and with the tangent the least value of H lies before the drop.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import (
    NOT_MERGED,
    load_at,
    load_in,
    merged_in,
    piece_at,
    piece_value,
    price_in,
)
from tgvdp.certificate.hamiltonian import Hamiltonian
from tgvdp.physics.codes import TRACTION

#: A run is at the bound if its w is less than this share below: the bound lies a little outside of all runs.
_AT_BOUND = 0.02
#: Chords begin this share below v̄, then further by this factor each, and at the ends of the effort pieces.
_NEAREST, _FURTHER = 1e-4, 1.5
#: Steps by which the least of these chords is closed in on.
_CLOSER = 8
#: Chords below the costate equation by less than this share of λ/v³ tell only how exact its quadrature is.
_SPARE = 0.001


@leaf
def _bare(h, p, i, v):
    """The part h(v) of the Hamiltonian that p' has no share in, on piece ``i``."""
    factor = h.traction + 2.0 * p
    return factor * piece_value(h.pieces[0], i, v) + h.multiplier / v - 2.0 * p * load_at(h.load, v)


@kernel
def tangent_and_excess(h, p, v):
    """Chord of h from just below v, −dh/dw, and how far the least chord from a lower speed is below it."""
    pieces = h.pieces[0]
    n = h.pulls
    i = piece_at(pieces, n, v)
    here = _bare(h, p, i, v)
    tangent = math.nan
    least = math.inf
    before = v
    fast = v
    slow = v
    u = v * (1.0 - _NEAREST)
    while u > 0.0:
        while i > 0 and pieces[i, 0] >= u:
            i -= 1
        chord = (_bare(h, p, i, u) - here) / (v * v - u * u)
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
        chord = (_bare(h, p, i, left) - here) / (v * v - left * left)
        other = (_bare(h, p, j, right) - here) / (v * v - right * right)
        least = min(least, chord, other)
        if chord < other:
            fast = right
        else:
            slow = left
    return tangent, tangent - least


@kernel
def raise_costates(train, tables, multiplier, cells, cap, w, label, top_v, pieces, left, right):
    """Integrate p anew where a chord is below the costate equation, back to the start of the phase.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
    multiplier : float
        λ per unit of inertia.
    cells : Cells
    cap : (K,) float64
        Squared speed that no run passes, m²/s².
    w : (K + 1,) float64
        Squared speed of the run at their ends, m²/s².
    label : (K,) int8
        Regimes.
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 3n, 6) float64
        Scratch for the pieces of the effort curves.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell.
    """
    hold = -0.5 * tables.traction  # above it full traction would cost more than it is worth: p stays at or below
    merged = NOT_MERGED
    raised = False
    p = 0.0
    after = 0.0
    for k in range(cells.length_m.shape[0] - 1, -1, -1):
        at_bound = w[k] > 0.0 and max(w[k], w[k + 1]) >= cap[k] * (1.0 - _AT_BOUND)
        if not raised or right[k] > after:  # p may jump down where the run touches the limit
            p = right[k]
            raised = False
        after = left[k]
        if label[k] != TRACTION or not at_bound or p > hold:  # above the level: regimes too short to be seen
            raised = False
            continue
        load = load_in(train, cells, k)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        price = price_in(train, cells, k, multiplier)
        h = Hamiltonian(pieces, merged.pulls, 0, 0, tables.traction, tables.regeneration, load, 0.0, price)
        d = cells.length_m[k]
        fast = math.sqrt(w[k + 1])
        tangent, excess = tangent_and_excess(h, p, fast)
        raised = raised or excess > _SPARE * price / (fast * fast * fast)
        if not raised:
            continue
        before = min(p - d * (tangent - excess), hold)
        other, excess_before = tangent_and_excess(h, before, math.sqrt(w[k]))
        right[k] = p
        p = min(p - d * (0.5 * (tangent + other) - max(excess, excess_before)), hold)
        left[k] = p
