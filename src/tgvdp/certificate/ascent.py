"""Better costates for a bound: ascent on all of them at once.

The bound is a sum over cells, each of the costates at its two ends and no others, and concave in all of them: a chain.
So the best of all combinations of small steps, down, none or up at both ends of every cell, is found exactly by dynamic
programming along the chain (Bellman 1957). A pass never lowers the bound; where it gains no more, the steps are halved.
Whatever comes out is as valid as any other costate.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.certificate.cell_bounds import UNIT_ROUNDOFF, cell_kernel, standstill_cell
from tgvdp.certificate.efforts import load_in, merge_tables, price_in, same_forces, train_in
from tgvdp.certificate.hamiltonian import Hamiltonian
from tgvdp.certificate.regimes import is_standstill

#: Steps at an end of a cell: down, none, up.
STEPS = 3


@part
def _across_cell(h, left, left_step, right, right_step, length, top_v, rise, ahead, arrived, came):
    """Best value ``arrived`` at the right end of a cell for each step there, and the step at its left end behind it."""
    for i in range(STEPS):
        arrived[i] = -math.inf
        for j in range(STEPS):
            p0 = left + (j - 1) * left_step
            p1 = right + (i - 1) * right_step
            value = ahead[j] + length * cell_kernel(h, p0, p1, length, top_v, rise[0], rise[1])[0]
            if value > arrived[i]:
                arrived[i] = value
                came[i] = j


@part
def _across_jump(right, right_step, left, left_step, node_w, arrived, ahead, came):
    """Best value ``ahead`` at the left end of a cell for each step there, with the jump of p, and what is behind it."""
    for j in range(STEPS):
        ahead[j] = -math.inf
        for i in range(STEPS):
            jump = left + (j - 1) * left_step - right - (i - 1) * right_step
            value = arrived[i] + min(0.0, jump) * node_w
            if value > ahead[j]:
                ahead[j] = value
                came[j] = i


@kernel
def best_steps(train, tables, cells, caps, w, multiplier, left, right, size, top_v, pieces, ends, came):
    """Take the best steps of the costates at all ends of all cells; ``left``, ``right`` (K,) in place.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, left, right, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    size : (K, 2) float64
        Length of a step at the two ends of each cell.
    ends : (2, 3) float64
        Scratch: best values at the left and the right end of a cell.
    came : (K, 2, 3) int8
        Scratch: the steps behind them.

    Returns
    -------
    float
        The sum of the bounds of all cells, per unit of inertia.
    """
    count = left.shape[0]
    starts = is_standstill(w[0], w[1])  # cells of a standstill have the costates of their neighbours
    stops = is_standstill(w[count], w[count - 1])
    first = 1 if starts else 0
    last = count - 2 if stops else count - 1
    ahead = ends[0]
    arrived = ends[1]
    merged = -1
    pulls = 0
    brakes = 0
    dynamics = 0
    for k in range(first, last + 1):
        load = load_in(train, cells, k)
        if merged < 0 or not same_forces(cells, k, merged):
            merged = k
            pulls, brakes, dynamics = merge_tables(train_in(train, cells, k), load, top_v, pieces)
        if k > first:
            _across_jump(
                right[k - 1], size[k - 1, 1], left[k], size[k, 0], caps.node[k], arrived, ahead, came[k, 0]
            )  # fmt: skip
        else:
            for j in range(STEPS):
                p = left[k] + (j - 1) * size[k, 0]
                ahead[j] = p * w[0]
                if starts:
                    ahead[j] = standstill_cell(
                        pieces[0], pulls, load_in(train, cells, 0), True, cells.length_m[0],
                        price_in(train, cells, 0, multiplier), p, w[0], caps.cell[0], tables.traction,
                    )  # fmt: skip
        rounding = 0.0
        h = Hamiltonian(
            pieces,
            pulls,
            brakes,
            dynamics,
            tables.traction,
            tables.regeneration,
            load,
            rounding,
            price_in(train, cells, k, multiplier),
        )
        cell_v = min(math.sqrt(caps.cell[k]) * (1.0 + 4.0 * UNIT_ROUNDOFF), top_v)
        _across_cell(
            h, left[k], size[k, 0], right[k], size[k, 1], cells.length_m[k], cell_v, caps.rise[k], ahead, arrived,
            came[k, 1],
        )  # fmt: skip
    total = -math.inf
    step = 1
    for i in range(STEPS):
        p = right[last] + (i - 1) * size[last, 1]
        value = arrived[i] - p * w[count]
        if stops:
            value = arrived[i] + standstill_cell(
                pieces[1], brakes, load_in(train, cells, count - 1), False, cells.length_m[count - 1],
                price_in(train, cells, count - 1, multiplier), -p, w[count], caps.cell[count - 1], tables.regeneration,
            )  # fmt: skip
        if value > total:
            total = value
            step = i
    for k in range(last, first - 1, -1):
        right[k] += (step - 1) * size[k, 1]
        step = came[k, 1, step]
        left[k] += (step - 1) * size[k, 0]
        if k > first:
            step = came[k, 0, step]
    if starts:
        left[0] = right[0] = left[1]
    if stops:
        left[count - 1] = right[count - 1] = right[count - 2]
    return total
