"""A run without phases that are too short to drive, at the same running time."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.plan import (
    AT,
    BALANCED,
    LASTS_S,
    MAY_GO,
    PLAN_COLUMNS,
    REGIME,
    leave_out,
    plan_of,
    shortest,
)
from tgvdp.methods.phases.regimes import tell_regimes, without_touches
from tgvdp.methods.phases.track import track
from tgvdp.methods.phases.way import Run, Way, measure
from tgvdp.methods.phases.widen import widen
from tgvdp.physics.codes import COASTING, HOLDING, TRACTION

_Floats = NDArray[np.float64]

#: What is left out in turn: phases shorter than a share of the least duration, and how much of each its neighbour
#: before it takes. First what is next to nothing, so that it does not stand or fall with longer phases beside it.
_PASSES = ((0.05, BALANCED), (1.0, BALANCED), (1.0, 0.0), (1.0, 1.0))
#: Tries to give a run its time back, and the share of a phase of coasting by which the first one moves its start.
_TRIES = 6
_FIRST_STEP = 1e-3
_MOST_PHASES = 4000
#: Rows that a run may gain.
_MORE_ROWS = 20_000


class Pruned(NamedTuple):
    """A run without short phases.

    Attributes
    ----------
    time_s, energy_j : float
        By how much it takes longer, and costs more.
    x_m, w : (n,) float64
    regime : (n − 1,) int8
        As of `physics.codes`.
    short : int
        Phases that are too short and had to stay.
    """

    time_s: float
    energy_j: float
    x_m: _Floats
    w: _Floats
    regime: NDArray[np.int8]
    short: int


@part
def _start_of_coasting(plan, count):
    """The longest phase of coasting that follows traction or a hold; −1 if there is none."""
    best = -1
    for c in range(1, count - 1):
        follows = plan[c - 1, REGIME] == TRACTION or plan[c - 1, REGIME] == HOLDING
        if follows and plan[c, REGIME] == COASTING and (best < 0 or plan[c, LASTS_S] > plan[best, LASTS_S]):
            best = c
    return best


@part
def _retime(way, run, n, plan, price, most_j, late_s, tolerance_s, out):
    """Move the start of the longest coasting until the run is no longer late, or early; returns rows, −1 in vain."""
    count = plan_of(way, run, n, plan)
    c = _start_of_coasting(plan, count)
    if c < 0:
        return -1
    start_m = plan[c, AT]
    before_s = measure(way, run, 0, n - 1)[0]
    step_m = _FIRST_STEP * (plan[c + 1, AT] - start_m)
    room_m = start_m - plan[c - 1, AT]
    last_m = 0.0
    last_s = late_s
    shift_m = min(step_m if late_s > 0.0 else -step_m, 0.5 * room_m)
    for _ in range(_TRIES):
        if not -0.9 * room_m < shift_m < 0.9 * (plan[c + 1, AT] - start_m):
            return -1
        plan[c, AT] = start_m + shift_m
        m, refused, cost_j = track(way, run, n, plan, count, price, math.inf, out)
        if m < 0 or refused > 0:
            return -1
        now_s = late_s + measure(way, out, 0, m - 1)[0] - before_s
        if abs(now_s) <= tolerance_s:
            return m if cost_j <= most_j else -1
        if now_s == last_s:
            return -1
        next_m = shift_m - now_s * (shift_m - last_m) / (now_s - last_s)
        last_m = shift_m
        last_s = now_s
        shift_m = next_m
    return -1


@part
def _short(plan, count, least_s):
    """Phases of a plan that are shorter than ``least_s`` although they might be left out."""
    short = 0
    for c in range(count - 1):
        if plan[c, LASTS_S] < least_s and plan[c, MAY_GO] > 0.0:
            short += 1
    return short


@kernel
def _prune(way, here, there, n, plan, price, least_s, most, most_j, later_s, slack_s):
    """Leave phases shorter than the share ``most`` of ``least_s`` out of the run in ``here``.

    Returns
    -------
    n : int
        Rows; −1 where the run must stay as it is.
    swapped : bool
        Whether they are in ``there``.
    time, energy : float
    short : int
    """
    tell_regimes(way, here, n)
    count = plan_of(way, here, n, plan)
    if count < 0 or most == 0.0 or shortest(plan, count, least_s) < 0:
        return n, False, 0.0, 0.0, _short(plan, count, least_s)
    before_s, before_j = measure(way, here, 0, n - 1)
    swapped = False
    for p in range(len(_PASSES)):
        n = without_touches(way, here, n)
        count = plan_of(way, here, n, plan)
        planned = leave_out(way, plan, count, min(_PASSES[p][0], most) * least_s, _PASSES[p][1])
        if planned == count:
            continue
        n, refused, dearer_j = track(way, here, n, plan, planned, price, most_j, there)
        if n < 0:
            return -1, False, 0.0, 0.0, 0
        here, there = there, here
        swapped = not swapped
        most_j -= dearer_j
        if refused == 0 and _PASSES[p][0] == 1.0:
            break
    count = plan_of(way, here, n, plan)
    if most == 1.0 and shortest(plan, count, least_s) >= 0:
        n, dearer_j = widen(way, here, n, plan, count, price, least_s, most_j, there)
        if n < 0:
            return -1, False, 0.0, 0.0, 0
        here, there = there, here
        swapped = not swapped
        most_j -= dearer_j
    now_s, now_j = measure(way, here, 0, n - 1)
    late_s = now_s - before_s - later_s
    if not abs(late_s) <= slack_s:  # no number is not in time
        n = _retime(way, here, n, plan, price, most_j, late_s, slack_s, there)
        if n < 0:
            return -1, False, 0.0, 0.0, 0
        here, there = there, here
        swapped = not swapped
        now_s, now_j = measure(way, here, 0, n - 1)
    return n, swapped, now_s - before_s, now_j - before_j, _short(plan, plan_of(way, here, n, plan), least_s)


class Pruner:
    """Leaves out of runs on one way what is too short to drive; holds the room that this takes.

    Parameters
    ----------
    way : Way
    most_rows : int
        Rows of any of the runs at most.
    """

    def __init__(self, way: Way, most_rows: int) -> None:
        self.way = way
        size = 2 * most_rows + _MORE_ROWS
        self.here, self.there = (Run(np.empty(size), np.empty(size), np.empty(size, dtype=np.int8)) for _ in range(2))
        self.plan = np.empty((_MOST_PHASES, PLAN_COLUMNS))

    def prune(
        self, x_m: _Floats, w: _Floats, price: float, least_s: float, most_j: float, window_s: tuple[float, float]
    ) -> Pruned:
        """Leave out of a run what is too short to drive.

        Parameters
        ----------
        x_m, w : (n,) float64
            Positions, m, and squared speeds, m²/s².
        price : float
            What a second is worth, J/s, auxiliaries included.
        least_s : float
            Phases that are shorter, s, are left out.
        most_j : float
            By how much E + λT may rise, J.
        window_s : (float, float)
            By how much the running time may change, s, at least and at most.

        Returns
        -------
        Pruned
        """
        n = len(x_m)
        later_s, slack_s = 0.5 * (window_s[0] + window_s[1]), 0.5 * (window_s[1] - window_s[0])
        for most in (1.0, _PASSES[0][0], 0.0):  # less, or nothing, where that would take another time
            self.here.x[:n], self.here.w[:n] = x_m, w
            size, swapped, time_s, energy_j, short = _prune(
                self.way, self.here, self.there, n, self.plan, price, least_s, most, most_j, later_s, slack_s
            )
            if size > 0:
                break
        run = self.there if swapped else self.here
        kept = run.x[:size].copy(), run.w[:size].copy(), run.regime[: size - 1].copy()
        return Pruned(time_s, energy_j, *kept, short)
