"""One step of the backward pass: the costate polyline at the end of a cell, carried to its start."""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.methods.costate.characteristics import coast_image, coast_on, holding_costate
from tgvdp.methods.costate.polyline import insert
from tgvdp.methods.costate.step_edges import drop_below
from tgvdp.methods.costate.step_held import HELD, hold, meet_region
from tgvdp.methods.costate.step_interval import coasting_regions
from tgvdp.methods.costate.step_regions import brake_region, coast_region, drive_region, friction_region
from tgvdp.methods.costate.step_wall import dynamic_suffices, wall_region
from tgvdp.physics.codes import COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import effort_at

#: A switching speed beyond the wall is at most this multiple of it.
_BEYOND = 4.0


@part
def coast_over(train, step, line, n, brakes, images, scratch):
    """Images of the polyline one cell back without current, for the train without it.

    Up to the point ``brakes``, where p = 0, runs coast, and friction keeps the wall; beyond it friction brakes them.
    Returns the number of images.
    """
    x, y = images
    m = coast_region(train, step, line, 0, brakes, images, 0)
    if brakes < n - 1:
        if m == 0:  # a descent so steep that runs from all lower speeds are braked
            x[0] = step.bottom
            y[0] = min(holding_costate(train, step, step.bottom, line.w[brakes]), 0.0)
            m = 1
        m = friction_region(train, step, line, brakes, n - 1, images, 0, 0, m, scratch)
    elif m == 0 or x[m - 1] < step.top:
        m = wall_region(train, COASTING, step, images, m)
    if x[0] > step.bottom:  # too slow a run cannot speed up
        m = insert(images, m, 0, step.bottom, min(holding_costate(train, step, step.bottom, line.w[0]), y[0]))
    return m


@leaf
def _holds_wall(train, step):
    """Whether the wall is a speed limit that traction holds: runs under full traction come to it with p = −½."""
    v = math.sqrt(step.wall)
    load = step.load + v * (train.davis_b + v * step.air)
    return step.top == step.wall and 0.0 <= load <= effort_at(train.traction, v)


@part
def _coasts_from(train, step, line, drives, coasts, before_w, after_w):
    """Over which length, at the end of the cell, a run coasts that has gone along a curve until p = −½, and its end.

    The curve goes from one squared speed to another, nearly straight. The run ends at one of the points ``drives`` to
    ``coasts``, or between two of them. The length is 0 where there is no such run.
    """
    w, p = line
    length = step.length
    rise = (after_w - before_w) / length
    reached_m = reached_w = reached_p = 0.0
    for i in range(drives, coasts + 1):
        middle = 0.5 * (after_w + w[i])
        falls = 2.0 * (step.load + math.sqrt(middle) * train.davis_b + step.air * middle)
        coasted_m = max(after_w - w[i], 0.0) / (falls + rise) if falls + rise > 0.0 else math.inf
        if coasted_m > length:  # it never comes from the curve
            continue
        if reached_m == 0.0 and i > drives:  # one between the point before and this one comes from where that begins
            reached_m = length
            reached_w = max(before_w - falls * length, w[i - 1])
            end_p = p[i - 1] + (reached_w - w[i - 1]) / (w[i] - w[i - 1]) * (p[i] - p[i - 1])
            reached_p = coast_image(train, step, length, reached_w, end_p)[1]
            if reached_p >= -0.5:
                return 0.0, w[i]
        p0 = coast_image(train, step, coasted_m, w[i], p[i])[1]
        if p0 >= -0.5:
            share = (-0.5 - reached_p) / (p0 - reached_p) if i > drives else 1.0
            return reached_m + share * (coasted_m - reached_m), reached_w + share * (w[i] - reached_w)
        reached_m = coasted_m
        reached_w = w[i]
        reached_p = p0
    return 0.0, after_w


@part
def _falls_from(train, step, line, drives, coasts, driven_w, coasted_w, switch):
    """Switching speed after the cell for a line of switching that begins it beyond a curve, if there is one.

    That is a speed that is held, if it lies between the last image that is driven and the first one that is coasted, or
    the envelope. The line is straight, and on the curve where a run that has gone along it begins to coast.
    """
    a = line.w[drives]
    held = driven_w < step.held_w < coasted_w
    if not held and coasted_w < step.top:
        return switch
    before_w = min(step.top, step.held_w) if held else step.top
    after_w = min(step.wall, step.held_w) if held else step.wall
    if a >= after_w:
        return switch
    coasted_m, ends = _coasts_from(train, step, line, drives, coasts, before_w, after_w)
    if coasted_m == 0.0:
        return switch
    return max(a + (ends - a) * step.length / coasted_m, a * (1.0 + 2.0 * HELD))


@kernel
def transport(train, step, line, n, drives, early, late, coasts, brakes, images, scratch):
    """Images of the polyline one cell back.

    Full traction keeps p ≤ −½ within the cell, coasting p ≥ −½ (and p ≤ −r/2, dynamic braking p ≥ −r/2): images that do
    not are dropped. Where p rises along the cell, as it does below the holding speed, runs between the two regimes
    change from one to the other within it; there, and where a speed is held, p is interpolated.

    Parameters
    ----------
    train : KernelTrain
        Per unit of inertia.
    step : Step
    line : Polyline
        Of ``n`` points, the crossings of its levels among them.
    n, drives, early, late, coasts, brakes : int
        Points up to the crossing ``drives`` drive, from there up to ``coasts`` they coast, but for an interval from
        ``early`` to ``late`` of those that brake dynamically, as they do up to ``brakes``; the others use all brakes.
    images : Polyline, modified in place
    scratch : Rows

    Returns
    -------
    m : int
        Number of images, in the order of the points, not necessarily monotone.
    switch : float
        Squared speed after the cell of a run with p = −½ before it and one regime throughout.
    """
    x, y = images
    top = step.top
    wall = step.wall
    a = line.w[drives]
    m, switch = drive_region(train, step, line, drives, images)
    while m > 1 and x[m - 2] > top:
        m -= 1
    if m > 0 and x[m - 1] > top:
        return m, a
    driven = m > 0
    if not driven:
        x[0] = step.bottom
        y[0] = min(holding_costate(train, step, step.bottom, a), -0.5)
        m = 1
    if a >= wall and _holds_wall(train, step):
        x[m] = top
        y[m] = -0.5
        return meet_region(train, TRACTION, step, top, -0.5, m, x[m - 1], images, m + 1), a
    first = m
    m, start = coasting_regions(train, step, line, drives, early, late, coasts, images, m)
    if not driven and m > first and x[first] <= step.bottom:  # coasting alone covers everything
        x[0] = x[first]
        y[0] = y[first]
    if x[m - 1] < top:
        regime = COASTING
        if step.returned > 0.0:
            if not dynamic_suffices(step):
                regime = DYNAMIC
            if regime == DYNAMIC or coasts < n - 1:
                m = brake_region(train, DYNAMIC, step, line, coasts, brakes, images, start, m, scratch)
        if x[m - 1] < top and brakes == n - 1:
            m = wall_region(train, regime, step, images, m)
        if step.returned > 0.0:
            m = friction_region(train, step, line, brakes, n - 1, images, first, start, m, scratch)
    if m == first:
        return m, switch
    if y[first] >= -0.5:
        switch = _falls_from(train, step, line, drives, coasts, x[first - 1], x[first], switch)
        return hold(train, TRACTION, COASTING, step, step.held_w, -0.5, first, m, images), switch
    lowest = y[first]
    highest = y[m - 1]
    m = drop_below(-0.5, images, first, m)
    if m > first:
        switch = min(coast_on(train, step, x[first]), wall)
        if a != step.held_w:  # where p jumps the line falls to that speed, which nobody holds
            switch = max(switch, a * (1.0 + 2.0 * HELD))
        switch = _falls_from(train, step, line, drives, coasts, x[first - 1], x[first], switch)
        return hold(train, TRACTION, COASTING, step, step.held_w, -0.5, first, m, images), switch
    # Below −½ up to the wall: only from beyond it would a run coast throughout.
    switch = wall
    if a < wall and highest > lowest:
        switch = min(a + (wall - a) * (-0.5 - lowest) / (highest - lowest), _BEYOND * wall)
    x[m] = coast_image(train, step, step.length, switch, -0.5)[0]
    y[m] = -0.5
    return m + 1, _falls_from(train, step, line, drives, coasts, top, top, switch)
