"""A speed that is held while gradient and limit change beneath it is one phase, whatever the effort does meanwhile."""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.plan import AT, LASTS_S, MAY_GO, REGIME
from tgvdp.methods.phases.way import row_at
from tgvdp.physics.codes import COASTING, HOLDING

#: Speeds that differ by less than this, m/s, are one to a driver: a speedometer shows whole km/h.
_ONE_SPEED_MPS = 1.0 / 3.6


@part
def _rows_of(run, n, plan, count, first, end):
    """Rows of phases ``first`` to ``end`` − 1: the first one, and the one behind them."""
    behind = row_at(run.x, n, plan[end, AT]) if end < count else n - 1
    return row_at(run.x, n, plan[first, AT]), behind


@part
def _keeps_speed(run, first, end):
    """Whether rows ``first`` to ``end`` − 1 keep to one speed."""
    low = high = run.w[first]
    for j in range(first + 1, end + 1):
        low = min(low, run.w[j])
        high = max(high, run.w[j])
    return math.sqrt(high) - math.sqrt(low) <= _ONE_SPEED_MPS


@part
def _joins(plan, count, c, least_s):
    """Whether a phase is part of a hold beside it if it keeps its speed: one of the two is short.

    A long pull, or a long brake, is none that holds.
    """
    short = plan[c, LASTS_S] < least_s
    coasts = plan[c, REGIME] == COASTING
    for beside in (c - 1, c + 1):
        holds = 0 <= beside < count and plan[beside, REGIME] == HOLDING and plan[beside, MAY_GO] > 0.0
        if holds and (short or (coasts and plan[beside, LASTS_S] < least_s)):
            return True
    return False


@kernel
def join_holds(run, n, plan, count, least_s):
    """Make what keeps the speed beside a hold part of it, where one of the two is short, or between two of them.

    On a line that was surveyed finely a hold pulls, coasts and brakes by turns, a second each: to a driver, and to a
    regulator, that is one command. Not without current, where nothing is held.

    Parameters
    ----------
    run : Run, modified in place
        Of ``n`` rows.
    plan : (count, PLAN_COLUMNS) float64
        Of its phases.
    least_s : float
        Phases that are shorter, s, are short.

    Returns
    -------
    bool
        Whether any phase is part of another now.
    """
    joined = False
    before = -1  # the last hold; −1 for none
    is_short = False  # it, or one of the phases since
    for c in range(count):
        short = plan[c, LASTS_S] < least_s
        if plan[c, MAY_GO] == 0.0:
            before = -1
        elif plan[c, REGIME] == HOLDING:
            if before >= 0 and (is_short or short):
                first, end = _rows_of(run, n, plan, count, before + 1, c)
                if _keeps_speed(run, first, end):
                    run.regime[first:end] = HOLDING
                    joined = True
            before = c
            is_short = short
        else:
            is_short = is_short or short
            if _joins(plan, count, c, least_s):
                first, end = _rows_of(run, n, plan, count, c, c + 1)
                if _keeps_speed(run, first, end):
                    run.regime[first:end] = HOLDING
                    joined = True
    return joined
