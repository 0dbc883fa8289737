"""Newton's steps: in the switches of a list of commands at a multiplier, and with it to a running time.

One sweep yields how all switches answer to their costs and to a change of the multiplier, and the running time to them:
Newton's step, bordered by the running time where that is given. What is pinned answers to where its run touches the
envelope instead. From one point of a front to the next two or three runs do.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.blocks import compare_blocks, refuse, refuse_all, remember
from tgvdp.methods.extremal.command import BOUND, TOUCH, copy_commands
from tgvdp.methods.extremal.course import held_speeds
from tgvdp.methods.extremal.pins import fix_corners, is_short, pin, release, touches
from tgvdp.methods.extremal.simulate import simulate
from tgvdp.methods.extremal.step import apply_step, drop_vanishing, newton_step, without_superseded
from tgvdp.methods.extremal.sweep import sweep
from tgvdp.methods.extremal.switches import ACTIVE, CURVATURE, FIXED, FROZEN, PINNED

#: What a step may still promise of E + λT where the run is an extremal.
_ENOUGH = 1e-10
#: Largest step of the multiplier, as a share.
_MOST_CHANGE = 0.4
#: After so many runs at a multiplier each block takes its own step.
_TOGETHER = 9
#: Shares of the distance within which traction begins at a corner, along a front and when commands are new.
_AT_CORNER = 1e-6
_NEAR_CORNER = 4e-3


@part
def _begin(course, commands, count, timed, work):
    """Make commands ready; returns their number. What was frozen may move again where the multiplier stays."""
    count = without_superseded(commands, count)
    for i in range(count):
        bound = int(commands[i, BOUND])
        work.pinned[i] = 0 if bound == FROZEN and not timed else bound
        work.touch[i] = commands[i, TOUCH] if bound == PINNED else -1.0
    if timed:
        fix_corners(course, commands, count, _AT_CORNER * course.x_m[-1], work.pinned)
    return count


@part
def _forget(count, work):
    """Forget what is pinned: commands were dropped."""
    for i in range(count):
        work.pinned[i] = work.pinned[i] if work.pinned[i] >= FIXED else 0
        work.touch[i] = -1.0
        work.gain[i] = 0.0
        work.shrink[i] = 1.0


@part
def _look(train, course, levels, commands, count, start_w, price, turn, work):
    """Drive and sweep commands, pin what touches the envelope, and find Newton's step.

    Returns
    -------
    n, happened : int
        As of `simulate`.
    fresh, lost, touching : bool
        As of `pin`.
    change, per_price, promise : float
        As of `newton_step`.
    """
    held_speeds(train, course.air, course.returned, price, levels)
    n, happened = simulate(train, course, levels, commands, count, start_w, work.whole, work)
    if n < 0:
        return n, 0, False, False, False, 0.0, 0.0, 0.0
    by_multiplier = sweep(train, course, price, count, work.whole, n, work)
    fresh, lost, touching = pin(train, course, count, work.whole, n, work, turn)
    change, per_price, promise = newton_step(count, work, by_multiplier)
    return n, happened, fresh, lost, touching, change, per_price, promise


@part
def _let_go(train, course, commands, count, n, little, work):
    """Release pins that hold no more, and step accordingly; returns whether there are any."""
    if not release(train, course, count, work.whole, n, work, little):
        return False
    newton_step(count, work, 0.0)
    for i in range(count):
        if work.push[i] > 0.0:
            work.step[i] = work.push[i]
    apply_step(commands, count, work, work.step, work.rate, 0.0, course.station_m[-1])
    copy_commands(work.trial, count, commands)
    return True


@part
def _moves(course, i, work, little):
    """Whether a switch has not come to rest."""
    row = work.found[i]
    if row[ACTIVE] == 0.0 or work.pinned[i] == FIXED:
        return False
    if work.shrink[i] == 0.0 or work.pinned[i] == FROZEN:
        return True
    if work.pinned[i] == PINNED:
        return not touches(course, work, i)
    return 0.5 * row[CURVATURE] * work.step[i] * work.step[i] > little


@part
def _bind(course, commands, count, work, little):
    """Say in the commands what is pinned, and freeze what has not come to rest; returns whether all has."""
    rests = True
    for i in range(count):
        moves = _moves(course, i, work, little)
        rests &= not moves and (work.found[i, ACTIVE] >= 0.0 or work.pinned[i] == PINNED)  # else a saddle of the cost
        active = work.found[i, ACTIVE] != 0.0
        commands[i, BOUND] = FROZEN if moves else work.pinned[i] if active and work.pinned[i] == PINNED else 0
        commands[i, TOUCH] = work.touch[i]
    return rests


@part
def _retry(commands, count, best_count, dropped, fresh, lost, better, work, end):
    """Commands to be tried where some blocks, or all, became dearer; returns their number."""
    if dropped or lost or better < 0:
        count = best_count
        copy_commands(work.best, count, commands)
        if dropped:  # at a loss: they stay
            _forget(count, work)
            return count
        refuse_all(count, work)
    refuse(commands, count, work, not (fresh or lost))
    if better > 0 or fresh or lost:
        return count
    for i in range(count):
        work.step[i] = work.shrink[i] * work.best_step[i]
        work.rate[i] = 0.0
    apply_step(commands, count, work, work.step, work.rate, 0.0, end)
    copy_commands(work.trial, count, commands)
    return count


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
    commands : (MOST_COMMANDS, COMMAND_COLUMNS) float64, modified in place
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
    best_n = 0
    may_drop = True
    dropped = False
    mixed = False
    for i in range(count):
        work.shrink[i] = 1.0
    if most_runs > 1:
        count = _begin(course, commands, count, timed, work)
    for turn in range(most_runs):
        n, happened, fresh, lost, touching, change, per_price, promise = _look(
            train, course, levels, commands, count, start_w, price, turn, work
        )
        if n < 0 and (timed or best_cost == math.inf):
            return n, 0, count, price, price, turn + 1, False
        if not timed and n > 0 and best_cost < math.inf and is_short(course, work.whole, n):
            n = 0
        time_s = work.whole.time[n - 1] if n > 0 else math.inf
        cost = work.whole.energy[n - 1] + price * time_s if n > 0 else math.inf
        little = _ENOUGH * (abs(work.whole.energy[n - 1]) + price * time_s) if n > 0 else 0.0
        if not timed:
            if n > 0 and (turn + 1 == most_runs or (turn + 2 == most_runs and cost <= best_cost + little)):
                return n, happened, count, price, price, turn + 1, _bind(course, commands, count, work, little)
            if best_cost < math.inf:
                better, worse = -1, int(cost > best_cost + little)
                if n > 0 and (mixed or turn >= _TOGETHER) and not lost and count == best_count:
                    better, worse = compare_blocks(train, course, price, commands, count, n, best_n, little, work)
                lost |= turn + 2 == most_runs
                if worse > 0 or lost:
                    may_drop &= not dropped
                    mixed = better > 0 and not dropped
                    count = _retry(commands, count, best_count, dropped, fresh, lost, better, work, end)
                    dropped = False
                    continue
                if not mixed:
                    for i in range(count):
                        work.shrink[i] = 1.0
                mixed = False
        dropped = False
        most = _MOST_CHANGE * price
        if touching and promise < little and (not timed or abs(time_s - target_s) <= tolerance_s):
            if _let_go(train, course, commands, count, n, little, work):
                continue
            rests = _bind(course, commands, count, work, little)
            if not timed:
                return n, happened, count, price, price, turn + 1, rests
            for i in range(count):
                work.step[i] = 0.0
            dprice = min(max((next_s - time_s) / per_price, -most), most)
            apply_step(commands, count, work, work.step, work.rate, dprice, end)
            return n, happened, count, price, price + dprice, turn + 1, True
        dprice = 0.0
        if timed:
            if not abs(per_price) > 0.0:
                break
            dprice = min(max((target_s - time_s - change) / per_price, -most), most)
        else:
            remember(work.whole, n, work.kept)
            best_n = n
        copy_commands(commands, count, work.best)
        for i in range(count):
            work.best_step[i] = work.step[i]
            work.step[i] *= work.shrink[i]
        best_count = count
        best_cost = min(cost, best_cost)
        if turn == 0 and not timed:
            fix_corners(course, commands, count, _NEAR_CORNER * end, work.pinned)
            continue
        fewer = drop_vanishing(commands, count, work, dprice, short_s) if may_drop else count
        if fewer < count:
            count = fewer
            _forget(count, work)
            dropped = True
            continue
        apply_step(commands, count, work, work.step, work.rate, dprice, end)
        copy_commands(work.trial, count, commands)
        price += dprice
    return 0, 0, count, price, price, most_runs, False
