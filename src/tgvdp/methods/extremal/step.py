"""Newton's step in the switches of a list of commands, and the commands after it."""

from tgvdp._jit import part
from tgvdp.methods.extremal.command import AT, BOUND, HOLDS_FROM, REGIME, TOUCH, copy_command
from tgvdp.methods.extremal.rows import is_anchor
from tgvdp.methods.extremal.switches import (
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
)

#: Largest step of a switch, as a share of the distance.
_LONGEST = 0.03
#: Share of the room between two switches that their steps may take.
_OF_ROOM = 0.9
_NOWHERE_M = 1e-6


@part
def newton_step(count, work, by_multiplier):
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
        if row[ACTIVE] == 0.0 or pinned[i] >= FIXED:
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
            if work.shrink[i] > 0.0:
                promise += 0.5 * row[CURVATURE] * step[i] * step[i]
        change += row[OF_TIME] * step[i]
        per_price += row[OF_TIME] * rate[i]
        before = i
    return change, per_price, promise


@part
def apply_step(commands, count, work, step, rate, dprice, end):
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
        trial[i, TOUCH] = commands[i, TOUCH]


@part
def without_superseded(commands, count):
    """Leave out commands that are superseded where they begin; returns the number of the others."""
    size = 1
    for i in range(1, count):
        if i + 1 < count and commands[i + 1, AT] <= commands[i, AT] + _NOWHERE_M:
            continue
        size = copy_command(commands, i, commands, size)
    return size


@part
def drop_vanishing(commands, count, work, dprice, short_s):
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
