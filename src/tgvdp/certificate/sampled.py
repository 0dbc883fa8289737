"""Costates and r that are best for sampled speeds: where an ascent of a curved potential begins.

With a few speeds in place of all, and the four efforts of which one is best at each (`certificate.hamiltonian`), the
bound is a sum of least values of linear functions of the costates and of r, and its top a linear program
(`certificate.interior`): no kink is in the way of a step, whether the speed of a least value changes or its effort.
What comes out is no bound before the exact one is taken of it.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.certificate.cell_bounds import curve_of, standstill_terms
from tgvdp.certificate.efforts import NOT_MERGED, load_at, load_in, merged_in, piece_at, piece_value, price_in
from tgvdp.certificate.interior import AT_NODE, BEGIN, Blocks, Program, improve, used_part
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.slopes import regular_cells
from tgvdp.memory import ask_for
from tgvdp.methods.budget import Clock
from tgvdp.physics.energy import EnergyTables
from tgvdp.physics.forces import KernelTrain

_Floats = NDArray[np.float64]

#: Speeds of a cell, relative to the largest one there, and to that of the run.
_OF_LARGEST = np.linspace(0.25, 1.0, 9)
_OF_RUN = np.array([0.9, 0.96, 0.985, 1.0, 1.015, 1.04, 1.1])
_SPEEDS, _EFFORTS = 16, 4
#: Of both ends of a cell, and of a jump beside it.
_ROWS = 2 * _SPEEDS * _EFFORTS + 2
#: Room of the numbers below the least values to begin with, relative to the price of the time that a cell takes.
_ROOM = 0.1
#: Number of cells that are moved between two looks at the clock.
_CELLS_AT_ONCE = 5_000
#: Memory that a cell takes, B.
_CELL_B = 80.0 * _ROWS


@part
def _put(program, i, coef, const):
    """Write a row; returns the next."""
    for j in range(4):
        program.coef[i, j] = coef[j]
    program.const[i] = const
    return i + 1


@part
def _put_end(program, i, end, d, v, f, load, cost):
    """Write the row of a speed and an effort at one end of a cell; returns the next."""
    by_p, w, curve = 2.0 * (f - load), v * v, curve_of(v * v)
    here, bent = 0.5 * d * by_p, 0.5 * d * by_p * v
    if end == 0:
        return _put(program, i, (here - 0.5 * w, bent - 0.5 * curve, 0.5 * w, 0.5 * curve), 0.5 * d * cost)
    return _put(program, i, (-0.5 * w, -0.5 * curve, here + 0.5 * w, bent + 0.5 * curve), 0.5 * d * cost)


@part
def _close(program, g, i, room, unknown):
    """End a group before row i; returns the next group."""
    program.first[g + 1] = i
    program.least[g] = room
    for j in range(4):
        program.unknown[g, j] = unknown[j]
    return g + 1


@part
def _put_pair(program, g, i, node, which, coef, const, room):
    """A group of two rows, 0 and const + coef·(of two unknowns of a node); returns the next group and row."""
    i = _put(program, i, (0.0, 0.0, 0.0, 0.0), 0.0)
    i = _put(program, i, (coef[0], coef[1], 0.0, 0.0), const)
    at = AT_NODE * node
    return _close(program, g, i, room, (at + which, at + 1 - which, at + 2, at + 2)), i


@part
def _put_ends(train, tables, cells, caps, w, multiplier, top_v, pieces, program, g, i):
    """The terms of the ends of the trip; returns the number of groups."""
    count = cells.length_m.shape[0]
    first, last = regular_cells(w)
    program.linear[:] = 0.0
    for node in range(count + 1):
        program.held[node, 0] = not first < node <= last + 1
        program.held[node, 1] = not first <= node <= last
        program.held[node, 2] = node < first or node > last + 1
    if first > 0:
        program.held[first, 2] = True
        load = load_in(train, cells, 0)
        pulls = merged_in(train, cells, 0, top_v, pieces, NOT_MERGED).pulls
        price = price_in(train, cells, 0, multiplier)
        reach_w = standstill_terms(
            pieces[0], pulls, load, True, cells.length_m[0], price, w[0], caps.cell[0], tables.traction
        )[1]  # fmt: skip
        g, i = _put_pair(program, g, i, first, 1, (reach_w, 0.0), 0.5 * tables.traction * reach_w, reach_w)
    else:
        program.linear[first, 1] = w[0]
        program.linear[first, 2] = curve_of(w[0])
    if last < count - 1:
        program.held[last + 1, 2] = True
        load = load_in(train, cells, count - 1)
        brakes = merged_in(train, cells, count - 1, top_v, pieces, NOT_MERGED).brakes
        price = price_in(train, cells, count - 1, multiplier)
        reach_w = standstill_terms(
            pieces[1], brakes, load, False, cells.length_m[count - 1], price, w[count], caps.cell[count - 1],
            tables.regeneration,
        )[1]  # fmt: skip
        g, i = _put_pair(program, g, i, last + 1, 0, (-reach_w, 0.0), -0.5 * tables.regeneration * reach_w, reach_w)
    else:
        program.linear[last + 1, 0] = -w[count]
        program.linear[last + 1, 2] = -curve_of(w[count])
    return g


@kernel
def fill_program(train, tables, cells, caps, w, multiplier, speeds, top_v, pieces, program):
    """The bound for sampled speeds; returns the number of groups, and the first and last cell that have any.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    speeds : (K, S) float64
        Of each cell, m/s.
    program : Program, modified in place
    """
    first, last = regular_cells(w)
    merged = NOT_MERGED
    g = i = 0
    program.first[0] = 0
    for k in range(first, last + 1):
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        room = _ROOM * multiplier * d / speeds[k, -1]
        for end in range(2):
            for j in range(speeds.shape[1]):
                v = speeds[k, j]
                pull = piece_value(pieces[0], piece_at(pieces[0], pulls, v), v)
                brake = piece_value(pieces[1], piece_at(pieces[1], brakes, v), v)
                dynamic = piece_value(pieces[2], piece_at(pieces[2], dynamics, v), v)
                here, spent = load_at(load, v), price / v
                i = _put_end(program, i, end, d, v, pull, here, spent + tables.traction * pull)
                i = _put_end(program, i, end, d, v, 0.0, here, spent)
                i = _put_end(program, i, end, d, v, -dynamic, here, spent - tables.regeneration * dynamic)
                i = _put_end(program, i, end, d, v, -brake, here, spent - tables.regeneration * dynamic)
            at = AT_NODE * k
            g = _close(program, g, i, room, (at + 1, at + 2, at + AT_NODE, at + AT_NODE + 2))
        if k > first:
            g, i = _put_pair(program, g, i, k, 1, (caps.node[k], -caps.node[k]), 0.0, room)
    return _put_ends(train, tables, cells, caps, w, multiplier, top_v, pieces, program, g, i), first, last


def best_sampled(
    train: KernelTrain,
    tables: EnergyTables,
    found: Ledger,
    multiplier: float,
    top_mps: float,
    pieces: _Floats,
    enough: float,
    clock: Clock | None = None,
) -> tuple[_Floats, _Floats, _Floats]:
    """Costates at both ends of the cells of a bound, (K,), and r at the nodes, (K + 1,), from those of the bound.

    ``enough``, per unit of inertia, is what the sum may still gain.
    """
    count = len(found.left)
    ask_for(_CELL_B * count, f"a bound on {count:,} cells with sampled speeds")
    largest = np.sqrt(found.caps.cell)
    of_run = np.sqrt(0.5 * (found.w[1:] + found.w[:-1]))
    speeds = np.concatenate(
        (largest[:, None] * _OF_LARGEST, np.minimum(of_run[:, None] * _OF_RUN, largest[:, None])), axis=1
    )
    rows, groups = _ROWS * count + 4, 3 * count + 2
    slack, share, slack_step, share_step = np.zeros((4, rows))
    program = Program(
        np.zeros((rows, 4)), np.zeros(rows), np.zeros(groups + 1, dtype=np.int64),
        np.zeros((groups, 4), dtype=np.int64), np.zeros((count + 1, AT_NODE)),
        np.zeros((count + 1, AT_NODE), dtype=np.bool_), slack, share, slack_step, share_step, np.zeros(groups),
    )  # fmt: skip
    used, start, end = fill_program(
        train, tables, found.cells, found.caps, found.w, multiplier, np.sort(speeds, axis=1), top_mps, pieces, program
    )
    program = used_part(program, used)
    values = np.zeros((count + 1, AT_NODE))
    values[1:, 0], values[:-1, 1], values[:, 2] = found.right, found.left, found.bow
    own, link = np.zeros((2, count + 1, AT_NODE, AT_NODE))
    room = np.zeros(4), np.zeros((5, 4)), Blocks(np.zeros_like(values), own, link, np.zeros_like(values))
    progress = BEGIN
    while not progress.ended and not (clock and clock.expired):
        progress = improve(program, values, enough, max(_CELLS_AT_ONCE // count, 1), progress, *room)
    left, right, bow = values[:-1, 1].copy(), values[1:, 0].copy(), values[:, 2].copy()
    left[:start] = right[:start] = left[start]  # a cell of a standstill has the costate of its neighbour
    left[end + 1 :] = right[end + 1 :] = right[end]
    return left, right, bow
