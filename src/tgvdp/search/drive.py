"""Drive a train by switching speeds: the forward pass of the front method.

A policy gives one switching speed a for every station: full traction below it, coasting above it, holding at it, and
braking as late as the envelope of feasible speeds allows. The run is exact within each cell: it reaches a where it
reaches it, and coasting ends where it meets the braking curve.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.line.meeting import SLIVER, braked_w, drive_then_brake, drop_slivers
from tgvdp.physics.arc import OK, arc
from tgvdp.physics.forces import mean_effort, mean_resistance, resistance_at, unpowered
from tgvdp.physics.motion import BRAKING, COASTING, TRACTION, land, march
from tgvdp.physics.resolved import POWERED

#: Below this share of full traction a change of speed is spread over the cell: it is a drift of the holding speed.
_GENTLE_SHARE = 0.5
#: Relative distance in v² within which a run is on the braking curve.
_ON_CURVE = 1e-8


@part
def _append(x, w, xs, ws, n):
    xs[n] = x
    ws[n] = w
    return n + 1


@part
def _coast(train, length, grade, air, w):
    """`land` under coasting, without its generality: the resistance is nearly linear in w1, three sweeps solve it."""
    v = math.sqrt(w)
    factor = 2.0 * length / train.inertia_kg
    slope = 0.5 * air
    if v > 0.0:
        slope += 0.25 * train.davis_b / v
    damping = 1.0 / (1.0 + factor * slope)
    x = max(w - factor * damping * (resistance_at(train, air, v) + grade), 0.0)
    if train.davis_b > 0.0:
        for _ in range(2):
            load = mean_resistance(train, air, v, math.sqrt(x)) + grade
            x = max(x + damping * (w - factor * load - x), 0.0)
    gain = 0.5 * (x - w) / length
    if gain > train.max_acceleration or -gain > train.max_deceleration:
        return land(train, COASTING, 1.0, length, grade, air, w)
    return x


@part
def _brake_late(train, start, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n):
    """Coast from w and brake as late as possible to end at ``top``, where coasting alone would end above it."""
    braked = braked_w(train, grade, air, top, limit, rest, bx, bw)
    if w > braked * (1.0 + _ON_CURVE):
        first = n
        n = march(train, BRAKING, 1.0, rest, grade, air, w, top, xs, ws, n)[2]
        for i in range(first, n):
            xs[i] += start
        xs[n - 1] = end
        return n
    return drive_then_brake(train, COASTING, start, end, rest, grade, air, limit, w, top, bx, bw, xs, ws, n)


@part
def _drive_cell(train, start, end, length, grade, air, limit, w, a, top, bx, bw, xs, ws, n):
    """Append the rows of one cell, from w, with the switching speed a and the envelope ``top`` at its end."""
    rest = length
    if w < a * (1.0 - _ON_CURVE):
        status, _, work = arc(train, rest, grade, air, w, a)
        gentle = _GENTLE_SHARE * rest * mean_effort(train.traction, math.sqrt(w), math.sqrt(a))
        if work >= 0.0 and (status != OK or work > gentle):
            first = n
            used, w, n = march(train, TRACTION, 1.0, rest, grade, air, w, a, xs, ws, n)
            for i in range(first, n):
                xs[i] += start
            rest -= used
            if rest <= 1e-12 * length:
                xs[n - 1] = end
                return n
    status, _, work = arc(train, rest, grade, air, w, a)
    if work < 0.0:
        landed = _coast(train, rest, grade, air, w)
        if landed <= top:
            return _append(end, landed, xs, ws, n)
        return _brake_late(train, end - rest, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n)
    if status == OK:
        return _append(end, a, xs, ws, n)
    first = n
    n = march(train, TRACTION, 1.0, rest, grade, air, w, math.inf, xs, ws, n)[2]
    for i in range(first, n):
        xs[i] += end - rest
    xs[n - 1] = end
    return n


@kernel
def drive(
    train, station, length, grade, air, limit, supply, low, fast, start_w, switch_a, switch_b, share, xs, ws, bx, bw
):
    """Drive the whole trip by a blend of two policies.

    Parameters
    ----------
    train : KernelTrain
    station, length, grade, air, limit, supply
        Arrays of `Cells`.
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speed at each station.
    start_w : float
        Squared speed at the origin.
    switch_a, switch_b : (K + 1,) float64
        Two policies: squared switching speeds for the station at the end of each cell.
    share : float
        Weight of the second policy.
    xs, ws : (size,) float64, modified in place
        Rows of the run: positions from the origin, squared speeds.
    bx, bw : (size,) float64
        Scratch.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small.
    time_s, energy_j : float
        Running time and traction energy.
    """
    count = length.shape[0]
    xs[0] = 0.0
    ws[0] = start_w
    n = 1
    time = 0.0
    energy = 0.0
    dark = unpowered(train)
    for k in range(count):
        if n + 2048 > xs.shape[0]:
            return -1, time, energy
        top = fast[k + 1]
        bottom = low[k + 1]
        a = switch_a[k + 1] + share * (switch_b[k + 1] - switch_a[k + 1])
        a = max(min(a, top), bottom)
        first = n
        here = train if supply[k] == POWERED else dark
        n = _drive_cell(
            here,
            station[k],
            station[k + 1],
            length[k],
            grade[k],
            air[k],
            limit[k],
            ws[n - 1],
            a,
            top,
            bx,
            bw,
            xs,
            ws,
            n,
        )
        n = drop_slivers(xs, ws, first, n, SLIVER * length[k])
        ws[n - 1] = max(min(ws[n - 1], top), bottom)
        for i in range(first, n):
            _, duration, work = arc(here, xs[i] - xs[i - 1], grade[k], air[k], ws[i - 1], ws[i])
            time += duration
            energy += max(work, 0.0)
    return n, time, energy
