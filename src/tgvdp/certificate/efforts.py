"""Effort curves as pieces P/v + c0 + c1·v + c2·v² + c3·v³ per unit of inertia, comfort limits merged in."""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.model.track import POWERED
from tgvdp.physics.forces import unpowered

#: Columns of a table of effort pieces: from_mps, P, c0, c1, c2, c3.
PIECE_COLUMNS = 6


class Load(NamedTuple):
    """Resistance and grade force per unit of inertia, r0 + r1·v + r2·v², m/s²."""

    r0: float
    r1: float
    r2: float


class Merged(NamedTuple):
    """The cell whose pieces of efforts are at hand, and how many they are; of traction, all brakes, the dynamic one."""

    cell: int
    pulls: int
    brakes: int
    dynamics: int


NOT_MERGED = Merged(-1, 0, 0, 0)


@leaf
def load_in(train, cells, k):
    """Load in a cell."""
    mass = train.inertia_kg
    return Load((train.davis_a_n + cells.grade_n[k]) / mass, train.davis_b / mass, cells.air[k] / mass)


@leaf
def load_at(load, v):
    """Load at speed v."""
    return load.r0 + v * (load.r1 + v * load.r2)


@leaf
def train_in(train, cells, k):
    """The train as a cell has it: without current in a neutral section."""
    return train if cells.supply[k] == POWERED else unpowered(train)


@leaf
def price_in(train, cells, k, multiplier):
    """Price of a second in a cell per unit of inertia: λ with auxiliaries, less what those do not draw there."""
    return multiplier - cells.saved_w[k] / train.inertia_kg


@leaf
def same_forces(cells, k, j):
    """Whether load and efforts are the same in two cells."""
    powered = (cells.supply[k] == POWERED) == (cells.supply[j] == POWERED)
    return powered and cells.grade_n[k] == cells.grade_n[j] and cells.air[k] == cells.air[j]


@leaf
def piece_value(pieces, i, v):
    """Value of piece ``i`` at v."""
    hyperbolic = 0.0
    if pieces[i, 1] != 0.0:
        hyperbolic = pieces[i, 1] / v
    return hyperbolic + pieces[i, 2] + v * (pieces[i, 3] + v * (pieces[i, 4] + v * pieces[i, 5]))


@leaf
def piece_at(pieces, n, v):
    """Index of the piece at v."""
    i = 0
    after = n
    while after - i > 1:
        middle = (i + after) // 2
        if pieces[middle, 0] > v:
            after = middle
        else:
            i = middle
    return i


@part
def _change(pieces, i, allowed, lo, hi):
    """Narrow bracket of the only speed from lo to hi at which piece ``i`` passes what is allowed, or ceases to."""
    passes = piece_value(pieces, i, lo) > load_at(allowed, lo)
    for _ in range(48):
        middle = 0.5 * (lo + hi)
        if (piece_value(pieces, i, middle) > load_at(allowed, middle)) == passes:
            lo = middle
        else:
            hi = middle
    return lo, hi


@leaf
def _put(pieces, count, from_v, effort):
    """Write a piece of an effort that is a polynomial, a `Load`; returns the number after it."""
    pieces[count, 0] = from_v
    pieces[count, 1] = 0.0
    pieces[count, 2] = effort.r0
    pieces[count, 3] = effort.r1
    pieces[count, 4] = effort.r2
    pieces[count, 5] = 0.0
    return count + 1


@part
def _put_least(row, shift, scale, allowed, lo, hi, pieces, count):
    """Append the lesser of an effort and of what is allowed, above 0 from lo to hi; returns the number of pieces."""
    pieces[count, 0] = lo
    for j in range(1, PIECE_COLUMNS):
        pieces[count, j] = row[j] / scale
    pieces[count, 2] += shift / scale
    if allowed.r0 == math.inf:
        return count + 1
    over_lo = piece_value(pieces, count, lo) > load_at(allowed, lo)
    over_hi = piece_value(pieces, count, hi) > load_at(allowed, hi)
    if over_lo == over_hi:
        return _put(pieces, count, lo, allowed) if over_lo else count + 1
    at = _change(pieces, count, allowed, lo, hi)[1]
    if over_hi:
        return _put(pieces, count + 1, at, allowed)
    for j in range(PIECE_COLUMNS):
        pieces[count + 1, j] = pieces[count, j]
    pieces[count + 1, 0] = at
    _put(pieces, count, lo, allowed)
    return count + 2


@kernel
def merge_comfort(table, extra_n, inertia_kg, comfort, rates, load, top_v, pieces):
    """Pieces of min(effort, what the comfort limit allows), per unit of inertia, for speeds up to ``top_v``.

    Where the load alone does more than the limit allows, no effort is left.

    Parameters
    ----------
    table : (n, 6) float64
        An effort curve.
    extra_n : float
        Constant effort on top of it, N.
    inertia_kg : float
    comfort : float
        Acceleration limit, m/s²; may be infinite.
    rates : (m, 6) float64
        Decelerations that take its place, as in `KernelTrain`, or no rows; ``table`` breaks where they do.
    load : Load
        What adds to it, all terms but the first of one sign; for brakes the train's load, negative.
    top_v : float
        Largest speed of interest, m/s.
    pieces : (3n, 6) float64, modified in place

    Returns
    -------
    int
        Number of pieces. Both members of the minimum bound it from above, so that it does not matter for the validity
        of the bound how well the point is found where one takes over from the other.
    """
    count = 0
    nothing = Load(0.0, 0.0, 0.0)
    for i in range(table.shape[0]):
        lo = table[i, 0]
        if lo > top_v:
            break
        hi = top_v
        if i + 1 < table.shape[0]:
            hi = min(top_v, table[i + 1, 0])
        most = comfort
        if rates.shape[0] > 0:
            most = rates[piece_at(rates, rates.shape[0], lo), 2] / inertia_kg
        allowed = Load(most + load.r0, load.r1, load.r2)
        none_lo = load_at(allowed, lo) <= 0.0
        none_hi = load_at(allowed, hi) <= 0.0
        if none_lo and none_hi:
            count = _put(pieces, count, lo, nothing)
        elif none_lo or none_hi:
            _put(pieces, count, lo, nothing)
            below, above = _change(pieces, count, allowed, lo, hi)
            if none_lo:
                count = _put_least(table[i], extra_n, inertia_kg, allowed, below, hi, pieces, count + 1)
            else:
                count = _put_least(table[i], extra_n, inertia_kg, allowed, lo, above, pieces, count)
                count = _put(pieces, count, above, nothing)
        else:
            count = _put_least(table[i], extra_n, inertia_kg, allowed, lo, hi, pieces, count)
    return count


@kernel
def merge_tables(train, load, top_v, pieces):
    """Pieces of traction, of all brakes and of the dynamic brake alone, for a load, into ``pieces`` (3, 3n, 6).

    Returns their numbers.
    """
    mass = train.inertia_kg
    comfort = train.max_deceleration
    rates = train.rates
    helps = Load(-load.r0, -load.r1, -load.r2)
    pulls = merge_comfort(train.traction, 0.0, mass, train.max_acceleration, rates[:0], load, top_v, pieces[0])
    brakes = merge_comfort(train.braking, train.friction_n, mass, comfort, rates, helps, top_v, pieces[1])
    dynamics = merge_comfort(train.braking, 0.0, mass, comfort, rates, helps, top_v, pieces[2])
    return pulls, brakes, dynamics


@part
def merged_in(train, cells, k, top_v, pieces, merged):
    """`merge_tables` in a cell, or what was ``merged`` before where the forces are the same there."""
    if merged.cell >= 0 and same_forces(cells, k, merged.cell):
        return merged
    pulls, brakes, dynamics = merge_tables(train_in(train, cells, k), load_in(train, cells, k), top_v, pieces)
    return Merged(k, pulls, brakes, dynamics)


@kernel
def largest_effort(pieces, n, low_v, high_v):
    """Upper bound of a table of pieces over all speeds from low_v to high_v, term by term on each piece."""
    largest = -math.inf
    for i in range(piece_at(pieces, n, low_v), n):
        lo = max(pieces[i, 0], low_v)
        if lo > high_v:
            break
        hi = high_v
        if i + 1 < n:
            hi = min(high_v, pieces[i + 1, 0])
        value = pieces[i, 2] + max(pieces[i, 3] * lo, pieces[i, 3] * hi)
        value += max(pieces[i, 4] * lo * lo, pieces[i, 4] * hi * hi)
        value += max(pieces[i, 5] * lo * lo * lo, pieces[i, 5] * hi * hi * hi)
        if pieces[i, 1] != 0.0:
            value += max(pieces[i, 1] / lo, pieces[i, 1] / hi)
        largest = max(largest, value)
    return largest
