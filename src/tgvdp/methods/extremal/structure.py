"""Changes of structure: phases that the costate asks for, phases too short to drive, and the best of two runs.

All at one multiplier, where stretches between two places at which runs coincide can be compared one by one.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.extremal.blocks import cost_at
from tgvdp.methods.extremal.command import AT, HOLDS_FROM, REGIME, copy_command, write_command
from tgvdp.methods.extremal.rows import ENVELOPE, is_anchor
from tgvdp.physics.codes import COASTING, DYNAMIC, HOLDING, TRACTION

#: Two runs coincide where their w differ by a smaller share.
_SAME_W = 1e-7


@part
def _at(rows, j, x):
    """Squared speed of the row that ends at j, at a position."""
    d = rows.x[j] - rows.x[j - 1]
    return rows.w[j - 1] + (rows.w[j] - rows.w[j - 1]) * (x - rows.x[j - 1]) / d


@part
def _part_of(commands, count, from_m, until_m, regime, asserted, out, size):
    """Append the commands of a stretch, and before them the regime in force there if it is another."""
    last = 0
    for i in range(count):
        if commands[i, AT] < from_m:
            last = i
    if from_m > 0.0 and commands[last, REGIME] != regime and asserted and size > 0:
        if size >= out.shape[0]:
            return size
        size = copy_command(commands, last, out, size)
        out[size - 1, AT] = from_m
        out[size - 1, HOLDS_FROM] = max(out[size - 1, HOLDS_FROM], from_m)
    for i in range(count):
        if from_m <= commands[i, AT] < until_m and size < out.shape[0]:
            size = copy_command(commands, i, out, size)
    return size


@kernel
def cross(train, course, price, a, n, first, first_count, b, m, second, second_count, bias, out):
    """The cheaper of two runs on each stretch on which they differ, as commands.

    Parameters
    ----------
    a, b : Rows
        Of ``n`` and ``m`` rows; ``first`` and ``second`` are their commands.
    bias : float
        The second is taken where it is dearer by no more than this.
    out : (size, COMMAND_COLUMNS) float64, modified in place

    Returns
    -------
    count : int
        Number of commands in ``out``.
    taken : int
        On how many stretches the second is taken; negative of all stretches if on all of them.
    """
    i = 1
    j = 1
    x = 0.0
    from_m = 0.0
    until_m = 0.0
    started = -1.0
    same_since = 0.0
    size = 0
    taken = 0
    stretches = 0
    second_wins = False
    regime = first[0, REGIME]
    end = course.station_m[-1]
    while True:
        # On to the next end of a row of either.
        x = min(a.x[i], b.x[j])
        same = abs(_at(a, i, x) - _at(b, j, x)) <= _SAME_W * (_at(a, i, x) + 1e-9)
        at_end = x >= end - 1e-9
        if not same and started < 0.0:
            started = max(a.x[i - 1], b.x[j - 1])
            if stretches > 0:  # the last stretch ends halfway between the two
                until_m = 0.5 * (same_since + started)
                on_envelope = a.regime[i] == ENVELOPE
                which = second if second_wins else first
                size = _part_of(which, second_count if second_wins else first_count, from_m, until_m, regime,
                                on_envelope, out, size)  # fmt: skip
                regime = out[size - 1, REGIME] if size > 0 else regime
                from_m = until_m
            stretches += 1
        if started >= 0.0 and (same or at_end):
            here, _ = cost_at(train, course, price, a, n, x)
            here0, _ = cost_at(train, course, price, a, n, started)
            there, _ = cost_at(train, course, price, b, m, x)
            there0, _ = cost_at(train, course, price, b, m, started)
            second_wins = (there - there0) - (here - here0) < bias
            if second_wins:
                taken += 1
            started = -1.0
            same_since = x
        if at_end:
            break
        if a.x[i] <= x + 1e-9:
            i += 1
        if b.x[j] <= x + 1e-9:
            j += 1
        if i >= n or j >= m:
            break
    which = second if second_wins else first
    size = _part_of(which, second_count if second_wins else first_count, from_m, math.inf, regime, True, out, size)
    return size, (-stretches if taken == stretches else taken)


@kernel
def amend(course, commands, count, rows, n, starts, p_at, least_s, margin, share, out):
    """Commands with a phase more wherever the costate contradicts the regime for a while.

    Parameters
    ----------
    commands, count, rows, n, starts, p_at
        A run, and its costate.
    least_s : float
        Contradictions that last no longer, s, do not count.
    margin : float
        By how much p must lie beyond its level.
    share : float
        How much of the contradiction the new phase takes, around its middle.
    out : (size, COMMAND_COLUMNS) float64, modified in place

    Returns
    -------
    count : int
    added : int
    """
    size = 0
    c = 0
    added = 0
    j = 1
    retard = -0.5 * course.returned
    size = copy_command(commands, 0, out, 0)
    c = 1
    while j < n:
        while c < count and commands[c, AT] <= rows.x[j - 1] + 1e-9:
            if size >= out.shape[0] - 3:
                return size, added
            size = copy_command(commands, c, out, size)
            c += 1
        wanted = -1
        regime = rows.regime[j]
        if not is_anchor(regime):
            p = 0.5 * (p_at[j] + p_at[j - 1])
            if p != p:
                p = p_at[j]
            if p == p:
                if regime != TRACTION and p < -0.5 - margin:
                    wanted = TRACTION
                elif regime != COASTING and -0.5 + margin < p < retard - margin:
                    wanted = COASTING
                elif regime != DYNAMIC and course.returned > 0.0 and p > retard + margin:
                    wanted = DYNAMIC
        if wanted < 0:
            j += 1
            continue
        first = j
        while j < n and rows.regime[j] == regime and not (c < count and commands[c, AT] <= rows.x[j - 1] + 1e-9):
            p = p_at[j]
            if wanted == TRACTION:
                stays = p < -0.5 - 0.5 * margin
            elif wanted == COASTING:
                stays = -0.5 + 0.5 * margin < p < retard - 0.5 * margin
            else:
                stays = p > retard + 0.5 * margin
            if not stays and j > first:
                break
            j += 1
        if rows.time[j - 1] - rows.time[first - 1] > least_s:
            xa = rows.x[first - 1]
            xb = rows.x[j - 1]
            trim = 0.5 * (1.0 - share) * (xb - xa)
            holds_from = out[size - 1, HOLDS_FROM]
            size = write_command(out, size, wanted, xa + trim, xa + trim)
            size = write_command(out, size, regime, xb - trim, max(xb - trim, holds_from))
            added += 1
    while c < count and size < out.shape[0]:
        size = copy_command(commands, c, out, size)
        c += 1
    return size, added


@kernel
def coast_before_brakes(course, price, commands, count, rows, n, starts, least_s, out):
    """Commands with coasting before each braking of the envelope that a run meets under traction.

    As long as p takes from −1/2 to 0 there; and traction where the braking ends. Not before a hold by the brakes that
    lasts no longer than ``least_s``.

    Returns
    -------
    count : int
    added : int
    """
    size = 0
    added = 0
    c = 0
    j = 1
    while j < n:
        while c < count and (starts[c] < 0 or starts[c] <= j - 1):
            if size >= out.shape[0] - 3:
                return size, added
            size = copy_command(commands, c, out, size)
            c += 1
        regime = int(out[size - 1, REGIME])
        braking = rows.regime[j] == ENVELOPE and rows.effort[j] < 0.0
        begins = braking and j > 1 and (regime == TRACTION or rows.regime[j - 1] == HOLDING)
        begins = begins and not (rows.regime[j - 1] == ENVELOPE and rows.effort[j - 1] < 0.0)
        if not begins:
            j += 1
            continue
        x = rows.x[j - 1]
        w = rows.w[j - 1]
        while j < n and rows.regime[j] == ENVELOPE and rows.effort[j] < 0.0:
            j += 1
        if rows.w[j - 1] > 0.98 * w and rows.time[j - 1] < least_s + rows.time[j - 2]:
            continue
        back = w * math.sqrt(w) / price
        at = max(x - back, 0.5 * (out[size - 1, AT] + x))
        holds_from = out[size - 1, HOLDS_FROM]
        size = write_command(out, size, COASTING, at, math.inf)
        added += 1
        if j < n and (c >= count or starts[c] < 0 or starts[c] > j - 1):
            size = write_command(out, size, TRACTION, rows.x[j - 1], max(rows.x[j - 1], holds_from))
    while c < count and size < out.shape[0]:
        size = copy_command(commands, c, out, size)
        c += 1
    return size, added


@kernel
def shorten(commands, count, rows, n, starts, short_s, out):
    """Commands without those of phases that are shorter than ``short_s``; returns their number.

    A phase begins where a command sets another regime, and ends where the run next meets an anchor or a command.
    """
    size = copy_command(commands, 0, out, 0)
    from_row = -1  # where the phases began that were dropped last
    for i in range(1, count):
        j = starts[i]
        drop = False
        if j >= 0 and j + 1 < n and not is_anchor(rows.regime[j + 1]):
            last = j + 1
            while (
                last + 1 < n
                and rows.regime[last + 1] == rows.regime[j + 1]
                and (i + 1 >= count or starts[i + 1] < 0 or last < starts[i + 1])
            ):
                last += 1
            drop = rows.time[last] - rows.time[j] < short_s
        if j < 0:
            drop = True
        if drop:
            from_row = j if from_row < 0 else from_row
            continue
        before = rows.regime[from_row if from_row >= 0 else j]
        from_row = -1
        if commands[i, REGIME] == out[size - 1, REGIME] and not is_anchor(before):
            continue
        size = copy_command(commands, i, out, size)
    return size
