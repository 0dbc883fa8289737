"""Costates of all bands of speeds, and r, that are best for sampled speeds.

With a few speeds in place of all, and the four efforts of which one is best at each (`certificate.hamiltonian`), the
bound is a sum of least values of linear functions of the costates and of r, and its top a linear program
(`certificate.interior`): no kink is in the way of a step, whether the speed of a least value changes or its effort.
What comes out is no bound before the exact one is taken of it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.certificate.bands import Potential, curve_of, share_of
from tgvdp.certificate.cell_bounds import standstill_terms
from tgvdp.certificate.efforts import NOT_MERGED, load_at, load_in, merged_in, piece_at, piece_value, price_in
from tgvdp.certificate.interior import BEGIN, improve, program_for, room_for, used_part
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.slopes import regular_cells
from tgvdp.memory import ask_for
from tgvdp.methods.budget import Clock
from tgvdp.physics.energy import EnergyTables
from tgvdp.physics.forces import KernelTrain

_Floats = NDArray[np.float64]

#: Efforts of which one is best at a speed.
_EFFORTS = 4
#: Room of the numbers below the least values to begin with, relative to the price of the time that a cell takes.
_ROOM = 5.0
#: What costates cost beyond their limits, relative to what they can gain there at most.
_DEAR = 4.0
#: Number of cells that are moved between two looks at the clock.
_CELLS_AT_ONCE = 5_000


@part
def _close(program, g, i, room):
    """End a group before row i; returns the next group."""
    program.first[g + 1] = i
    program.least[g] = room
    return g + 1


@part
def _put_end(program, i, edges, end, d, v, f, load, cost):
    """Write the row of a speed and an effort at one end of a cell; returns the next."""
    bands = edges.shape[0] - 1
    w, by_p = v * v, d * (f - load)
    here = end * (bands + 1)
    for j in range(bands):
        lies = 0.5 * share_of(edges, j, w)
        program.coef[i, j] = -lies
        program.coef[i, bands + 1 + j] = lies
        if edges[j] <= w < edges[j + 1]:
            program.coef[i, here + j] += by_p
    curve = 0.5 * curve_of(w)
    program.coef[i, bands] = -curve
    program.coef[i, 2 * bands + 1] = curve
    program.coef[i, here + bands] += by_p * v
    program.const[i] = 0.5 * d * cost
    return i + 1


@part
def _put_jump(program, g, i, edges, node, cap_w, room):
    """The group of what jumps of the costates at a node cost at all speeds; returns the next group and row."""
    bands = edges.shape[0] - 1
    i += 1  # no speed at all: a row of zeros
    for at in range(1, bands + 1):
        w = min(edges[at], cap_w)
        for j in range(bands):
            lies = share_of(edges, j, w)
            program.coef[i, j] = -lies
            program.coef[i, bands + j] = lies
        i += 1
    _at_node(program, g, bands, node)
    return _close(program, g, i, room), i


@part
def _put_limits(program, g, i, caps, node, begin, reach):
    """The group that keeps all unknowns of a node near where they begin; returns the next group and row.

    r may change by what changes the costate of the fastest runs by as much.
    """
    own, last = program.linear.shape[1], caps.cell.shape[0] - 1
    beside_w = max(caps.cell[max(node - 1, 0)], caps.cell[min(node, last)])
    for j in range(own):
        is_bow = j == own - 1
        dear = _DEAR * (curve_of(beside_w) if is_bow else beside_w)
        most = reach / math.sqrt(beside_w) if is_bow else reach
        program.coef[i + 1, j] = -dear
        program.const[i + 1] = dear * (most + begin[own * node + j])
        program.coef[i + 2, j] = dear
        program.const[i + 2] = dear * (most - begin[own * node + j])
        i += 2
    _at_node(program, g, own // 2, node)
    return _close(program, g, i + 1, reach * beside_w), i + 1


@part
def _at_node(program, g, bands, node):
    """Let the unknowns of a group be all those of a node."""
    own = 2 * bands + 1
    for j in range(own + 1):
        program.unknown[g, j] = own * node + min(j, own - 1)


@part
def _put_standstill(program, g, i, bands, node, which, coef, const):
    """The group of what a cell of a standstill costs by a costate at its other end; returns the next group and row."""
    program.coef[i + 1, which] = coef
    program.const[i + 1] = const
    _at_node(program, g, bands, node)
    return _close(program, g, i + 2, abs(coef)), i + 2


@part
def _put_trip(train, tables, cells, caps, w, multiplier, edges, top_v, pieces, program, g, i):
    """The terms of the ends of the trip; returns the number of groups."""
    count, bands = cells.length_m.shape[0], edges.shape[0] - 1
    first, last = regular_cells(w)
    for node in range(count + 1):
        for j in range(bands):
            program.held[node, j] = not first < node <= last + 1
            program.held[node, bands + j] = not first <= node <= last
        program.held[node, 2 * bands] = not first < node <= last
    if first > 0:
        load = load_in(train, cells, 0)
        pulls = merged_in(train, cells, 0, top_v, pieces, NOT_MERGED).pulls
        price = price_in(train, cells, 0, multiplier)
        reach_w = standstill_terms(
            pieces[0], pulls, load, True, cells.length_m[0], price, w[0], caps.cell[0], tables.traction
        )[1]  # fmt: skip
        g, i = _put_standstill(program, g, i, bands, first, bands, reach_w, 0.5 * tables.traction * reach_w)
    else:
        for j in range(bands):
            program.linear[first, bands + j] = share_of(edges, j, w[0])
    if last < count - 1:
        load = load_in(train, cells, count - 1)
        brakes = merged_in(train, cells, count - 1, top_v, pieces, NOT_MERGED).brakes
        price = price_in(train, cells, count - 1, multiplier)
        reach_w = standstill_terms(
            pieces[1], brakes, load, False, cells.length_m[count - 1], price, w[count], caps.cell[count - 1],
            tables.regeneration,
        )[1]  # fmt: skip
        g, i = _put_standstill(program, g, i, bands, last + 1, 0, -reach_w, -0.5 * tables.regeneration * reach_w)
    else:
        for j in range(bands):
            program.linear[last + 1, j] = -share_of(edges, j, w[count])
    return g


@kernel
def fill_program(
    train, tables, cells, caps, w, multiplier, edges, speeds, top_v, pieces, begin, reach, program
):  # fmt: skip
    """The bound for sampled speeds; returns the number of groups, and the first and last cell that have any.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    edges : (B + 1,) float64
        As `bands.Potential` has them.
    speeds : (K, 2, S) float64
        Of the two ends of each cell, m/s.
    begin : ((K + 1)·(2·B + 1),) float64
        Unknowns to begin with.
    reach : float
        How far they may go.
    program : Program, modified in place
        All zeros.
    """
    first, last = regular_cells(w)
    bands = edges.shape[0] - 1
    own = 2 * bands + 1
    merged = NOT_MERGED
    g = i = 0
    for k in range(first, last + 1):
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        room = _ROOM * multiplier * d / math.sqrt(caps.cell[k])
        for end in range(2):
            for s in range(speeds.shape[2]):
                v = speeds[k, end, s]
                pull = piece_value(pieces[0], piece_at(pieces[0], pulls, v), v)
                brake = piece_value(pieces[1], piece_at(pieces[1], brakes, v), v)
                dynamic = piece_value(pieces[2], piece_at(pieces[2], dynamics, v), v)
                here, spent = load_at(load, v), price / v
                returned = tables.regeneration * dynamic
                i = _put_end(program, i, edges, end, d, v, pull, here, spent + tables.traction * pull)
                i = _put_end(program, i, edges, end, d, v, 0.0, here, spent)
                i = _put_end(program, i, edges, end, d, v, -dynamic, here, spent - returned)
                i = _put_end(program, i, edges, end, d, v, -brake, here, spent - returned)
            for j in range(bands):
                program.unknown[g, j] = own * k + bands + j
                program.unknown[g, bands + 1 + j] = own * (k + 1) + j
            program.unknown[g, bands] = own * k + 2 * bands
            program.unknown[g, own] = own * (k + 1) + 2 * bands
            g = _close(program, g, i, room)
        if k > first:
            g, i = _put_jump(program, g, i, edges, k, caps.node[k], room)
        g, i = _put_limits(program, g, i, caps, k, begin, reach)
    g, i = _put_limits(program, g, i, caps, last + 1, begin, reach)
    return _put_trip(train, tables, cells, caps, w, multiplier, edges, top_v, pieces, program, g, i), first, last


def best_sampled(
    train: KernelTrain,
    tables: EnergyTables,
    found: Ledger,
    multiplier: float,
    start: Potential,
    speeds: _Floats,
    top_mps: float,
    pieces: _Floats,
    reach: float,
    enough: float,
    clock: Clock | None = None,
) -> Potential:
    """The best potential for the cells of a bound and some speeds at both of their ends, (K, 2, S), in m/s.

    It is sought from ``start`` on, no farther than ``reach`` from its costates: far away speeds decide that are not
    sampled. ``enough``, per unit of inertia, is what the sum may still gain.
    """
    count, bands = start.left.shape
    groups, own = 4 * count + 3, 2 * bands + 1
    rows = count * (2 * speeds.shape[2] * _EFFORTS + 1 + bands) + (count + 1) * (2 * own + 1) + 4
    ask_for(rows * 8.0 * (own + 6.0), f"a bound on {count:,} cells with sampled speeds")
    program = program_for(count + 1, own, rows, groups)
    values = np.zeros((count + 1, own))
    values[1:, :bands], values[:-1, bands:-1], values[:, -1] = start.right, start.left, start.bow
    used, first, last = fill_program(
        train, tables, found.cells, found.caps, found.w, multiplier, start.edges, speeds, top_mps, pieces,
        values.ravel(), reach, program,
    )  # fmt: skip
    program = used_part(program, used)
    room, progress = room_for(program), BEGIN
    step_s = 0.0  # on a long line a step takes seconds: none is begun that would not end in time
    while not progress.ended and not (clock and clock.left_s() <= step_s):
        begun_s = clock.elapsed_s if clock else 0.0
        progress = improve(program, values.ravel(), enough, max(_CELLS_AT_ONCE // count, 1), progress, room)
        step_s = clock.elapsed_s - begun_s if clock else 0.0
    left, right, bow = values[:-1, bands:-1].copy(), values[1:, :bands].copy(), values[:, -1].copy()
    left[:first] = right[:first] = left[first]  # a cell of a standstill has the costate of its neighbour
    left[last + 1 :] = right[last + 1 :] = right[last]
    return Potential(start.edges, left, right, bow)
