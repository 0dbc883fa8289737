"""A run in cells and phases: cut fine enough for a costate that is linear in each cell, labelled by regime."""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.front.pieces import merge_comfort, piece_value
from tgvdp.physics.forces import mean_resistance

TRACTION = 0
HOLDING = 1  # partial traction
COASTING = 2
HELD_BACK = 3  # partial braking
BRAKING = 4

#: Largest change of ln w within a cell.
_LOG_STEP = 0.08
#: A row whose w changes by less than this share is cut into equal lengths, others into equal steps of ln w.
_UNIFORM = 0.02
#: At a standstill the first node lies at this share of the row's squared speed.
_FIRST_SHARE = 1e-4
#: Effort above this share of its limit counts as full.
_FULL_SHARE = 0.97
#: Effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4
#: Relative distance of w from the limit within which a run touches it.
TOUCH = 1e-4
#: Relative difference of λ/(2v³) and ∂ρ/∂w above which a speed is not the optimal holding speed.
_OFF_HOLDING = 0.05
#: Partial effort over which p would change by less than this is none.
_NO_DRIFT = 3e-3


@leaf
def is_standstill(end_w, next_w):
    """Whether the cell at an end of a trip holds a (near) standstill: no other cell spans such a ratio of speeds."""
    return end_w < 0.5 * next_w


@leaf
def _parts(w0, w1, length, longest):
    """Number of cells of a row."""
    parts = math.ceil(length / longest)
    lo = min(w0, w1)
    hi = max(w0, w1)
    if lo < _FIRST_SHARE * hi:
        lo = _FIRST_SHARE * hi
        parts = max(parts, 1 + math.ceil(math.log(hi / lo) / _LOG_STEP))
    elif hi > lo:
        parts = max(parts, math.ceil(math.log(hi / lo) / _LOG_STEP))
    return max(parts, 1)


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
def count_cells(x, w, longest):
    """Number of cells that `cut_rows` makes."""
    count = 0
    for i in range(x.shape[0] - 1):
        count += _parts(w[i], w[i + 1], x[i + 1] - x[i], longest)
    return count


@kernel
def cut_rows(x, w, longest, node_x, node_w, row):
    """Cut rows into cells: equal steps of ln w, or of position where w hardly changes."""
    n = 0
    node_x[0] = x[0]
    node_w[0] = w[0]
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        w0 = w[i]
        w1 = w[i + 1]
        parts = _parts(w0, w1, d, longest)
        lo = min(w0, w1)
        hi = max(w0, w1)
        uniform = hi - lo < _UNIFORM * hi
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


@kernel
def row_efforts(train, x, w, grade, air, effort):
    """Mean effort of each row in N, positive traction; ``effort`` (n − 1,) in place."""
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        load = mean_resistance(train, air[i], math.sqrt(w[i]), math.sqrt(w[i + 1])) + grade[i]
        effort[i] = 0.5 * train.inertia_kg * (w[i + 1] - w[i]) / d + load


@leaf
def _by_w(pieces, n, v, m1, m3):
    """Derivative by w of a table of pieces, averaged over a cell: ``m1``, ``m3`` are the means of 1/v and 1/v³."""
    i = n - 1
    while i > 0 and pieces[i, 0] > v:
        i -= 1
    return -0.5 * pieces[i, 1] * m3 + 0.5 * pieces[i, 3] * m1 + pieces[i, 4] + 1.5 * pieces[i, 5] * v


@kernel
def label_cells(train, length, grade, air, cap, w, effort, price, pull, brake, label, source, growth):
    """Label cells by regime, with the coefficients of p' = source + growth·p in it.

    ``effort`` is the mean effort in N of the row that a cell belongs to; (K,) int8 ``label`` and (K, 3) float64
    ``source`` and ``growth`` in place: one column each for traction, coasting and braking.
    """
    mass = train.inertia_kg
    r1 = train.davis_b / mass
    no_effort = _NO_EFFORT * train.traction[0, 2]
    pulls = 0
    brakes = 0
    for k in range(length.shape[0]):
        r0 = (train.davis_a_n + grade[k]) / mass
        r2 = air[k] / mass
        if k == 0 or grade[k] != grade[k - 1] or air[k] != air[k - 1] or cap[k] != cap[k - 1]:
            top_v = math.sqrt(cap[k])
            pulls = merge_comfort(train.traction, 0.0, mass, train.max_acceleration, r0, r1, r2, top_v, pull)
            brakes = merge_comfort(
                train.braking, train.friction_n, mass, train.max_deceleration, -r0, -r1, -r2, top_v, brake
            )
        v0 = math.sqrt(w[k])
        v1 = math.sqrt(w[k + 1])
        v = 0.5 * (v0 + v1)
        table = pull if effort[k] > 0.0 else brake
        i = (pulls if effort[k] > 0.0 else brakes) - 1
        while i > 0 and table[i, 0] > v:
            i -= 1
        full = abs(effort[k]) >= _FULL_SHARE * mass * piece_value(table, i, v)
        if abs(effort[k]) <= no_effort:
            label[k] = COASTING
        elif effort[k] > 0.0:
            label[k] = TRACTION if full else HOLDING
        else:
            label[k] = BRAKING if full else HELD_BACK
        if v0 <= 0.0 or v1 <= 0.0:
            continue  # cells at a standstill have no costate
        m1 = 1.0 / v
        m3 = 1.0 / (v0 * v1 * v)
        load_w = 0.5 * r1 * m1 + r2
        pull_w = _by_w(pull, pulls, v, m1, m3)
        brake_w = _by_w(brake, brakes, v, m1, m3)
        for j in range(3):
            source[k, j] = 0.5 * price * m3
            growth[k, j] = 2.0 * load_w
        source[k, 0] -= pull_w
        growth[k, 0] -= 2.0 * pull_w
        growth[k, 2] += 2.0 * brake_w


@kernel
def tidy_labels(sliver, length, w, cap, label, source, growth):
    """Give cells that no optimal run could have the label of a neighbour; ``label`` (K,) in place.

    Such are phases shorter than ``sliver`` metres, and partial effort away from both the limit and the optimal holding
    speed, at which λ/(2v³) = ∂ρ/∂w whatever the gradient: the run only steps from one switching speed to the next.
    """
    count = label.shape[0]
    for sweep in range(2):
        k = 0
        while k < count:
            last = k
            span = 0.0
            drift = 0.0
            scale = 0.0
            free = label[k] == HOLDING or label[k] == HELD_BACK
            while last < count and label[last] == label[k]:
                span += length[last]
                drift += (source[last, 1] - 0.5 * growth[last, 1]) * length[last]
                scale += source[last, 1] * length[last]
                free = free and w[last] < cap[last] * (1.0 - TOUCH) and w[last + 1] < cap[last] * (1.0 - TOUCH)
                last += 1
            short = span <= sliver
            if sweep == 1:
                partial = label[k] == HOLDING or label[k] == HELD_BACK
                short = (partial and scale < _NO_DRIFT) or (free and abs(drift) > _OFF_HOLDING * scale)
            if short:
                neighbour = label[k - 1] if k > 0 else (label[last] if last < count else label[k])
                for j in range(k, last):
                    label[j] = neighbour
            k = last


@kernel
def phase_end(k, label, w, cap):
    """First cell after the phase of cell k: another regime, or the run touches the limit there."""
    j = k + 1
    while j < label.shape[0] and label[j] == label[k]:
        top = min(cap[j - 1], cap[j]) * (1.0 - TOUCH)
        peak = w[j] >= w[j - 1] and w[j] >= w[j + 1] and (w[j] > w[j - 1] or w[j] > w[j + 1])
        if label[k] != HOLDING and label[k] != HELD_BACK and w[j] >= top and peak:
            break
        j += 1
    return j
