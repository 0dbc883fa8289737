"""Rows of a run cut into cells that are fine enough for a costate that is linear in each of them."""

import math

from tgvdp._jit import kernel, leaf

#: A row whose w changes by less than this share is cut into equal lengths, others into equal steps of ln w.
_UNIFORM = 0.02
#: At a standstill the first node lies at this share of the row's squared speed.
_FIRST_SHARE = 1e-4
#: A costate may grow without bound along a run, and what a cell is cut into must not: 2⁶³ is no number of parts.
_MOST_PARTS = 1000.0


@leaf
def _cuts(w0, w1, length, longest, log_step):
    """Number of cells of a row."""
    cells = math.ceil(length / longest)
    lo = min(w0, w1)
    hi = max(w0, w1)
    if hi > lo:
        if lo < _FIRST_SHARE * hi:
            return max(cells, 1 + math.ceil(math.log(1.0 / _FIRST_SHARE) / log_step))
        cells = max(cells, math.ceil(math.log(hi / lo) / log_step))
    return max(cells, 1)


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
def count_cells(x, w, longest, log_step):
    """Number of cells that `cut_rows` makes."""
    count = 0
    for i in range(x.shape[0] - 1):
        count += _cuts(w[i], w[i + 1], x[i + 1] - x[i], longest, log_step)
    return count


@kernel
def cut_rows(x, w, longest, log_step, node_x, node_w, row):
    """Cut rows into cells: equal steps of ln w, or of position where w hardly changes; no more than there is room."""
    n = 0
    node_x[0] = x[0]
    node_w[0] = w[0]
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        w0 = w[i]
        w1 = w[i + 1]
        parts = min(_cuts(w0, w1, d, longest, log_step), row.shape[0] - n)
        hi = max(w0, w1)
        uniform = hi - min(w0, w1) < _UNIFORM * hi
        bottom = _FIRST_SHARE * hi
        for j in range(1, parts + 1):
            share = j / parts
            if not uniform:
                if w0 < bottom:
                    u = bottom * (w1 / bottom) ** ((j - 1) / (parts - 1))
                elif w1 < bottom:
                    u = w0 * (bottom / w0) ** (j / (parts - 1)) if j < parts else w1
                else:
                    u = w0 * (w1 / w0) ** share
                share = (u - w0) / (w1 - w0)
            row[n] = i
            n += 1
            node_x[n] = x[i] + share * d
            node_w[n] = w0 + share * (w1 - w0)
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
