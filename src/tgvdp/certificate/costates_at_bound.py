"""Costates along the speed bounds: no run is faster there, so that H need not be stationary at the run.

With H(v) = h(v) + p'·v², h being what effort at its limit and time cost less 2p·ρ(v), the least value over all speeds
up to the run's, v̄, is H(v̄) as long as p' is at most every chord (h(v) − h(v̄))/(v̄² − v²). The tangent at v̄ is the
costate equation; it is the least chord where h is a convex function of w = v², as it is for P/v. It is not where effort
falls steeply with speed: slower trains pull, or brake, harder, and with the tangent the least value of H lies behind
that. With less slope p is larger before the step of a train that pulls, and smaller before that of one that brakes.
"""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
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
from tgvdp.physics.codes import BRAKING, DYNAMIC_BRAKING, TRACTION

#: A run is at the bound if its w is less than this share below: the bound lies a little outside of all runs.
_AT_BOUND = 0.02
#: Chords begin this share below v̄, then further by this factor each, and at the ends of the effort pieces.
_NEAREST, _FURTHER = 1e-4, 1.5
#: Steps by which the least of these chords is closed in on.
_CLOSER = 8
#: Chords below the costate equation by less than this share of λ/v³ tell only how exact its quadrature is.
_SPARE = 0.001
#: Share of a speed that is next to it.
_BESIDE = 1e-9


class FullEffort(NamedTuple):
    """What a train does along the bound: effort at its limit, by traction or by brakes, and the Hamiltonian."""

    pulls: bool
    h: Hamiltonian


@leaf
def _below(table, i, v):
    """Index of the piece up to v, from one that does not end before."""
    while i > 0 and table[i, 0] >= v:
        i -= 1
    return i


@part
def _bare(full, p, i, j, v):
    """Part h(v) of the Hamiltonian that p' has no share in: on piece ``i`` of the effort, j of the dynamic brake."""
    h = full.h
    rest = h.multiplier / v - 2.0 * p * load_at(h.load, v)
    if full.pulls:
        return (h.traction + 2.0 * p) * piece_value(h.pieces[0], i, v) + rest
    returned = piece_value(h.pieces[2], j, v)
    if p <= 0.0:
        return -(h.regeneration + 2.0 * p) * returned + rest
    return -2.0 * p * piece_value(h.pieces[1], i, v) - h.regeneration * returned + rest


@kernel
def tangent_and_excess(full, p, v):
    """Chord of h from just below v, −dh/dw, and how far the least chord from a lower speed is below it."""
    pieces = full.h.pieces[0] if full.pulls else full.h.pieces[1]
    dynamic = full.h.pieces[2]
    i = piece_at(pieces, full.h.pulls if full.pulls else full.h.brakes, v)
    j = piece_at(dynamic, full.h.dynamics, v)
    first, first_dynamic = i, j
    here = _bare(full, p, i, j, v)
    tangent = math.nan
    least = math.inf
    before = v
    fast = v
    slow = v
    u = v * (1.0 - _NEAREST)
    while u > 0.0:
        i = _below(pieces, i, u)
        j = _below(dynamic, j, u)
        chord = (_bare(full, p, i, j, u) - here) / (v * v - u * u)
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
        i, j = _below(pieces, first, left), _below(dynamic, first_dynamic, left)
        chord = (_bare(full, p, i, j, left) - here) / (v * v - left * left)
        i, j = _below(pieces, first, right), _below(dynamic, first_dynamic, right)
        other = (_bare(full, p, i, j, right) - here) / (v * v - right * right)
        least = min(least, chord, other)
        if chord < other:
            fast = right
        else:
            slow = left
    return tangent, tangent - least


@leaf
def _at_bound(cap, w, k):
    return w[k] > 0.0 and w[k + 1] > 0.0 and max(w[k], w[k + 1]) >= cap[k] * (1.0 - _AT_BOUND)


@leaf
def _full_in(train, tables, cells, k, multiplier, pulls, pieces, merged):
    load, price = load_in(train, cells, k), price_in(train, cells, k, multiplier)
    _, pulling, braking, dynamics = merged
    return FullEffort(
        pulls,
        Hamiltonian(pieces, pulling, braking, dynamics, tables.traction, tables.regeneration, load, 0.0, price),
    )


@kernel
def raise_pulling(train, tables, multiplier, cells, cap, w, label, top_v, pieces, left, right):
    """Integrate p anew where a chord is below the costate equation, back to the start of a phase of full traction.

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
        if not raised or right[k] > after:  # p may jump down where the run touches the limit
            p = right[k]
            raised = False
        after = left[k]
        # above the level: regimes too short to be seen
        if label[k] != TRACTION or not _at_bound(cap, w, k) or p > hold:
            raised = False
            continue
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        full = _full_in(train, tables, cells, k, multiplier, True, pieces, merged)
        d = cells.length_m[k]
        fast = math.sqrt(w[k + 1])
        tangent, excess = tangent_and_excess(full, p, fast)
        raised = raised or excess > _SPARE * full.h.multiplier / (fast * fast * fast)
        if not raised:
            continue
        before = min(p - d * (tangent - excess), hold)
        other, excess_before = tangent_and_excess(full, before, math.sqrt(w[k]))
        right[k] = p
        p = min(p - d * (0.5 * (tangent + other) - max(excess, excess_before)), hold)
        left[k] = p


@kernel
def lower_braking(train, tables, multiplier, cells, cap, w, label, top_v, pieces, left, right):
    """Integrate p anew where a chord is below the costate equation, on to the end of a phase of full braking.

    Parameters and what is modified as `raise_pulling` has them.
    """
    merged = NOT_MERGED
    lowered = False
    p = 0.0
    before = 0.0
    for k in range(cells.length_m.shape[0]):
        if not lowered:
            p = left[k]
        elif left[k] < before:  # p jumps down where the run touches the limit
            p = min(p, left[k])
            lowered = False
        before = right[k]
        # below the level braking would cost more than it is worth
        level = 0.0 if label[k] == BRAKING else -0.5 * tables.regeneration
        if label[k] not in (BRAKING, DYNAMIC_BRAKING) or not _at_bound(cap, w, k) or p < level:
            lowered = False
            continue
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        full = _full_in(train, tables, cells, k, multiplier, False, pieces, merged)
        d = cells.length_m[k]
        # a step of a braking rate at an end of the cell is beyond it
        fast, slow = math.sqrt(w[k]) * (1.0 - _BESIDE), math.sqrt(w[k + 1]) * (1.0 + _BESIDE)
        tangent, excess = tangent_and_excess(full, p, fast)
        other, excess_after = tangent_and_excess(full, max(p + d * (tangent - excess), level), slow)
        lowered = lowered or max(excess, excess_after) > _SPARE * full.h.multiplier / (fast * fast * fast)
        if not lowered:
            continue
        left[k] = p
        p = max(p + d * (0.5 * (tangent + other) - max(excess, excess_after)), level)
        right[k] = p
