"""Descend to the extremal of a multiplier: Newton's steps in all switches, block by block, each along its own line.

A block is a chain of switches with no anchor between it and the next one; at one multiplier blocks are independent.
Each takes Newton's step of the sweep as a direction, and searches along it for less E + λT: slopes at both ends of a
bracket yield the zero of a smooth slope, or where two tangents meet, which finds kinks as fast. A kink is where the run
just touches the envelope: its switch is pinned there, and the run before joins the one after it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.course import account
from tgvdp.methods.extremal.simulate import (
    AT,
    BOUND,
    COMMAND_COLUMNS,
    HOLDS_FROM,
    MOST_EVENTS,
    REGIME,
    Rows,
    is_anchor,
    rows_of,
    simulate,
    simulate_from,
)  # fmt: skip
from tgvdp.methods.extremal.sweep import (
    ACTIVE,
    CROSS,
    CURVATURE,
    FIXED,
    FLOW,
    GAIN,
    JUMP,
    PINNED,
    SLOPE,
    SWITCH_COLUMNS,
    sweep,
)  # fmt: skip
from tgvdp.physics.codes import TRACTION

MOST_COMMANDS = 400
#: A block rests when its step promises less than this share of E + λT.
_ENOUGH = 1e-11
#: A bracket ends when no point of it can be better by this share; a corner is left for a thousand times that gain.
_NO_MORE = 1e-10
#: A slope that has fallen to this share is flat enough for a new direction.
_FLAT = 0.25
#: Longest step, as a share of the distance.
_LONGEST = 0.03
#: Share of the distance within which the first switch of a block may move back at once.
_NEAR = 0.01
#: Distance, as a share of that of the trip, within which traction belongs to a corner.
_REACH = 1.5e-3
#: ... and within which two runs meet an anchor at the same place.
_APART = 1e-5
_MOST_TURNS = 24
_MOST_STEPS = 16
_MOST_PINS = 4
#: Where slopes differ by so many times as much as those of a parabola there is a kink.
_KINK = 5.0


class Work(NamedTuple):
    """Room for a descent: the whole run, its sweep, and two runs of a block."""

    whole: Rows
    starts: NDArray[np.int64]
    found: NDArray[np.float64]
    events: NDArray[np.float64]
    p_at: NDArray[np.float64]
    q_at: NDArray[np.float64]
    pinned: NDArray[np.int64]
    direction: NDArray[np.float64]
    trial: NDArray[np.float64]
    here: Rows
    there: Rows
    here_starts: NDArray[np.int64]
    there_starts: NDArray[np.int64]
    here_found: NDArray[np.float64]
    there_found: NDArray[np.float64]
    scratch: NDArray[np.float64]


def work_of(size: int) -> Work:
    """Room for descents of runs of at most so many rows."""
    count = MOST_COMMANDS
    starts, pinned, here_starts, there_starts = np.zeros((4, count), dtype=np.int64)
    found, here_found, there_found = np.zeros((3, count, SWITCH_COLUMNS))
    p_at, q_at = np.zeros((2, size))
    return Work(
        rows_of(size), starts, found, np.zeros((MOST_EVENTS, 3)), p_at, q_at, pinned, np.zeros(count),
        np.zeros((count, COMMAND_COLUMNS)), rows_of(size), rows_of(size), here_starts, there_starts, here_found,
        there_found, np.zeros((2, size)),
    )  # fmt: skip


@part
def cost_at(train, course, price, rows, n, x):
    """E + λT from the start up to a position, and the squared speed there."""
    lo = 0
    hi = n - 1
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if rows.x[middle] <= x:
            lo = middle
        else:
            hi = middle
    d = rows.x[hi] - rows.x[lo]
    part_m = min(max(x - rows.x[lo], 0.0), d)
    cost = rows.energy[lo] + price * rows.time[lo]
    if part_m <= 0.0:
        return cost, rows.w[lo]
    if part_m >= d:
        return rows.energy[hi] + price * rows.time[hi], rows.w[hi]
    w = rows.w[lo] + (rows.w[hi] - rows.w[lo]) * part_m / d
    k = rows.cell[hi]
    duration, energy, _ = account(train, course.returned, course.grade[k], course.air[k], part_m, rows.w[lo], w)
    return cost + energy + price * duration, w


@part
def _direct(commands, first, last, count, x0, end, found, pinned, direction):
    """Newton's direction of the switches first … last − 1; returns the slope along it, and its longest share."""
    slope = 0.0
    for attempt in range(2):
        slope = 0.0
        dw = 0.0
        before = -1
        for i in range(first, last):
            row = found[i]
            direction[i] = 0.0
            if row[ACTIVE] == 0.0 or pinned[i] == FIXED:
                continue
            dw = row[FLOW] * (dw + 2.0 * found[before, JUMP] * direction[before]) if before >= 0 else 0.0
            if pinned[i] == PINNED:
                direction[i] = -dw / (2.0 * row[JUMP])
            elif attempt == 0:
                direction[i] = -(row[GAIN] + row[CROSS] * dw) / row[CURVATURE]
            else:
                direction[i] = -row[SLOPE] / row[CURVATURE]
            slope += row[SLOPE] * direction[i]
            before = i
        if slope <= 0.0:
            break
    share = 1.0
    for i in range(first, last):
        d = direction[i]
        if abs(d) > _LONGEST * end:
            share = min(share, _LONGEST * end / abs(d))
        room = (commands[i + 1, AT] if i + 1 < count else end) - commands[i, AT]
        other = direction[i + 1] if i + 1 < last else 0.0
        if d - other > 0.0 and share * (d - other) > 0.9 * room:
            share = 0.9 * room / (d - other)
        if i == first and i > 0:
            room = commands[i, AT] - max(commands[i - 1, AT], x0)
            if -d > 0.0 and share * -d > 0.9 * room:
                share = 0.9 * room / -d
    return slope, share


@part
def _next_share(turns, lo, lo_cost, lo_slope, hi, hi_cost, hi_slope):
    """Where to look next between two ends of a bracket."""
    width = hi - lo
    share = 0.5
    if hi_slope > 0.0:
        if turns % 2 == 1:
            share = -lo_slope / (hi_slope - lo_slope)
        else:
            share = (hi_cost - lo_cost - hi_slope * width) / ((lo_slope - hi_slope) * width)
        if turns % 6 == 5:
            share = 0.5
    return lo + width * min(max(share, 1e-4), 1.0 - 1e-4)


@part
def _fix_corners(course, commands, count, reach, pinned):
    """Fix traction that begins near the end of a braking curve there: a run that touches it goes on along the limit."""
    for i in range(1, count):
        pinned[i] = int(commands[i, BOUND])
        if commands[i, REGIME] != TRACTION or commands[i - 1, REGIME] == TRACTION:
            continue
        x = commands[i, AT]
        at = np.searchsorted(course.corner_m, x)
        for j in range(max(at - 1, 0), min(at + 1, course.corner_m.shape[0])):
            corner = course.corner_m[j]
            after = i + 1 >= count or commands[i + 1, AT] > corner
            if abs(corner - x) < reach and commands[i - 1, AT] < corner and after:
                if commands[i, HOLDS_FROM] == x:
                    commands[i, HOLDS_FROM] = corner
                commands[i, AT] = corner
                pinned[i] = FIXED
                break


@part
def _loosen(course, commands, first, last, found, rows, starts, cost, pinned):
    """Release what is fixed at a corner that the run does not touch, or would rather pass; returns whether any is."""
    any_ = False
    for i in range(max(first, 1), last):
        if pinned[i] == FIXED and found[i, ACTIVE] != 0.0:
            j = starts[i]
            e = np.searchsorted(course.x_m, commands[i, AT] - 1e-6)
            touches = rows.w[j] >= course.w[min(e, course.w.shape[0] - 1)] * (1.0 - 1e-5)
            gain = 0.5 * found[i, GAIN] ** 2 / found[i, CURVATURE]
            if gain > 1e3 * _NO_MORE * cost and (found[i, GAIN] < 0.0 or not touches):
                pinned[i] = 0
                any_ = True
    return any_


@part
def _lands(rows, n, first, last):
    """Where a run first meets an anchor from one row on, before another; infinite if it does not."""
    for j in range(first + 1, min(last, n - 1) + 1):
        if is_anchor(rows.regime[j]):
            return rows.x[j - 1]
    return math.inf


@part
def _touching(here, n, here_starts, there, m, there_starts, found, pinned, first, last, apart):
    """The switch of a block from which one of two runs meets an anchor that the other one passes."""
    found_last = -1
    for i in range(first, last):
        if found[i, ACTIVE] == 0.0 or pinned[i] == FIXED or there_starts[i] < 0:
            continue
        found_last = i
        after = -1
        for j in range(i + 1, last):
            if found[j, ACTIVE] != 0.0 and there_starts[j] >= 0:
                after = j
                break
        a = _lands(here, n, here_starts[i], here_starts[after] if after >= 0 else n)
        b = _lands(there, m, there_starts[i], there_starts[after] if after >= 0 else m)
        if a != b and not abs(a - b) < apart:
            return i
    return found_last


@part
def _move(commands, first, last, share, direction, trial):
    """Commands first … last − 1 moved by a share of a direction; what may hold from its own position on still does."""
    for i in range(first, last):
        trial[i, REGIME] = commands[i, REGIME]
        trial[i, AT] = commands[i, AT] + share * direction[i]
        trial[i, HOLDS_FROM] = trial[i, AT] if commands[i, HOLDS_FROM] == commands[i, AT] else commands[i, HOLDS_FROM]


@part
def _take(trial, first, last, commands):
    """Copy commands first … last − 1."""
    for i in range(first, last):
        for column in range(COMMAND_COLUMNS):
            commands[i, column] = trial[i, column]


@part
def _drive_block(
    train, course, levels, price, commands, first, last, count, regime, mode, x0, w0, stop, whole, n, rows, starts,
    found, pinned, work,
):  # fmt: skip
    """Drive and sweep one block; returns its rows, its cost beyond that of the whole run between the same places."""
    rows.x[0] = x0
    rows.w[0] = w0
    for i in range(first, last):
        starts[i] = -1
    c = max(first - 1, 0)
    while c > 0 and commands[c, AT] > x0 + 1e-9:
        c -= 1
    m, _ = simulate_from(train, course, levels, commands, c, count, regime, mode, stop, rows, starts, work.events)
    if m < 2:
        return m, math.inf
    x1 = rows.x[m - 1]
    before, _ = cost_at(train, course, price, whole, n, x0)
    after, w1 = cost_at(train, course, price, whole, n, x1)
    if abs(w1 - rows.w[m - 1]) > 1e-7 * w1:
        return -3, math.inf
    stop_c = last
    while stop_c < count and commands[stop_c, AT] < x1 - 1e-9:
        stop_c += 1
    for i in range(last, stop_c):
        if starts[i] < 0:
            return -3, math.inf
    for i in range(stop_c, count):
        starts[i] = -1
    sweep(train, course, price, commands, max(first, 1), stop_c, rows, m, starts, pinned, found, work.scratch[0],
          work.scratch[1])  # fmt: skip
    return m, rows.energy[m - 1] + price * rows.time[m - 1] - (after - before)


@part
def _descend_block(
    train, course, levels, price, commands, first, last, count, regime, mode, x0, w0, stop, whole, n, cost, work
):  # fmt: skip
    """Descend in the switches first … last − 1; returns the number of runs, and whether the block has come to rest."""
    end = course.station_m[-1]
    here = work.here
    there = work.there
    here_starts = work.here_starts
    there_starts = work.there_starts
    here_found = work.here_found
    there_found = work.there_found
    trial = work.trial
    pinned = work.pinned
    direction = work.direction
    _take(commands, 0, count, trial)
    m, base = _drive_block(
        train, course, levels, price, commands, first, last, count, regime, mode, x0, w0, stop, whole, n, here,
        here_starts, here_found, pinned, work,
    )  # fmt: skip
    runs = 1
    if m < 0:
        return runs, False
    pins = 0
    for _ in range(_MOST_STEPS):
        slope, share = _direct(commands, first, last, count, x0, end, here_found, pinned, direction)
        if -slope * min(1.0, max(share, 1e-2)) < 2.0 * _ENOUGH * cost:
            if not _loosen(course, commands, first, last, here_found, here, here_starts, cost, pinned):
                return runs, True
            continue
        lo = 0.0
        lo_cost = 0.0
        lo_slope = slope
        hi = math.inf
        hi_cost = math.inf
        hi_slope = 0.0
        turns = 0
        while True:
            _move(commands, first, last, share, direction, trial)
            m2, whole_cost = _drive_block(
                train, course, levels, price, trial, first, last, count, regime, mode, x0, w0, stop, whole, n, there,
                there_starts, there_found, pinned, work,
            )  # fmt: skip
            runs += 1
            turns += 1
            change = whole_cost - base
            at_slope = 0.0
            if m2 > 0:
                for i in range(first, last):
                    at_slope += there_found[i, SLOPE] * direction[i]
            better = m2 > 0 and change < lo_cost + 1e-14 * cost
            onward = at_slope < 0.0 and (hi == math.inf or at_slope >= _FLAT * lo_slope)
            flat = 0.0 <= at_slope <= -_FLAT * lo_slope
            if better and (onward or flat):
                _take(trial, first, last, commands)
                here, there = there, here
                here_starts, there_starts = there_starts, here_starts
                here_found, there_found = there_found, here_found
                m = m2
                base = whole_cost
                break
            if better and at_slope < 0.0:
                lo, lo_cost, lo_slope = share, change, at_slope
            else:
                hi, hi_cost, hi_slope = share, change, at_slope
            # What is left to gain lies below the tangent at the lower end.
            if -lo_slope * (hi - lo) < _NO_MORE * cost or turns > _MOST_TURNS:
                share = hi if hi_cost < lo_cost else lo
                _move(commands, first, last, hi, direction, trial)
                m2, _ = _drive_block(
                    train, course, levels, price, trial, first, last, count, regime, mode, x0, w0, stop, whole, n,
                    there, there_starts, there_found, pinned, work,
                )  # fmt: skip
                switch = -1
                if m2 > 0:
                    switch = _touching(
                        here, m, here_starts, there, m2, there_starts, here_found, pinned, first, last, _APART * end
                    )
                _move(commands, first, last, share, direction, trial)
                _take(trial, first, last, commands)
                pins += 1
                smooth = hi_cost < math.inf and hi_slope - lo_slope < _KINK * -slope * (hi - lo)
                done = switch < 0 or pinned[switch] != 0 or pins > _MOST_PINS
                if not done and not smooth:
                    pinned[switch] = PINNED
                m, base = _drive_block(
                    train, course, levels, price, commands, first, last, count, regime, mode, x0, w0, stop, whole, n,
                    here, here_starts, here_found, pinned, work,
                )  # fmt: skip
                runs += 2
                if done or m < 0:
                    return runs, turns <= _MOST_TURNS
                break
            share = _next_share(turns, lo, lo_cost, lo_slope, hi, hi_cost, hi_slope)
    return runs, False


@kernel
def descend(train, course, levels, price, commands, count, start_w, work, rounds):
    """Move the switches of a list of commands to a stationary point of E + λT that is no dearer.

    Parameters
    ----------
    train, course, levels, price
        As of `simulate` and `sweep`.
    commands : (MOST_COMMANDS, 4) float64, modified in place
        ``count`` commands.
    start_w : float
    work : Work, modified in place
        Holds the final run in ``whole``, its starts, sweep and costates.
    rounds : int
        How often to go through all blocks; in between the whole run shows which have merged or parted.

    Returns
    -------
    n : int
        Rows of the final run; negative when the first one fails.
    happened : int
        Number of its events.
    runs : int
        Of blocks.
    rests : bool
        Whether all blocks have come to rest.
    """
    whole = work.whole
    found = work.found
    starts = work.starts
    pinned = work.pinned
    if rounds > 0:
        _fix_corners(course, commands, count, _REACH * course.station_m[-1], pinned)
    runs = 0
    rests = rounds > 0
    for turn in range(rounds + 1):
        n, happened = simulate(train, course, levels, commands, count, start_w, whole, starts, work.events)
        if n < 0:
            return n, happened, runs, False
        sweep(train, course, price, commands, 1, count, whole, n, starts, pinned, found, work.p_at, work.q_at)
        if turn == rounds or (turn > 0 and rests):
            for i in range(1, count):
                commands[i, BOUND] = PINNED if pinned[i] == PINNED and found[i, ACTIVE] != 0.0 else 0
            break
        cost = abs(whole.energy[n - 1]) + price * whole.time[n - 1]
        rests = True
        first = 1
        landed = 0
        while first < count:
            while first < count and (found[first, ACTIVE] == 0.0 or pinned[first] == FIXED):
                first += 1
            if first >= count:
                break
            # The anchor from which the block leaves, back to where the run met it, and on to the next block.
            last = first + 1
            while last < count and (found[last, ACTIVE] == 0.0 or pinned[last] == FIXED or found[last, FLOW] > 0.0):
                last += 1
            stop = commands[last, AT] if last < count else course.station_m[-1]
            j = starts[first]
            while j > landed and not is_anchor(whole.regime[j]):  # left by an event, not by a command
                j -= 1
            near_m = commands[first, AT] - _NEAR * course.station_m[-1]
            while (
                j > landed and is_anchor(whole.regime[j]) and whole.x[j] > near_m
                and whole.x[j - 1] >= commands[first - 1, AT] - 1e-9
            ):  # fmt: skip
                j -= 1
            if not is_anchor(whole.regime[j + 1]):  # no anchor: from the start on
                j = 0
            mode = whole.regime[j + 1]
            moved, quiet = 0, False
            if is_anchor(mode) or j == 0:
                regime = int(commands[first - 1, REGIME]) if j > 0 else int(commands[0, REGIME])
                moved, quiet = _descend_block(
                    train, course, levels, price, commands, first, last, count, regime, mode, whole.x[j], whole.w[j],
                    stop, whole, n, cost, work,
                )  # fmt: skip
            rests &= quiet
            runs += moved
            landed = starts[last - 1] if starts[last - 1] > 0 else j
            first = last
    return n, happened, runs, rests
