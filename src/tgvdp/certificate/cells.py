"""Rows of a run cut into cells that are fine enough for a costate that is linear in each of them.

Where a run keeps to a regime a cell loses about λ·t·h²/40 of the bound, t the time in it and h its step of ln w. Of all
cuts into as many cells the sum is least where all lose the same. At a constant acceleration t is τ·h, τ ~ v, so that
h ~ 1/∛v: equal steps of ∛v.
"""

import math
from typing import NamedTuple

import numpy as np

from tgvdp._jit import kernel, leaf

#: What a cell loses of the bound, in units of λ·t·h².
LOSS = 1.0 / 40.0
#: A row whose w changes by less than this share is cut into equal lengths, others into equal steps of ∛v; and one
#: at which speed is kept.
_UNIFORM, _STEADY = 0.02, 1e-6
#: Largest step of ln w at the faster end of a row.
_LARGEST_STEP = 0.25
#: Rows that are joined have efforts that differ by no more than this share from one to the next, and ends whose w
#: differ by no more than this share from a straight line: runs touch limits at ends.
_ALIKE, _STRAIGHT = 0.1, 1e-4
#: At a standstill the first node lies at this share of the row's squared speed.
_FIRST_SHARE = 1e-4
#: A costate may grow without bound along a run, and what a cell is cut into must not: 2⁶³ is no number of parts.
_MOST_PARTS = 1000.0


class Cut(NamedTuple):
    """How rows are cut.

    Attributes
    ----------
    longest_m, steady_m : float
        Length of the longest cells, and of those at one speed.
    step : float
        Step of ln w where τ is 1 s, h·∛τ.
    """

    longest_m: float
    steady_m: float
    step: float


@leaf
def _is_steady(w0, w1):
    return abs(w1 - w0) <= _STEADY * max(w0, w1)


@leaf
def _root(w):
    """∛v of a squared speed."""
    return np.cbrt(math.sqrt(w))


@leaf
def _spread(w0, w1):
    """Cells of a row if their steps of ln w were 1 at its faster end, and larger towards the slower one as 1/∛v."""
    hi = max(w0, w1)
    return 6.0 * (1.0 - _root(max(min(w0, w1) / hi, _FIRST_SHARE)))


@leaf
def _slowness(w0, w1, length):
    """∛τ, τ the time in which ln w would change by 1, at the faster end of a row that is not steady."""
    return np.cbrt(math.sqrt(max(w0, w1)) * length / abs(w1 - w0))


@kernel
def graded_step(x, w, weight, budget):
    """The step of a `Cut` for which Σ t·h² over all cells is ``budget``, s; ``weight`` (n − 1,) is scratch.

    Rows that are shorter than a step are cells as they are, and lose less.
    """
    for i in range(weight.shape[0]):
        weight[i] = 0.0
        if not _is_steady(w[i], w[i + 1]):
            weight[i] = _spread(w[i], w[i + 1]) * _slowness(w[i], w[i + 1], x[i + 1] - x[i])
    step = 0.0
    for _ in range(3):
        total = 0.0
        for i in range(weight.shape[0]):
            if weight[i] > step:
                total += weight[i]
        if total == 0.0:
            break
        step = math.sqrt(budget / total)
    return step


@leaf
def _cuts(w0, w1, length, cut):
    """Number of cells of a row."""
    if _is_steady(w0, w1):
        return max(math.ceil(length / cut.steady_m), 1)
    cells = max(math.ceil(length / cut.longest_m), 1)
    share = max(_slowness(w0, w1, length) / cut.step, 1.0 / _LARGEST_STEP)
    cells = max(cells, math.ceil(min(_spread(w0, w1) * share, _MOST_PARTS)))
    return cells + 1 if min(w0, w1) < _FIRST_SHARE * max(w0, w1) else cells


@kernel
def thin_rows(x, w, fixed, gap):
    """Drop rows within ``gap`` of the row before, but never a ``fixed`` one; in place, returns the number of rows.

    A run that creeps to its stop may have rows that are too short to be cut any further.
    """
    n = 1
    for i in range(1, x.shape[0]):
        if x[i] - x[n - 1] <= gap:
            if not fixed[i]:
                continue
            if not fixed[n - 1]:
                n -= 1
        x[n] = x[i]
        w[n] = w[i]
        fixed[n] = fixed[i]
        n += 1
    return n


@kernel
def join_rows(x, w, effort, place, cut):
    """Join rows of one effort while they are no longer than a cell; in place, returns how many rows there are.

    ``x``, ``w`` are the ends of rows, ``effort`` and ``place``, the cell of the line, theirs.
    """
    n = 0
    last = effort[0]
    lowest, highest = -math.inf, math.inf  # slopes of w that pass by all ends that are left out
    for i in range(1, place.shape[0]):
        length = x[i + 1] - x[n]
        lowest = max(lowest, (w[i] - _STRAIGHT * w[i] - w[n]) / (x[i] - x[n]))
        highest = min(highest, (w[i] + _STRAIGHT * w[i] - w[n]) / (x[i] - x[n]))
        alike = abs(effort[i] - last) <= _ALIKE * max(abs(effort[i]), abs(last)) and place[i] == place[n]
        last = effort[i]
        straight = lowest <= (w[i + 1] - w[n]) / length <= highest
        if alike and straight and _cuts(w[n], w[i + 1], length, cut) == 1:
            effort[n] += (effort[i] - effort[n]) * (x[i + 1] - x[i]) / length
        else:
            n += 1
            effort[n], place[n] = effort[i], place[i]
            x[n], w[n] = x[i], w[i]
            lowest, highest = -math.inf, math.inf
        x[n + 1], w[n + 1] = x[i + 1], w[i + 1]
    return n + 1


@kernel
def count_cells(x, w, cut, parts):
    """Number of cells that each row is cut into, ``parts`` (n − 1,) int64 in place; returns that of all."""
    count = 0
    for i in range(parts.shape[0]):
        parts[i] = _cuts(w[i], w[i + 1], x[i + 1] - x[i], cut)
        count += parts[i]
    return count


@kernel
def cut_rows(x, w, parts, node_x, node_w, row):
    """Cut rows into cells: equal steps of ∛v, or of position where w hardly changes; no more than there is room.

    ``parts`` are those of `count_cells`.
    """
    n = 0
    node_x[0] = x[0]
    node_w[0] = w[0]
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        w0 = w[i]
        w1 = w[i + 1]
        count = min(parts[i], row.shape[0] - n)
        hi = max(w0, w1)
        uniform = hi - min(w0, w1) < _UNIFORM * hi
        bottom = _FIRST_SHARE * hi
        # a cell of a standstill comes first, or last, and steps are between the others
        stands, stops = not uniform and w0 < bottom, not uniform and w1 < bottom
        steps = count - 1 if stands or stops else count
        root0 = root1 = 0.0
        if count > 1 and not uniform:
            root0, root1 = _root(max(w0, bottom)), _root(max(w1, bottom))
        for j in range(1, count):
            share = j / count
            if not uniform:
                root = root0 + ((j - 1 if stands else j) / steps) * (root1 - root0)
                share = (root**6 - w0) / (w1 - w0)
            row[n] = i
            n += 1
            node_x[n] = x[i] + share * d
            node_w[n] = w0 + share * (w1 - w0)
        row[n] = i
        n += 1
        node_x[n] = x[i + 1]
        node_w[n] = w1
    return n


@leaf
def _parts(left, right, length, w0, w1, multiplier, step):
    """Parts of a cell over which p changes by ``step`` of its distance from +½ at most; 1 where it hardly changes."""
    size = 0.5 + min(abs(left), abs(right))
    change = abs(right - left)
    if change <= 2.0 * step * size or min(w0, w1) <= 0.0:
        return 1
    drift = 0.5 * multiplier * length / (min(w0, w1) * math.sqrt(max(w0, w1)))
    return math.ceil(min(_MOST_PARTS, max(change, drift) / (step * size)))


@kernel
def split_cells(node_x, node_w, row, left, right, multiplier, step, made_x, made_w, made_row):
    """Cut cells again in which p changes much: what is new in ``made_…``; returns the number of cells.

    With empty arrays it only counts; into others it writes no more than there is room.
    """
    n = 0
    write = made_row.shape[0] > 0
    last = row.shape[0] - 1
    if write:
        made_x[0] = node_x[0]
        made_w[0] = node_w[0]
    for k in range(last + 1):
        parts = 1
        if 0 < k < last:
            parts = _parts(left[k], right[k], node_x[k + 1] - node_x[k], node_w[k], node_w[k + 1], multiplier, step)
        if write:
            parts = min(parts, made_row.shape[0] - n)
            for j in range(1, parts + 1):
                share = j / parts
                made_row[n + j - 1] = row[k]
                made_x[n + j] = node_x[k] + share * (node_x[k + 1] - node_x[k])
                made_w[n + j] = node_w[k] + share * (node_w[k + 1] - node_w[k])
            made_x[n + parts] = node_x[k + 1]
        n += parts
    return n
