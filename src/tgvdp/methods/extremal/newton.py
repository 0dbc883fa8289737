"""Newton's steps: in the switches of a list of commands at a multiplier, and with it to a running time.

One sweep yields how all switches answer to their costs and to a change of the multiplier, and the running time to them:
Newton's step, bordered by the running time where that is given. What is pinned answers to where its run touches the
envelope instead. From one point of a front to the next two or three runs do.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.command import AT, BOUND, HOLDS_FROM, REGIME, copy_command, copy_commands
from tgvdp.methods.extremal.course import held_speeds
from tgvdp.methods.extremal.pins import fix_corners, pin, release
from tgvdp.methods.extremal.simulate import is_anchor, simulate
from tgvdp.methods.extremal.sweep import (
    ACTIVE,
    BY_MULTIPLIER,
    CROSS,
    CURVATURE,
    FIXED,
    FLOW,
    GAIN,
    HELD_W,
    JUMP,
    OF_TIME,
    PINNED,
    sweep,
)

#: What a step may still promise of E + λT where the run is an extremal.
_ENOUGH = 1e-10
#: Largest step of the multiplier, as a share; and of a switch, as a share of the distance.
_MOST_CHANGE = 0.4
_LONGEST = 0.03
#: Share of the room between two switches that their steps may take.
_OF_ROOM = 0.9
_NOWHERE_M = 1e-6
#: Shares of the distance within which traction begins at a corner, along a front and when commands are new.
_AT_CORNER = 1e-6
_NEAR_CORNER = 4e-3
#: Where a step at a multiplier raises the cost, so much of it is tried next, down to so much of it.
_SHRINK = 0.25
_LEAST_STEP = 2e-3


@part
def _solve(count, work, by_multiplier):
    """Newton's step of all switches, and its derivative by the multiplier.

    Returns what the step changes of the running time, dT/dλ, and what it promises of E + λT.
    """
    found = work.found
    pinned = work.pinned
    step = work.step
    rate = work.rate
    change = 0.0
    per_price = by_multiplier
    promise = 0.0
    dw = 0.0
    dw_price = 0.0
    before = -1
    for i in range(count):
        step[i] = 0.0
        rate[i] = 0.0
        row = found[i]
        if row[ACTIVE] == 0.0 or pinned[i] == FIXED:
            continue
        if before >= 0 and row[FLOW] > 0.0:
            dw = row[FLOW] * (dw + 2.0 * found[before, JUMP] * step[before])
            dw_price = row[FLOW] * (dw_price + 2.0 * found[before, JUMP] * rate[before])
        else:
            dw = 0.0
            dw_price = row[HELD_W]
        if pinned[i] == PINNED:
            step[i] = (work.miss[i] / work.flow_on[i] - dw) / (2.0 * row[JUMP])
            rate[i] = -dw_price / (2.0 * row[JUMP])
        else:
            step[i] = -(row[GAIN] + row[CROSS] * dw) / row[CURVATURE]
            rate[i] = -(row[BY_MULTIPLIER] + row[CROSS] * dw_price) / row[CURVATURE]
            promise += 0.5 * row[CURVATURE] * step[i] * step[i]
        change += row[OF_TIME] * step[i]
        per_price += row[OF_TIME] * rate[i]
        before = i
    return change, per_price, promise


@part
def _apply(commands, count, work, step, rate, dprice, end):
    """Commands after a step, in ``work.trial``; where two come closer than there is room for, both take less of it.

    Those that change nothing are in nobody's way.
    """
    share = work.share
    trial = work.trial
    last = 0
    for i in range(count):
        trial[i, AT] = step[i] + rate[i] * dprice
        share[i] = min(1.0, _LONGEST * end / max(abs(trial[i, AT]), 1e-300))
    for i in range(1, count):
        if work.found[i, ACTIVE] == 0.0:
            continue
        closer = trial[last, AT] - trial[i, AT]
        room = commands[i, AT] - commands[last, AT]
        if closer > _OF_ROOM * room:
            share[last] = min(share[last], _OF_ROOM * room / closer)
            share[i] = min(share[i], _OF_ROOM * room / closer)
        last = i
    for i in range(count):
        trial[i, AT] = commands[i, AT] + share[i] * trial[i, AT]
    for i in range(count - 1, 1, -1):
        if work.found[i - 1, ACTIVE] == 0.0:
            trial[i - 1, AT] = min(trial[i - 1, AT], trial[i, AT])
    for i in range(count):
        if i > 0:
            trial[i, AT] = max(trial[i, AT], trial[i - 1, AT])
        holds = commands[i, HOLDS_FROM] == commands[i, AT]
        trial[i, HOLDS_FROM] = trial[i, AT] if holds else commands[i, HOLDS_FROM]
        trial[i, REGIME] = commands[i, REGIME]
        trial[i, BOUND] = commands[i, BOUND]


@part
def _tidy(commands, count):
    """Leave out commands that are superseded where they begin; returns the number of the others."""
    size = 1
    for i in range(1, count):
        if i + 1 < count and commands[i + 1, AT] <= commands[i, AT] + _NOWHERE_M:
            continue
        size = copy_command(commands, i, commands, size)
    return size


@part
def _drop_vanishing(commands, count, work, dprice, short_s):
    """Drop phases that a step would end before they begin, if they are short; returns the number of commands."""
    found = work.found
    step = work.step
    rate = work.rate
    rows = work.whole
    starts = work.starts
    size = 0
    for i in range(count):
        if size >= 2 and found[i, ACTIVE] != 0.0 and found[i - 1, ACTIVE] != 0.0:
            closer = step[i - 1] - step[i] + (rate[i - 1] - rate[i]) * dprice
            room = commands[i, AT] - commands[i - 1, AT]
            short = rows.time[starts[i]] - rows.time[starts[i - 1]] < short_s
            if closer > _OF_ROOM * room and short and commands[size - 2, REGIME] == commands[i, REGIME]:
                size -= 1
                if not is_anchor(rows.regime[starts[i - 1]]):  # else what leaves the hold
                    commands[size - 1, HOLDS_FROM] = max(commands[size - 1, HOLDS_FROM], commands[i, HOLDS_FROM])
                    continue
        size = copy_command(commands, i, commands, size)
    return size


@part
def _begin(course, commands, count, reach, work):
    """Make commands ready; returns their number."""
    count = _tidy(commands, count)
    fix_corners(course, commands, count, reach * course.x_m[-1], work.pinned)
    for i in range(count):
        work.touch[i] = -1.0
    return count


@part
def _forget(count, work):
    """Forget what is pinned: commands were dropped."""
    for i in range(count):
        work.pinned[i] = FIXED if work.pinned[i] == FIXED else 0
        work.touch[i] = -1.0
        work.gain[i] = 0.0


@part
def _look(train, course, levels, commands, count, start_w, price, turn, work):
    """Drive and sweep commands, pin what touches the envelope, and find Newton's step.

    Returns
    -------
    n, happened : int
        As of `simulate`.
    fresh, lost, touches : bool
        As of `pin`.
    change, per_price, promise : float
        As of `_solve`.
    """
    held_speeds(train, course.air, course.returned, price, levels)
    n, happened = simulate(train, course, levels, commands, count, start_w, work.whole, work.starts, work.events)
    if n < 0:
        return n, 0, False, False, False, 0.0, 0.0, 0.0
    by_multiplier = sweep(
        train, course, price, count, work.whole, n, work.starts, work.pinned, work.found, work.p_at,
        work.stepped_at,
    )  # fmt: skip
    fresh, lost, touches = pin(train, course, count, work.whole, n, work, turn)
    change, per_price, promise = _solve(count, work, by_multiplier)
    return n, happened, fresh, lost, touches, change, per_price, promise


@part
def _let_go(train, course, commands, count, n, little, work):
    """Release pins that hold no more, and step accordingly; returns whether there are any."""
    if not release(train, course, count, work.whole, n, work, little):
        return False
    _solve(count, work, 0.0)
    for i in range(count):
        if work.push[i] > 0.0:
            work.step[i] = work.push[i]
    _apply(commands, count, work, work.step, work.rate, 0.0, course.station_m[-1])
    copy_commands(work.trial, count, commands)
    return True


@part
def _bind(commands, count, work):
    """Say in the commands what is pinned; returns whether the run is at a saddle of the cost."""
    saddle = False
    for i in range(count):
        active = work.found[i, ACTIVE] != 0.0
        saddle |= work.found[i, ACTIVE] < 0.0 and work.pinned[i] == 0
        commands[i, BOUND] = PINNED if active and work.pinned[i] == PINNED else 0
    return saddle


@kernel
def newton(
    train, course, levels, commands, count, start_w, price, target_s, next_s, tolerance_s, short_s, most_runs, work
):
    """Move commands until their run is an extremal of a running time, or at a multiplier.

    To a running time the multiplier moves, too; at a multiplier E + λT falls with each step that is kept.

    Parameters
    ----------
    train, course, levels
        As of `simulate`.
    commands : (MOST_COMMANDS, 4) float64, modified in place
        ``count`` commands; those of the run that was found.
    price : float
        λ per unit of inertia, or a first guess.
    target_s, next_s : float
        Running time, and the one that is looked for next; infinite to keep the multiplier.
    tolerance_s : float
    short_s : float
        Phases shorter than this, s, are dropped where a step would make them vanish.
    most_runs : int
        1 to drive and sweep the commands as they are.
    work : Work, modified in place
        Holds the run in ``whole``; ``trial`` the commands foreseen for the next running time.

    Returns
    -------
    n : int
        Rows of the run; not positive where there is none.
    happened, count : int
        Number of its events, and of its commands.
    price, next_price : float
        Its multiplier, and the one foreseen for the next running time.
    runs : int
    rests : bool
        Whether it is an extremal.
    """
    end = course.station_m[-1]
    timed = target_s < math.inf
    best_cost = math.inf
    best_count = count
    shrink = 1.0
    may_drop = True
    dropped = False
    if most_runs > 1:
        count = _begin(course, commands, count, _AT_CORNER if timed else _NEAR_CORNER, work)
    for turn in range(most_runs):
        n, happened, fresh, lost, touches, change, per_price, promise = _look(
            train, course, levels, commands, count, start_w, price, turn, work
        )
        if n < 0 and (timed or best_cost == math.inf):
            return n, 0, count, price, price, turn + 1, False
        time_s = work.whole.time[n - 1] if n > 0 else math.inf
        cost = work.whole.energy[n - 1] + price * time_s if n > 0 else math.inf
        little = _ENOUGH * (abs(work.whole.energy[n - 1]) + price * time_s) if n > 0 else 0.0
        if turn + 2 >= most_runs and not timed and cost <= best_cost + little:
            return n, happened, count, price, price, turn + 1, False
        if best_cost < math.inf and (lost or (not timed and cost > best_cost + little)):
            count = best_count
            copy_commands(work.best, count, commands)
            if dropped:  # at a loss: they stay
                dropped = False
                may_drop = False
                _forget(count, work)
            elif not (fresh or lost):
                shrink = shrink * _SHRINK if shrink > _LEAST_STEP and turn + 2 < most_runs else 0.0
                for i in range(count):
                    work.step[i] = shrink * work.best_step[i]
                    work.rate[i] = 0.0
                _apply(commands, count, work, work.step, work.rate, 0.0, end)
                copy_commands(work.trial, count, commands)
            continue
        dropped = False
        most = _MOST_CHANGE * price
        if touches and promise < little and (not timed or abs(time_s - target_s) <= tolerance_s):
            if _let_go(train, course, commands, count, n, little, work):
                continue
            saddle = _bind(commands, count, work)
            if not timed or saddle:
                return 0 if timed else n, happened, count, price, price, turn + 1, not saddle
            for i in range(count):
                work.step[i] = 0.0
            dprice = min(max((next_s - time_s) / per_price, -most), most)
            _apply(commands, count, work, work.step, work.rate, dprice, end)
            return n, happened, count, price, price + dprice, turn + 1, True
        if shrink == 0.0:
            return n, happened, count, price, price, turn + 1, False
        dprice = 0.0
        if timed:
            if not abs(per_price) > 0.0:
                break
            dprice = min(max((target_s - time_s - change) / per_price, -most), most)
        copy_commands(commands, count, work.best)
        for i in range(count):
            work.best_step[i] = work.step[i]
        best_count = count
        best_cost = min(cost, best_cost)
        shrink = 1.0
        fewer = _drop_vanishing(commands, count, work, dprice, short_s) if may_drop else count
        if fewer < count:
            count = fewer
            _forget(count, work)
            dropped = True
            continue
        _apply(commands, count, work, work.step, work.rate, dprice, end)
        copy_commands(work.trial, count, commands)
        price += dprice
    return 0, 0, count, price, price, most_runs, False
