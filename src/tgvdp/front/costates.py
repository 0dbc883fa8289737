"""Costates along a run: what a lower bound is best evaluated with.

A run is cut into cells fine enough for a costate p that is linear in each, and every cell is labelled by its regime.
Along an optimal run p obeys, per unit of inertia and with κ·M as in `front.bounds`,

    p' = λ/(2v³) + 2p·∂ρ/∂w − κ·∂M/∂w,       κ = 1 + 2p (full traction), 0 (coasting), −2p (full braking)

and p = −½ while traction holds a speed, p = 0 while brakes do. At a switch between regimes p takes the value between
them, −½ or 0; where the run touches the speed limit p may jump downwards. So each phase is integrated from the end at
which p is known; where it is known at both, the two solutions are blended. Whatever p is, the bound stays valid.
"""

import math

import numpy as np

from tgvdp._jit import kernel, leaf
from tgvdp.front.bounds import merge_comfort, piece_value
from tgvdp.physics.forces import mean_resistance

TRACTION = 0
HOLDING = 1  # partial traction
COASTING = 2
HELD_BACK = 3  # partial braking
BRAKING = 4

#: Largest change of ln w within a cell, and cells per trip at least.
_LOG_STEP = 0.08
_CELLS_PER_TRIP = 300
#: At a standstill the first node lies at this share of the row's squared speed.
_FIRST_SHARE = 1e-4
#: Effort above this share of its limit counts as full.
_FULL_SHARE = 0.97
#: Effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4
#: Relative distance of w from the limit within which a run touches it.
_TOUCH = 1e-4

#: Phases shorter than this share of the trip are rounding errors.
_SLIVER = 1e-6
#: Relative difference of λ/(2v³) and ∂ρ/∂w above which a speed is not the optimal holding speed.
_OFF_HOLDING = 0.05

#: Partial effort over which p would change by less than this is none.
_NO_DRIFT = 3e-3


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
        uniform = hi - lo < 0.02 * hi
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
            continue  # the standstill cells have no costate
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
def tidy_labels(length, w, cap, label, source, growth):
    """Give cells that no optimal run could have the label of a neighbour; ``label`` (K,) in place.

    Slivers, and partial effort between other regimes away from both the limit and the optimal holding speed, at which
    λ/(2v³) = ∂ρ/∂w whatever the gradient: there the run only steps from one switching speed to the next.
    """
    count = label.shape[0]
    sliver = _SLIVER * length.sum()
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
                free = free and w[last] < cap[last] * (1.0 - _TOUCH) and w[last + 1] < cap[last] * (1.0 - _TOUCH)
                last += 1
            short = span <= sliver
            if sweep == 1:
                partial = label[k] == HOLDING or label[k] == HELD_BACK
                short = partial and scale < _NO_DRIFT or free and abs(drift) > _OFF_HOLDING * scale
            if short:
                neighbour = label[k - 1] if k > 0 else (label[last] if last < count else label[k])
                for j in range(k, last):
                    label[j] = neighbour
            k = last


@leaf
def _law(label):
    return 0 if label <= HOLDING else (1 if label == COASTING else 2)


@leaf
def _step(p, d, source, growth, j):
    """Value of p after ``d`` metres, negative: before, by the trapezoidal rule."""
    half = 0.5 * d * growth[j]
    half = min(max(half, -0.5), 0.5)
    return (p * (1.0 + half) + d * source[j]) / (1.0 - half)


@leaf
def _pin(before, after, touch):
    """Values of p that a switch of regimes fixes: at the end of the phase before, at the start of the phase after."""
    fixed_before = -0.5 if before == HOLDING else (0.0 if before == HELD_BACK else math.nan)
    fixed_after = -0.5 if after == HOLDING else (0.0 if after == HELD_BACK else math.nan)
    driving_before = before <= HOLDING
    braking_after = after >= HELD_BACK
    if driving_before and braking_after:
        return 0.0, 0.0  # coasting is too short to be seen
    if touch:
        if before == COASTING and braking_after:
            return 0.0, 0.0
        if driving_before and after == COASTING or before == TRACTION and after == HOLDING:
            return -0.5, -0.5
        return fixed_before, fixed_after
    if before <= COASTING and after <= COASTING:
        return (-0.5, -0.5) if before != after else (math.nan, math.nan)
    if before >= COASTING and after >= COASTING:
        return 0.0, 0.0
    return (0.0 if before >= HELD_BACK else fixed_before), -0.5  # braking to driving: a jump


@kernel
def _backward(first, last, p, length, label, source, growth, out):
    """Integrate from p at the end of cell ``last`` − 1 back to ``first``; the end of each cell in ``out`` (K + 1)."""
    out[last] = p
    ramp = p > -0.5 and label[last - 1] <= HOLDING
    for k in range(last - 1, first - 1, -1):
        if label[k] == HOLDING and not ramp:
            p = -0.5
        else:
            p = _step(p, -length[k], source[k], growth[k], 1 if ramp else _law(label[k]))
            if ramp and p <= -0.5:
                ramp = False
                if label[k] == HOLDING:
                    p = -0.5
        out[k] = p


@kernel
def _forward(first, last, p, length, label, source, growth, out):
    out[first] = p
    for k in range(first, last):
        if label[k] != HOLDING:
            p = _step(p, length[k], source[k], growth[k], _law(label[k]))
        out[k + 1] = p


@kernel
def _phase_end(k, label, w, cap):
    """First cell after the phase of cell k: another regime, or the run touches the limit there."""
    j = k + 1
    while j < label.shape[0] and label[j] == label[k]:
        top = min(cap[j - 1], cap[j]) * (1.0 - _TOUCH)
        peak = w[j] >= w[j - 1] and w[j] >= w[j + 1] and (w[j] > w[j - 1] or w[j] > w[j + 1])
        if label[k] != HOLDING and label[k] != HELD_BACK and w[j] >= top and peak:
            break
        j += 1
    return j


@kernel
def integrate_costates(length, w, cap, label, source, growth, left, right, ahead, back):
    """Costates at both ends of each cell, ``left`` and ``right`` (K,) in place; (K + 1,) scratch."""
    count = length.shape[0]
    first = 1 if w[0] == 0.0 else 0
    stop = count - 1 if w[count] == 0.0 else count
    k = first
    start_pin = math.nan
    while k < stop:
        last = min(_phase_end(k, label, w, cap), stop)
        end_pin = math.nan
        next_pin = math.nan
        if last < stop:
            touch = w[last] >= min(cap[last - 1], cap[last]) * (1.0 - _TOUCH)
            end_pin, next_pin = _pin(label[k], label[last], touch)
        if label[k] == HOLDING and not end_pin > -0.5:
            for j in range(k, last):
                left[j] = right[j] = -0.5
        elif label[k] == HELD_BACK:
            for j in range(k, last):
                left[j] = right[j] = 0.0
        else:
            if math.isnan(start_pin) and math.isnan(end_pin):
                start_pin = right[k - 1] if k > first else (-0.5 if label[k] == TRACTION else 0.0)
            use_back = not math.isnan(end_pin)
            use_ahead = not math.isnan(start_pin) and not label[k] == HOLDING
            if use_back:
                _backward(k, last, end_pin, length, label, source, growth, back)
            if use_ahead:
                _forward(k, last, start_pin, length, label, source, growth, ahead)
            span = 0.0
            for j in range(k, last):
                span += length[j]
            done = 0.0
            for j in range(k, last):
                share = done / span if use_ahead else 1.0
                done += length[j]
                after = done / span if use_ahead else 1.0
                left[j] = 0.0
                right[j] = 0.0
                if use_back:
                    left[j] += share * back[j]
                    right[j] += after * back[j + 1]
                else:
                    share = 0.0
                    after = 0.0
                if use_ahead:
                    left[j] += (1.0 - share) * ahead[j]
                    right[j] += (1.0 - after) * ahead[j + 1]
        start_pin = next_pin
        k = last
    if first == 1:
        left[0] = right[0] = left[1]
    if stop == count - 1:
        left[count - 1] = right[count - 1] = right[count - 2]
