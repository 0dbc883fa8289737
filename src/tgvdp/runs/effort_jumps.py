"""Rows along which an effort limit jumps, cut where it does.

A row has one acceleration, and a search may check its mean effort alone. Where the limit jumps between its speeds no
train drives it so: it gains speed fast before a drop of its traction and slowly after it.
"""

import math
from collections.abc import Sequence

import numpy as np

from tgvdp._jit import kernel, leaf, part
from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import ResolvedLine
from tgvdp.model.track import POWERED
from tgvdp.model.train import Train
from tgvdp.physics.forces import effort_at, kernel_train, mean_brake, mean_effort, mean_resistance, unpowered
from tgvdp.physics.march import BELOW_DROP

#: An effort below this share of the starting effort counts as none.
NO_EFFORT = 3e-5
#: A speed is between two others when w is by more than this share; nearer ones are one.
_BETWEEN = 1e-8
#: The effort of a row is found by so many doublings and halvings.
_DOUBLINGS = 20
_HALVINGS = 50
#: A row that is longer at full effort by this share at most is taken to be at full effort.
_STRETCH = 0.1


def jumps_of(train: Train) -> tuple[Sequence[float], Sequence[float]]:
    """Speeds at which the limit of traction, and that of the brakes, jumps, m/s."""
    if train.braking_rates:
        return train.traction_limit.jumps_mps, [rate.from_mps for rate in train.braking_rates[1:]]
    return train.traction_limit.jumps_mps, train.dynamic_brake_limit.jumps_mps


def cut_at_jumps(train: Train, line: ResolvedLine, x_m: Floats, w: Floats) -> tuple[Floats, Floats]:
    """Cut rows where the limit of traction or brakes jumps between their speeds.

    The effort along such a row is the same throughout, but where its limit is below that. A row that keeps its effort
    throughout is left as it is.

    Parameters
    ----------
    train : Train
    line : ResolvedLine
    x_m, w : (n,) float64
        Rows of a run: positions from the origin, m, with all breaks among them, and squared speeds, m²/s².

    Returns
    -------
    x_m, w : (m,) float64
        The rows given, where none crosses a jump.
    """
    traction_mps, brakes_mps = jumps_of(train)
    if not traction_mps and not brakes_mps:
        return x_m, w
    traction_w, brakes_w = np.array(traction_mps) ** 2, np.array(brakes_mps) ** 2
    w = _below_drops(traction_w, w)
    least, most = np.minimum(w[:-1], w[1:]) * (1.0 + _BETWEEN), np.maximum(w[:-1], w[1:]) * (1.0 - _BETWEEN)
    crossings = sum(int(np.sum((least < jump_w) & (jump_w < most))) for jump_w in (*traction_w, *brakes_w))
    if crossings == 0:
        return x_m, w
    cut_m, cut_w = np.empty((2, len(x_m) + crossings))
    n = _cut(kernel_train(train), line, traction_w, brakes_w, x_m, w, cut_m, cut_w)
    return (cut_m[:n], cut_w[:n]) if n > len(x_m) else (x_m, w)


def _below_drops(traction_w: Floats, w: Floats) -> Floats:
    """Squared speeds with those that are at a jump of traction just below it, as a train that is held there runs."""
    inner = w[1:-1]
    for jump_w in traction_w:
        inner = np.where(np.abs(inner - jump_w) <= _BETWEEN * jump_w, jump_w * (1.0 - BELOW_DROP), inner)
    return np.concatenate((w[:1], inner, w[-1:]))


@leaf
def _is_between(jump, w0, w1):
    return min(w0, w1) * (1.0 + _BETWEEN) < jump < max(w0, w1) * (1.0 - _BETWEEN)


@leaf
def _way(train, pulls, effort, grade, air, w0, w1):
    """Length of way, m, from one speed to another at an effort, or its limit if that is less; and that limit, N.

    An infinite length where that effort does not lead from one to the other.
    """
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    load = mean_resistance(train, air, v0, v1) + grade
    limit = mean_effort(train.traction, v0, v1) if pulls else mean_brake(train, load, v0, v1)
    if pulls:
        net = min(min(effort, limit) - load, max(train.inertia_kg * train.max_acceleration, -load))
    else:
        net = max(-min(effort, limit) - load, min(-train.inertia_kg * train.max_deceleration, -load))
    if net * (w1 - w0) <= 0.0:
        return math.inf, limit
    return 0.5 * train.inertia_kg * (w1 - w0) / net, limit


@part
def _place(train, jumps, pulls, effort, grade, air, w0, w1, x, xs, ws, n):
    """Append the jumps between two squared speeds at an effort, from x on.

    Returns the length of the row, the lowest limit between two jumps, and n.
    """
    rises = w1 > w0
    length = 0.0
    lowest = math.inf
    w = w0
    i = 0 if rises else jumps.shape[0] - 1
    while w != w1:
        while 0 <= i < jumps.shape[0] and not _is_between(jumps[i], w0, w1):
            i += 1 if rises else -1
        end = jumps[i] if 0 <= i < jumps.shape[0] else w1
        way, limit = _way(train, pulls, effort, grade, air, w, end)
        length += way
        lowest = min(lowest, limit)
        w = end
        if w != w1:
            xs[n] = x + length
            ws[n] = w
            n += 1
            i += 1 if rises else -1
    return length, lowest, n


@part
def _cut_row(train, jumps, effort, grade, air, w0, w1, x, d, xs, ws, n):
    """Append the jumps along one row, by the effort that makes it as long as it is; returns n.

    None where the effort is within the limit throughout, and none where no effort leads from one end to the other,
    unless the largest is too weak by no more than it was checked to.
    """
    pulls = effort > 0.0
    speeds_up = pulls == (w1 > w0)  # more effort makes the row shorter; else longer
    low = abs(effort)
    if low <= _place(train, jumps, pulls, low, grade, air, w0, w1, x, xs, ws, n)[1]:
        return n
    high = low
    for _ in range(_DOUBLINGS):
        length = _place(train, jumps, pulls, high, grade, air, w0, w1, x, xs, ws, n)[0]
        if (length <= d) == speeds_up:
            break
        low = high
        high *= 2.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        length = _place(train, jumps, pulls, middle, grade, air, w0, w1, x, xs, ws, n)[0]
        if (length <= d) == speeds_up:
            high = middle
        else:
            low = middle
    length, _, after = _place(train, jumps, pulls, high if speeds_up else low, grade, air, w0, w1, x, xs, ws, n)
    if abs(length - d) > _STRETCH * d:
        return n
    for i in range(n, after):
        xs[i] = x + (xs[i] - x) * (d / length)
    return after


@kernel
def _cut(known, line, traction_w, brakes_w, x, w, xs, ws):
    """Append all rows with what they are cut into; returns their number."""
    dark = unpowered(known)
    xs[0] = x[0]
    ws[0] = w[0]
    n = 1
    step = 0
    for k in range(x.shape[0] - 1):
        d = x[k + 1] - x[k]
        while step + 1 < line.grade_n.shape[0] and line.break_m[step + 1] <= x[k] + 0.5 * d:
            step += 1
        train = known if line.supply[step] == POWERED else dark
        grade, air = line.grade_n[step], line.air[step]
        mean_load = mean_resistance(train, air, math.sqrt(w[k]), math.sqrt(w[k + 1])) + grade
        effort = 0.5 * train.inertia_kg * (w[k + 1] - w[k]) / d + mean_load
        jumps = traction_w if effort > 0.0 else brakes_w
        if abs(effort) <= NO_EFFORT * effort_at(known.traction, 0.0):
            jumps = jumps[:0]
        for i in range(jumps.shape[0]):
            if _is_between(jumps[i], w[k], w[k + 1]):
                n = _cut_row(train, jumps, effort, grade, air, w[k], w[k + 1], x[k], d, xs, ws, n)
                break
        xs[n] = x[k + 1]
        ws[n] = w[k + 1]
        n += 1
    return n
