"""Costates along a run: what a lower bound is best evaluated with.

Along an optimal run p obeys p' = −∂H/∂w, which is linear in p in every regime (`front.phases.label_cells`). While
effort is partial p keeps the level between two regimes; at a switch it takes the value that both regimes allow; where
the run touches the speed limit it may jump downwards. So each phase is integrated from the end at which p is known;
where it is known at both, it is made to meet both (`certificate.regime_costates`). Whatever p is, the bound stays
valid.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.regime_costates import costate_step, fill_phase, law_of
from tgvdp.certificate.regimes import (
    BRAKING,
    COASTING,
    DYNAMIC_BRAKING,
    HELD_BACK,
    REGENERATION,
    RETARDED,
    TOUCH,
    TRACTION,
    highest_costate,
    is_partial,
    is_standstill,
    label_cells,
    lowest_costate,
    phase_end,
    tidy_labels,
)


@leaf
def _pin(before, after, touch, hold, retard):
    """Values of p that a switch of regimes fixes: at the end of the phase before, at the start of the phase after."""
    level_before = lowest_costate(before, hold, retard) if is_partial(before) else math.nan
    level_after = lowest_costate(after, hold, retard) if is_partial(after) else math.nan
    rise = max(lowest_costate(before, hold, retard), lowest_costate(after, hold, retard))  # least p after, if p rises
    fall = highest_costate(after, hold, retard)
    if before == after:
        return math.nan, math.nan  # the run touches the limit within a regime
    if max(before, after) == DYNAMIC_BRAKING and min(before, after) in (REGENERATION, BRAKING):
        return math.nan, math.nan  # only what the brakes can do changes
    if before < after:
        return rise, rise  # regimes between them are too short to be seen
    if touch:
        return level_before, level_after
    if is_partial(before) and after == COASTING:
        return level_before, math.nan  # braking ends where the limit rises: a jump
    if lowest_costate(before, hold, retard) == fall:
        return fall, fall
    return (0.0 if before >= HELD_BACK else level_before), fall


@leaf
def _held_costate(level, ahead, stiff, effort, source, growth):
    """Costate where partial braking begins after coasting whose costate is known from its start, ``ahead`` at its end.

    Coasting that meets the limit just before it would turn: bending p to the level of braking over the phase costs
    ½δ²/∫H_ww. Where p is δ below the level while the brakes hold, it rises by p' of coasting, and δ²·|f|/p' is lost
    until it is there. The sum is least here.
    """
    rise = source[1] + growth[1] * level
    if ahead >= level or rise <= 0.0:
        return level
    return level - (level - ahead) / (1.0 + 2.0 * max(-effort, 0.0) * stiff / rise)


@kernel
def _integrate(length, w, cap, effort, price, hold, retard, label, source, growth, left, right, ahead, back):
    """Costates along a run whose cells are labelled; see `run_costates`."""
    count = length.shape[0]
    first = 1 if is_standstill(w[0], w[1]) else 0
    stop = count - 1 if is_standstill(w[count], w[count - 1]) else count
    k = first
    start_pin = math.nan
    held = math.nan
    while k < stop:
        last = min(phase_end(k, label, w, cap), stop)
        end_pin = math.nan
        next_pin = math.nan
        touch = False
        if last < stop:
            touch = w[last] >= min(cap[last - 1], cap[last]) * (1.0 - TOUCH)
            end_pin, next_pin = _pin(label[k], label[last], touch, hold, retard)
        level = lowest_costate(label[k], hold, retard)
        if is_partial(label[k]) and not end_pin > level:
            p = level if math.isnan(held) else held
            held = math.nan
            for j in range(k, last):
                left[j] = p
                if p < level:
                    p = min(costate_step(p, length[j], source[j], growth[j], law_of(COASTING)), level)
                right[j] = p
            if p < level and next_pin > p:
                next_pin = p  # p may not jump upwards
        else:
            held = math.nan
            if is_partial(label[k]):
                start_pin = math.nan
            elif label[k] == TRACTION and last < stop and label[last] == TRACTION and math.isnan(start_pin):
                end_pin = hold  # it meets the limit, and begins where another one ends
            free = math.isnan(start_pin) and math.isnan(end_pin)
            if free:
                start_pin = right[k - 1] if k > first else min(highest_costate(label[k], hold, retard), 0.0)
            stiff, reach = fill_phase(
                k, last, start_pin, end_pin, hold, retard, length, w, cap, price, label, source, growth,
                left, right, ahead, back,
            )  # fmt: skip
            again = free and touch and right[last - 1] > highest_costate(label[k], hold, retard)
            if again:  # between two touches of the limit p may jump down at both: what it may be at the end counts
                start_pin = math.nan
                end_pin = highest_costate(label[k], hold, retard)
            elif not is_partial(label[k]) and math.isnan(start_pin) and k > first and left[k] > right[k - 1]:
                start_pin = right[k - 1]  # p may not jump upwards
                again = True
            held_next = last < stop and touch and label[k] == COASTING and (label[last] in (RETARDED, HELD_BACK))
            if held_next and not (again or math.isnan(start_pin)):
                level = lowest_costate(label[last], hold, retard)
                held = _held_costate(level, reach, stiff, effort[last], source[last], growth[last])
                end_pin = held
                again = True
            if again:
                fill_phase(
                    k, last, start_pin, end_pin, hold, retard, length, w, cap, price, label, source, growth,
                    left, right, ahead, back,
                )  # fmt: skip
        start_pin = next_pin
        k = last
    if first == 1:
        left[0] = left[1]
        right[0] = left[1]
    if stop == count - 1:
        left[count - 1] = right[count - 2]
        right[count - 1] = right[count - 2]


@kernel
def run_costates(
    train, tables, length, grade, air, limit, ceiling, w, effort, price, sliver, top_v, pieces, label, source, growth,
    left, right, ahead, back,
):  # fmt: skip
    """Regimes and costates along a run.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
    length, grade, air, limit : (K,) float64
        Cells: length in m, gradient force in N, coefficient of v² in N/(m/s)², squared speed limit in m²/s².
    ceiling : (K,) float64
        Squared speed that no run passes in the cell, m²/s².
    w : (K + 1,) float64
        Squared speed of the run at the ends of the cells, m²/s².
    effort : (K,) float64, modified in place
        Mean effort of the row of the run that a cell belongs to, N; afterwards per unit of inertia.
    price : float
        λ per unit of inertia.
    sliver : float
        Phases shorter than this are rounding errors, m.
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 2n, 6) float64
        Scratch for the pieces of the effort curves.
    label : (K,) int8, modified in place
        Regimes (`certificate.regimes`).
    source, growth : (K, 4) float64, modified in place
        Coefficients of p' = source + growth·p: one column each for traction, coasting, regeneration and braking.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell. The cells next to a standstill have none; they repeat their neighbour's.
    ahead, back : (K + 1,) float64
        Scratch.
    """
    hold = -0.5 * tables.traction
    retard = -0.5 * tables.regeneration
    label_cells(train, tables, length, grade, air, w, effort, price, top_v, pieces, label, source, growth)
    tidy_labels(sliver, length, w, limit, ceiling, hold, retard, label, source, growth)
    for k in range(length.shape[0]):
        effort[k] /= train.inertia_kg
    _integrate(length, w, limit, effort, price, hold, retard, label, source, growth, left, right, ahead, back)
