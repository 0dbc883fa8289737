"""Up to which energy a label is of use, by cell of its earliest arrival: Z of `exact_bounds`, one node at a time."""

import numpy as np

from tgvdp._jit import leaf
from tgvdp.methods.grid.exact_bounds import CELLS


@leaf
def cell_of(bounds, node, time_s):
    """Cell in which a label may arrive at the earliest."""
    cell = (time_s + bounds.to_go_s[node] - bounds.arrivals.label_from_s) * bounds.arrivals.cells_per_s
    return int(min(max(cell, 0.0), CELLS - 1.0))


@leaf
def _line_at(multiplier_j_per_s, least_cost_j, node, line, time_s):
    """Move on to the line that bounds the energy at a time, which grows from call to call; by falling slope."""
    least_j = least_cost_j[line, node] - multiplier_j_per_s[line] * time_s
    while line + 1 < multiplier_j_per_s.size:
        next_j = least_cost_j[line + 1, node] - multiplier_j_per_s[line + 1] * time_s
        if next_j < least_j:
            break
        line += 1
        least_j = next_j
    return line, least_j


@leaf
def _last_promising(bounds, node, first):
    """Last cell from ``first`` on in which a path through a node may beat the known ones, else -1."""
    line = bounds.multiplier_j_per_s.size - 1
    for cell in range(CELLS - 1, first - 1, -1):
        arrival_s = bounds.arrivals.begin_s + (cell + 1) * bounds.arrivals.cell_s
        least_j = bounds.through_cost_j[line, node] - bounds.multiplier_j_per_s[line] * arrival_s
        while line > 0:
            next_j = bounds.through_cost_j[line - 1, node] - bounds.multiplier_j_per_s[line - 1] * arrival_s
            if next_j < least_j:
                break
            line -= 1
            least_j = next_j
        if least_j < bounds.known_j[cell]:
            return cell
    return -1


@leaf
def _first_promising(bounds, node, first, last):
    """First cell in which a path through a node may beat the known ones; there is one up to ``last``."""
    line = 0
    for cell in range(first, last):
        arrival_s = bounds.arrivals.begin_s + (cell + 1) * bounds.arrivals.cell_s
        line, least_j = _line_at(bounds.multiplier_j_per_s, bounds.through_cost_j, node, line, arrival_s)
        if least_j < bounds.known_j[cell]:
            return cell
    return last


@leaf
def fill_ceiling(bounds, node, hull_j, best, ceiling_j):
    """Tabulate Z of a node from its first label's cell on; ``hull_j`` and ``best`` are scratch, (CELLS,).

    Returns False where Z rules out everything. H is convex, so that the arrival that leaves most room grows with the
    cell of the label: that of each cell is sought between those of its neighbours, in O(n log n) steps for all cells.
    """
    first = cell_of(bounds, node, bounds.earliest_s[node])
    last = _last_promising(bounds, node, first)
    if last < 0:
        return False
    start = _first_promising(bounds, node, first, last)
    n_cells = last + 1 - first
    line = 0
    for k in range(n_cells):
        to_go_s = bounds.to_go_s[node] + (k + 1) * bounds.arrivals.cell_s
        line, hull_j[k] = _line_at(bounds.multiplier_j_per_s, bounds.least_cost_j, node, line, to_go_s)
    ceiling_j[last + 1 :] = -np.inf
    stride = CELLS
    while stride > 0:
        for b in range(0 if stride == CELLS else stride, n_cells, 2 * stride):
            low = max(b, best[b - stride]) if b > 0 else start - first
            high = best[b + stride] if b + stride < n_cells else n_cells - 1
            most_j = -np.inf
            for c in range(low, high + 1):
                room_j = bounds.known_j[first + c] - hull_j[c - b]
                if room_j > most_j:
                    most_j = room_j
                    best[b] = c
            ceiling_j[first + b] = most_j
        stride >>= 1
    return True
