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
from tgvdp.certificate.interior import BEGIN, improve, room_for
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.program import DIFFER, Place, end_group, end_run, program_for, used_part
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
def _begin_band(program, q, edges, j):
    """Begin a run of speeds of a band at an end of a cell: what differs is of this band, and of r."""
    bands = edges.shape[0] - 1
    for below in range(j):
        lies = 0.5 * (edges[below + 1] - edges[below])
        program.base[q, below] = -lies
        program.base[q, bands + 1 + below] = lies
    program.column[q, 0], program.column[q, 1] = j, bands
    program.column[q, 2], program.column[q, 3] = bands + 1 + j, 2 * bands + 1


@part
def _put_row(program, i, end, above, v, by_p, const):
    """Write the row of a speed, and of an effort, at one end of a cell: of w so much lies in the band."""
    curve = 0.5 * curve_of(v * v)
    program.coef[i, 0] = -0.5 * above
    program.coef[i, 1] = -curve
    program.coef[i, 2] = 0.5 * above
    program.coef[i, 3] = curve
    program.coef[i, 2 * end] += by_p
    program.coef[i, 2 * end + 1] += by_p * v
    program.const[i] = const


@part
def _put_end(program, place, tables, pieces, merged, edges, end, d, load, price, speeds):
    """The runs of all speeds at one end of a cell, rising; returns the next place."""
    _, pulls, brakes, dynamics = merged
    rows, band = 0, -1
    for s in range(speeds.shape[0]):
        v = speeds[s]
        w = v * v
        if s > 0 and v == speeds[s - 1]:
            continue
        while band < 0 or w >= edges[band + 1]:
            if rows > 0:
                place, rows = end_run(program, place, rows), 0
            band += 1
        if rows == 0:
            _begin_band(program, place.q, edges, band)
        pull = piece_value(pieces[0], piece_at(pieces[0], pulls, v), v)
        brake = piece_value(pieces[1], piece_at(pieces[1], brakes, v), v)
        dynamic = piece_value(pieces[2], piece_at(pieces[2], dynamics, v), v)
        here, spent, i = load_at(load, v), price / v, place.i + rows
        returned = tables.regeneration * dynamic
        half, above = 0.5 * d, w - edges[band]
        _put_row(program, i, end, above, v, d * (pull - here), half * (spent + tables.traction * pull))
        _put_row(program, i + 1, end, above, v, -d * here, half * spent)
        _put_row(program, i + 2, end, above, v, -d * (brake + here), half * (spent - returned))
        rows += _EFFORTS - 1
        if returned > 0.0:
            _put_row(program, i + 3, end, above, v, -d * (dynamic + here), half * (spent - returned))
            rows += 1
    return end_run(program, place, rows)


@part
def _put_jump(program, place, edges, node, cap_w, room):
    """The group of what jumps of the costates at a node cost at all speeds; returns the next place."""
    bands = edges.shape[0] - 1
    _at_node(program, place.g, bands, node)
    place = end_run(program, place, 1)  # no speed at all: a row of zeros
    for at in range(1, bands + 1):
        w = min(edges[at], cap_w)
        for j in range(bands):
            lies = share_of(edges, j, w)
            program.base[place.q, j] = -lies
            program.base[place.q, bands + j] = lies
        place = end_run(program, place, 1)
    return end_group(program, place, room)


@part
def _put_limits(program, place, caps, node, begin, reach):
    """The group that keeps all unknowns of a node near where they begin; returns the next place.

    r may change by what changes the costate of the fastest runs by as much.
    """
    own, last = program.linear.shape[1], caps.cell.shape[0] - 1
    beside_w = max(caps.cell[max(node - 1, 0)], caps.cell[min(node, last)])
    _at_node(program, place.g, own // 2, node)
    place = end_run(program, place, 1)  # where none is beyond its limits
    for j in range(own):
        is_bow = j == own - 1
        dear = _DEAR * (curve_of(beside_w) if is_bow else beside_w)
        most = reach / math.sqrt(beside_w) if is_bow else reach
        column = min(j, own + 1 - DIFFER)
        for m in range(DIFFER):
            program.column[place.q, m] = column + m
        program.coef[place.i, j - column] = -dear
        program.const[place.i] = dear * (most + begin[own * node + j])
        program.coef[place.i + 1, j - column] = dear
        program.const[place.i + 1] = dear * (most - begin[own * node + j])
        place = end_run(program, place, 2)
    return end_group(program, place, reach * beside_w)


@part
def _at_node(program, g, bands, node):
    """Let the unknowns of a group be all those of a node."""
    own = 2 * bands + 1
    for j in range(own + 1):
        program.unknown[g, j] = own * node + min(j, own - 1)


@part
def _put_standstill(program, place, bands, node, which, coef, const):
    """The group of what a cell of a standstill costs by a costate at its other end; returns the next place."""
    _at_node(program, place.g, bands, node)
    place = end_run(program, place, 1)
    program.base[place.q, which] = coef
    program.const[place.i] = const
    return end_group(program, end_run(program, place, 1), abs(coef))


@part
def _put_trip(train, tables, cells, caps, w, multiplier, edges, top_v, pieces, program, place):
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
        place = _put_standstill(program, place, bands, first, bands, reach_w, 0.5 * tables.traction * reach_w)
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
        place = _put_standstill(program, place, bands, last + 1, 0, -reach_w, -0.5 * tables.regeneration * reach_w)
    else:
        for j in range(bands):
            program.linear[last + 1, j] = -share_of(edges, j, w[count])
    return place.g


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
        Of the two ends of each cell, m/s, rising.
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
    place = Place(0, 0, 0)
    for k in range(first, last + 1):
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        room = _ROOM * multiplier * d / math.sqrt(caps.cell[k])
        for end in range(2):
            for j in range(bands):
                program.unknown[place.g, j] = own * k + bands + j
                program.unknown[place.g, bands + 1 + j] = own * (k + 1) + j
            program.unknown[place.g, bands] = own * k + 2 * bands
            program.unknown[place.g, own] = own * (k + 1) + 2 * bands
            place = _put_end(program, place, tables, pieces, merged, edges, end, d, load, price, speeds[k, end])
            place = end_group(program, place, room)
        if k > first:
            place = _put_jump(program, place, edges, k, caps.node[k], room)
        place = _put_limits(program, place, caps, k, begin, reach)
    place = _put_limits(program, place, caps, last + 1, begin, reach)
    return _put_trip(train, tables, cells, caps, w, multiplier, edges, top_v, pieces, program, place), first, last


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
    """The best potential for the cells of a bound and some speeds at both of their ends, (K, 2, S), in m/s, rising.

    It is sought from ``start`` on, no farther than ``reach`` from its costates: far away speeds decide that are not
    sampled. ``enough``, per unit of inertia, is what the sum may still gain.
    """
    count, bands = start.left.shape
    groups, own = 4 * count + 3, 2 * bands + 1
    rows = count * (2 * speeds.shape[2] * _EFFORTS + 1 + bands) + (count + 1) * (2 * own + 1) + 4
    runs = count * (3 * bands + 1) + (count + 1) * (own + 1) + 4
    ask_for(rows * 8.0 * (DIFFER + 6.0) + runs * 8.0 * own, f"a bound on {count:,} cells with sampled speeds")
    program = program_for(count + 1, own, rows, runs, groups)
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
