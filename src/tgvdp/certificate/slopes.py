"""How a bound changes with its costates: value and derivatives of each cell's bound.

The derivatives of a least value of H are those of H where it is taken. With effort f, load ρ and speed v there

    ∂H/∂p = 2(f − ρ),     ∂H/∂p' = v²,     ∂²H/∂(p, p')² = −g·gᵀ/H_vv,     g = (2(f − ρ)_v, 2v),

the last only where v is no end of a range of speeds. At the levels −a/2, −η/2 and 0 of p the regime changes, and the
derivative by p steps down by twice the effort that is added or taken away.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.cell_bounds import (
    UNIT_ROUNDOFF,
    WHOLE,
    cell_kernel,
    standstill_cell,
    standstill_terms,
)
from tgvdp.certificate.efforts import NOT_MERGED, load_at, load_in, merged_in, piece_at, piece_value, price_in
from tgvdp.certificate.hamiltonian import Hamiltonian
from tgvdp.certificate.regimes import is_standstill

#: Columns of `fill_slopes`: derivatives of a least value by p, on the lower side of a level, and by p'; where it is
#: taken, m/s; of ∂H/∂v by p; H_vv, infinite where v is an end of a range; efforts of traction, of the dynamic brake (of
#: all brakes where that returns nothing) and of all brakes; and, at the start of a cell, its bound.
BY_P, BY_SLOPE, SPEED, TURN, STIFF, PULL, DYNAMIC, BRAKES, VALUE = range(9)
SLOPES = 9
#: |v·∂H/∂v| below this share of λ/v is none.
_FLAT = 1e-4


@leaf
def regular_cells(w):
    """First and last cell that are no cells of a standstill, which have the costates of their neighbours."""
    last = w.shape[0] - 2
    return (1 if is_standstill(w[0], w[1]) else 0), (last - 1 if is_standstill(w[last + 1], w[last]) else last)


@part
def _effort(table, n, v):
    """Effort and its first two derivatives at v, of the larger piece where two meet."""
    i = piece_at(table, n, v)
    if i > 0 and table[i, 0] == v and piece_value(table, i - 1, v) > piece_value(table, i, v):
        i -= 1
    hyperbolic = table[i, 1] / (v * v)
    first = table[i, 3] + v * (2.0 * table[i, 4] + v * 3.0 * table[i, 5]) - hyperbolic
    second = 2.0 * table[i, 4] + v * 6.0 * table[i, 5] + 2.0 * hyperbolic / v
    return piece_value(table, i, v), first, second


@part
def _fill_end(h, p, slope, v, slopes):
    """Derivatives of the least value of H that is taken at v, into the columns of `slopes`."""
    pull, pull_v, pull_vv = _effort(h.pieces[0], h.pulls, v)
    brakes, brakes_v, brakes_vv = _effort(h.pieces[1], h.brakes, v)
    dynamic = 0.0
    dynamic_v = 0.0
    dynamic_vv = 0.0
    if h.regeneration > 0.0:
        dynamic, dynamic_v, dynamic_vv = _effort(h.pieces[2], h.dynamics, v)
    f = 0.0
    f_v = 0.0
    f_vv = 0.0
    cost_v = -h.regeneration * dynamic_v
    cost_vv = -h.regeneration * dynamic_vv
    if 2.0 * p <= -h.traction:
        f, f_v, f_vv = pull, pull_v, pull_vv
        cost_v, cost_vv = h.traction * pull_v, h.traction * pull_vv
    elif 2.0 * p <= -h.regeneration:
        cost_v = cost_vv = 0.0
    elif p <= 0.0:
        f, f_v, f_vv = -dynamic, -dynamic_v, -dynamic_vv
    else:
        f, f_v, f_vv = -brakes, -brakes_v, -brakes_vv
    slopes[BY_P] = 2.0 * (f - load_at(h.load, v))
    slopes[BY_SLOPE] = v * v
    slopes[SPEED] = v
    slopes[TURN] = 2.0 * (f_v - h.load.r1 - 2.0 * h.load.r2 * v)
    by_v = cost_v + p * slopes[TURN] - h.multiplier / (v * v) + 2.0 * slope * v
    stiff = cost_vv + 2.0 * p * (f_vv - 2.0 * h.load.r2) + 2.0 * h.multiplier / (v * v * v) + 2.0 * slope
    flat = abs(by_v) * v * v <= _FLAT * h.multiplier and stiff > 0.0
    slopes[STIFF] = stiff if flat else math.inf
    slopes[PULL] = pull
    slopes[DYNAMIC] = dynamic if h.regeneration > 0.0 else brakes
    slopes[BRAKES] = brakes


@kernel
def fill_slopes(train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, slopes, ends):
    """Sum of the bounds of all cells for given costates, per unit of inertia, and how it changes with them.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, left, right, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    slopes : (K, 2, SLOPES) float64, modified in place
        Derivatives at the two ends of each cell.
    ends : (2,) float64, modified in place
        Largest w at the ends of the cells of a standstill at origin and destination; w there, where none is.
    """
    count = left.shape[0]
    first, last = regular_cells(w)
    total = 0.0
    if first > 0:
        load = load_in(train, cells, 0)
        pulls = merged_in(train, cells, 0, top_v, pieces, NOT_MERGED).pulls
        price = price_in(train, cells, 0, multiplier)
        rest, ends[0] = standstill_terms(
            pieces[0], pulls, load, True, cells.length_m[0], price, w[0], caps.cell[0], tables.traction
        )
        total += standstill_cell(rest, ends[0], True, left[first], tables.traction)
    else:
        ends[0] = w[0]
        total += left[0] * w[0]
    if last < count - 1:
        load = load_in(train, cells, count - 1)
        brakes = merged_in(train, cells, count - 1, top_v, pieces, NOT_MERGED).brakes
        price = price_in(train, cells, count - 1, multiplier)
        rest, ends[1] = standstill_terms(
            pieces[1], brakes, load, False, cells.length_m[count - 1], price, w[count], caps.cell[count - 1],
            tables.regeneration,
        )  # fmt: skip
        total += standstill_cell(rest, ends[1], False, -right[last], tables.regeneration)
    else:
        ends[1] = w[count]
        total -= right[last] * w[count]
    merged = NOT_MERGED
    for k in range(first, last + 1):
        load = load_in(train, cells, k)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        price = price_in(train, cells, k, multiplier)
        h = Hamiltonian(pieces, pulls, brakes, dynamics, tables.traction, tables.regeneration, load, 0.0, price)
        if k > first:
            total += min(0.0, left[k] - right[k - 1]) * caps.node[k]
        d = cells.length_m[k]
        cell_v = min(math.sqrt(caps.cell[k]) * (1.0 + 4.0 * UNIT_ROUNDOFF), top_v)
        rise = caps.rise[k]
        start, end, _, v0, v1, tilt0, tilt1 = cell_kernel(
            h, WHOLE, left[k], right[k], 0.0, 0.0, d, cell_v, rise[0], rise[1]
        )
        slope = (right[k] - left[k]) / d
        _fill_end(h, left[k], slope + tilt0, v0, slopes[k, 0])
        _fill_end(h, right[k], slope + tilt1, v1, slopes[k, 1])
        total += 0.5 * d * (start + end)
        slopes[k, 0, VALUE] = 0.5 * d * (start + end)
    return total
