"""The bound of a potential with kinks at some speeds, that may be curved besides.

In each band of speeds between two kinks the potential has a slope of its own:

    φ(s, w) = Σ p_j(s)·(what of w lies in band j) + r(s)·(2/3)·v³

with each costate p_j, and r, linear in a cell. The least of H is then the least of those of all bands, each over its
speeds, and as each of them is concave in s, so is the least: the trapezoid of `cell_bounds` holds. Where costates jump,
between two cells, the potential changes most at w = 0, at a kink, or at the cap.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.cell_bounds import UNIT_ROUNDOFF, Side, cell_kernel
from tgvdp.certificate.efforts import NOT_MERGED, load_in, merged_in, price_in
from tgvdp.certificate.hamiltonian import ROUNDINGS, Hamiltonian
from tgvdp.certificate.slopes import regular_cells

_Floats = NDArray[np.float64]


class Potential(NamedTuple):
    """A potential on cells, per unit of inertia, float64.

    Attributes
    ----------
    edges : (B + 1,)
        Squared speeds at which bands begin and end, m²/s², from 0 to infinity.
    left, right : (K, B)
        Costates of the bands at the two ends of each cell.
    bow : (K + 1,)
        r at the nodes: 0 at both ends of the trip, and of cells of a standstill.
    """

    edges: _Floats
    left: _Floats
    right: _Floats
    bow: _Floats


@leaf
def share_of(edges, j, w):
    """What of w lies in a band."""
    return min(max(w - edges[j], 0.0), edges[j + 1] - edges[j])


@leaf
def curve_of(w):
    """(2/3)·v³ at a squared speed."""
    return 2.0 / 3.0 * w * math.sqrt(w)


@part
def _change(edges, before, after, w):
    """By how much the potential grows at a squared speed where costates change."""
    total, size = 0.0, 0.0
    for j in range(edges.shape[0] - 1):
        by = (after[j] - before[j]) * share_of(edges, j, w)
        total += by
        size += abs(by)
    return total, size


@part
def _jump(edges, before, after, cap_w):
    """The least change of the potential where costates change, and the magnitude of what it is made of."""
    least, size = 0.0, 0.0
    for j in range(1, edges.shape[0]):
        by, size = _change(edges, before, after, min(edges[j], cap_w))
        least = min(least, by)
    return least, size


@part
def _at_end(edges, costates, w):
    """The potential at an end of the trip, and the magnitude of what it is made of."""
    total, size = 0.0, 0.0
    for j in range(costates.shape[0]):
        by = costates[j] * share_of(edges, j, w)
        total += by
        size += abs(by)
    return total, size


@part
def _turned(k, potential, first, node_cap, w):
    """What costates cost that jump at the start of a regular cell, and the potential at the ends of the trip.

    Sum, and sum of magnitudes.
    """
    edges, left, right = potential.edges, potential.left, potential.right
    count = left.shape[0]
    total, size = 0.0, 0.0
    if k > first:
        total, size = _jump(edges, right[k - 1], left[k], node_cap[k])
    elif k == 0:
        total, size = _at_end(edges, left[0], w[0])
    if k == count - 1:
        by, by_size = _at_end(edges, right[k], w[count])
        total -= by
        size += by_size
    return total, size


@part
def _least_of_bands(h, potential, k, d, cell_v, rise, speeds):
    """Lower bounds of H at the ends of a cell, and of the rounding error of their mean; the speeds of each band."""
    edges = potential.edges
    start, end, size, below, below_size = math.inf, math.inf, 0.0, 0.0, 0.0
    for j in range(edges.shape[0] - 1):
        p0, p1 = potential.left[k, j], potential.right[k, j]
        least0, least1, rounding, speeds[0, j], speeds[1, j], _, _ = cell_kernel(
            h, Side(edges[j], edges[j + 1]), p0, p1, potential.bow[k], potential.bow[k + 1], d, cell_v, rise[0], rise[1]
        )
        start, end = min(start, least0 + below), min(end, least1 + below)
        size = max(size, rounding + ROUNDINGS * below_size)
        if edges[j + 1] < math.inf:
            by = (p1 - p0) / d * (edges[j + 1] - edges[j])
            below += by
            below_size += abs(by)
    return start, end, size


@kernel
def bands_kernel(train, tables, cells, caps, w, multiplier, potential, top_v, pieces, bound, doubt, speeds):
    """Lower bounds of E + λT of regular cells, per unit of inertia.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, top_v, pieces, bound, doubt
        As `cell_bounds.bound_kernel` has them; cells of a standstill stay as they are.
    potential : Potential
        Whose kinks are at speeds that no cell of a standstill comes to.
    speeds : (K, 2, B) float64, modified in place
        Speeds of the least values in each band at the two ends of each cell, m/s.
    """
    first, last = regular_cells(w)
    merged = NOT_MERGED
    for k in range(first, last + 1):
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        size = (train.davis_a_n + abs(cells.grade_n[k])) / train.inertia_kg
        h = Hamiltonian(pieces, pulls, brakes, dynamics, tables.traction, tables.regeneration, load, size, price)
        cell_v = min(math.sqrt(caps.cell[k]) * (1.0 + 4.0 * UNIT_ROUNDOFF), top_v)
        start, end, rounding = _least_of_bands(h, potential, k, d, cell_v, caps.rise[k], speeds[k])
        turned, turned_size = _turned(k, potential, first, caps.node, w)
        bound[k] = 0.5 * d * (start + end) + turned
        doubt[k] = d * rounding + ROUNDINGS * turned_size
