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


@kernel
def merge_comfort(table, extra_n, inertia_kg, comfort, rates, load, top_v, pieces):
    """Pieces of min(effort, what the comfort limit allows), per unit of inertia, for speeds up to ``top_v``.

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
        Decelerations that are never passed either, as in `KernelTrain`, or no rows; ``table`` breaks where they do.
    load : Load
        What adds to it; for brakes the train's load, negative.
    top_v : float
        Largest speed of interest, m/s.
    pieces : (2n, 6) float64, modified in place

    Returns
    -------
    int
        Number of pieces. Both members of the minimum bound it from above, so that it does not matter for the validity
        of the bound how well the point is found where one takes over from the other.
    """
    r0, r1, r2 = load
    count = 0
    for i in range(table.shape[0]):
        lo = table[i, 0]
        if lo > top_v:
            break
        hi = top_v
        if i + 1 < table.shape[0]:
            hi = min(top_v, table[i + 1, 0])
        pieces[count, 0] = lo
        for j in range(1, PIECE_COLUMNS):
            pieces[count, j] = table[i, j] / inertia_kg
        pieces[count, 2] += extra_n / inertia_kg
        most = comfort
        if rates.shape[0] > 0:
            # A rate is kept unless the load alone slows the train more, which it does most at the end of the piece.
            rate = rates[piece_at(rates, rates.shape[0], lo), 2] / inertia_kg
            most = min(most, max(rate, -load_at(load, hi)))
        if most == math.inf:
            count += 1
            continue
        over_lo = piece_value(pieces, count, lo) > most + r0 + lo * (r1 + lo * r2)
        over_hi = piece_value(pieces, count, hi) > most + r0 + hi * (r1 + hi * r2)
        a = lo
        b = hi
        if over_lo != over_hi:
            for _ in range(48):
                middle = 0.5 * (a + b)
                if (piece_value(pieces, count, middle) > most + r0 + middle * (r1 + middle * r2)) == over_lo:
                    a = middle
                else:
                    b = middle
            for j in range(PIECE_COLUMNS):
                pieces[count + 1, j] = pieces[count, j]
            pieces[count + 1, 0] = b
        limited = count if over_lo else count + 1
        if over_lo or over_hi:
            pieces[limited, 1] = 0.0
            pieces[limited, 2] = most + r0
            pieces[limited, 3] = r1
            pieces[limited, 4] = r2
            pieces[limited, 5] = 0.0
        count += 1 if over_lo == over_hi else 2
    return count


@kernel
def merge_tables(train, load, top_v, pieces):
    """Pieces of traction, of all brakes and of the dynamic brake alone, for a load, into ``pieces`` (3, 2n, 6).

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
