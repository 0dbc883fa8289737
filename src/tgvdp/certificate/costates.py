"""Costates along a run: what a lower bound is best evaluated with.

Along an optimal run p obeys p' = −∂H/∂w, which is linear in p in every regime (`regimes.label_cells`). While
effort is partial p keeps the level between two regimes; at a switch it takes the value that both regimes allow; where
the run touches the speed limit it may jump downwards. So each phase is integrated from the end at which p is known;
where it is known at both, it is made to meet both (`certificate.regime_costates`). Whatever p is, the bound stays
valid.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.regime_costates import costate_step, fill_phase, law_of
from tgvdp.certificate.regimes import (
    TOUCH,
    goes_on,
    highest_costate,
    is_partial,
    is_standstill,
    lowest_costate,
    order_of,
    phase_end,
    tidy_labels,
)
from tgvdp.physics.codes import COASTING, HELD_BACK, RETARDED, TRACTION


@leaf
def _pin(run, before, after, touch):
    """Values of p that a switch of regimes fixes: at the end of the phase before, at the start of the phase after."""
    level_before = lowest_costate(run, before) if is_partial(before) else math.nan
    level_after = lowest_costate(run, after) if is_partial(after) else math.nan
    rise = max(lowest_costate(run, before), lowest_costate(run, after))  # least p after, if p rises
    fall = highest_costate(run, after)
    if goes_on(before, after):
        return math.nan, math.nan  # the run touches the limit within a regime
    if order_of(before) < order_of(after):
        return rise, rise  # regimes between them are too short to be seen
    if touch:
        return level_before, level_after
    if is_partial(before) and after == COASTING:
        return level_before, math.nan  # braking ends where the limit rises: a jump
    if lowest_costate(run, before) == fall:
        return fall, fall
    return (0.0 if order_of(before) >= order_of(HELD_BACK) else level_before), fall


@leaf
def _held_costate(run, k, level, ahead, stiff):
    """Costate where partial braking begins after coasting whose costate is known from its start, ``ahead`` at its end.

    Coasting that meets the limit just before it would turn: bending p to the level of braking over the phase costs
    ½δ²/∫H_ww. Where p is δ below the level while the brakes hold, it rises by p' of coasting, and δ²·|f|/p' is lost
    until it is there. The sum is least here.
    """
    rise = run.source[k, 1] + run.growth[k, 1] * level
    if ahead >= level or rise <= 0.0:
        return level
    return level - (level - ahead) / (1.0 + 2.0 * max(-run.effort[k], 0.0) * stiff / rise)


@kernel
def _integrate(run, costates):
    """Costates along a run whose cells are labelled; see `run_costates`."""
    left, right = costates.left, costates.right
    label = run.label
    w = run.w
    length = run.cells.length_m
    cap = run.cells.limit_w
    count = length.shape[0]
    first = 1 if is_standstill(w[0], w[1]) else 0
    stop = count - 1 if is_standstill(w[count], w[count - 1]) else count
    k = first
    start_pin = math.nan
    held = math.nan
    while k < stop:
        last = min(phase_end(run, k), stop)
        end_pin = math.nan
        next_pin = math.nan
        touch = False
        if last < stop:
            touch = w[last] >= min(cap[last - 1], cap[last]) * (1.0 - TOUCH)
            end_pin, next_pin = _pin(run, label[k], label[last], touch)
        level = lowest_costate(run, label[k])
        if is_partial(label[k]) and not end_pin > level:
            p = level if math.isnan(held) else held
            held = math.nan
            for j in range(k, last):
                left[j] = p
                if p < level:
                    p = min(costate_step(run, j, p, length[j], law_of(COASTING)), level)
                right[j] = p
            if p < level and next_pin > p:
                next_pin = p  # p may not jump upwards
        else:
            held = math.nan
            if is_partial(label[k]):
                start_pin = math.nan
            elif label[k] == TRACTION and last < stop and label[last] == TRACTION and math.isnan(start_pin):
                end_pin = run.hold  # it meets the limit, and begins where another one ends
            free = math.isnan(start_pin) and math.isnan(end_pin)
            if free:
                start_pin = right[k - 1] if k > first else min(highest_costate(run, label[k]), 0.0)
            stiff, reach = fill_phase(run, k, last, start_pin, end_pin, costates)
            again = free and touch and right[last - 1] > highest_costate(run, label[k])
            if again:  # between two touches of the limit p may jump down at both: what it may be at the end counts
                start_pin = math.nan
                end_pin = highest_costate(run, label[k])
            elif not is_partial(label[k]) and math.isnan(start_pin) and k > first and left[k] > right[k - 1]:
                start_pin = right[k - 1]  # p may not jump upwards
                again = True
            held_next = last < stop and touch and label[k] == COASTING and (label[last] in (RETARDED, HELD_BACK))
            if held_next and not (again or math.isnan(start_pin)):
                level = lowest_costate(run, label[last])
                held = _held_costate(run, last, level, reach, stiff)
                end_pin = held
                again = True
            if again:
                fill_phase(run, k, last, start_pin, end_pin, costates)
        start_pin = next_pin
        k = last
    if first == 1:
        left[0] = left[1]
        right[0] = left[1]
    if stop == count - 1:
        left[count - 1] = right[count - 2]
        right[count - 1] = right[count - 2]


@kernel
def run_costates(run, bound_w, sliver, moment_s, costates):
    """Costates along a run whose cells are labelled.

    Parameters
    ----------
    run : LabelledRun
        Its labels are tidied in place.
    bound_w : (K,) float64
        Squared speed that no run passes in the cell, m²/s².
    sliver, moment_s : float
        Phases shorter than this, m, are rounding errors; shorter than this, s, they may be slips of the run.
    costates : Costates, modified in place
        The cells next to a standstill have none; they repeat their neighbour's.
    """
    tidy_labels(run, sliver, moment_s, bound_w)
    _integrate(run, costates)
