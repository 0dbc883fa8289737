"""Costates along a run: what a lower bound is best evaluated with.

Along an optimal run p obeys p' = −∂H/∂w, which is linear in p in every regime (`front.phases.label_cells`). While
effort is partial p keeps the level between two regimes; at a switch it takes the value that both regimes allow; where
the run touches the speed limit it may jump downwards. So each phase is integrated from the end at which p is known;
where it is known at both, the two solutions are blended. Whatever p is, the bound stays valid.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.front.phases import (
    BRAKING,
    COASTING,
    DYNAMIC_BRAKING,
    HELD_BACK,
    HOLDING,
    REGENERATION,
    RETARDED,
    TOUCH,
    TRACTION,
    is_partial,
    is_standstill,
    phase_end,
    slides,
)

#: Newton steps at most to make the costate of a coasting phase meet both its ends, and how well, absolute.
_SHOTS = 12
_HIT = 1e-9


@leaf
def _lowest(label, hold, retard):
    """Lowest p of a regime; ``hold`` and ``retard`` are the levels −a/2 and −η/2."""
    if label == TRACTION:
        return -math.inf
    if label <= COASTING:
        return hold
    return retard if label <= REGENERATION or label == DYNAMIC_BRAKING else 0.0


@leaf
def _highest(label, hold, retard):
    """Highest p of a regime."""
    if label <= HOLDING:
        return hold
    if label <= RETARDED:
        return retard
    return 0.0 if label <= HELD_BACK else math.inf


@leaf
def _law(label):
    """Column of the coefficients of p' for a regime."""
    if label <= HOLDING:
        return 0
    if label == COASTING:
        return 1
    return 2 if label <= REGENERATION else 3


@leaf
def _law_at(p, hold, retard):
    """Column of the coefficients of p' that go with a value of p."""
    if p < hold:
        return 0
    if p < retard:
        return 1
    return 2 if p < 0.0 else 3


@leaf
def _step(p, d, source, growth, j):
    """Value of p after ``d`` metres, negative: before, by the trapezoidal rule."""
    half = 0.5 * d * growth[j]
    half = min(max(half, -0.5), 0.5)
    return (p * (1.0 + half) + d * source[j]) / (1.0 - half)


@leaf
def _pin(before, after, touch, hold, retard):
    """Values of p that a switch of regimes fixes: at the end of the phase before, at the start of the phase after."""
    level_before = _lowest(before, hold, retard) if is_partial(before) else math.nan
    level_after = _lowest(after, hold, retard) if is_partial(after) else math.nan
    rise = max(_lowest(before, hold, retard), _lowest(after, hold, retard))  # least p after, if p rises
    fall = _highest(after, hold, retard)
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
    if _lowest(before, hold, retard) == fall:
        return fall, fall
    return (0.0 if before >= HELD_BACK else level_before), fall


@kernel
def _backward(first, last, p, hold, retard, length, w, cap, label, source, growth, out):
    """Integrate from p at the end of cell ``last`` − 1 back to ``first``; the end of each cell in ``out`` (K + 1)."""
    out[last] = p
    kind = label[last - 1]
    level = _lowest(kind, hold, retard) if is_partial(kind) else _highest(kind, hold, retard)
    ramp = p > level  # regimes too short to be seen: their laws go with p
    for k in range(last - 1, first - 1, -1):
        if is_partial(kind) and not ramp:
            p = level
        elif ramp or not slides(k, w, cap):
            p = _step(p, -length[k], source[k], growth[k], _law_at(p, hold, retard) if ramp else _law(kind))
            if ramp and p <= level:
                ramp = False
                if is_partial(kind):
                    p = level
        out[k] = p


@kernel
def _forward(first, last, p, length, w, cap, label, source, growth, out):
    """Integrate from p at the start of cell ``first``; the start of each cell in ``out``."""
    out[first] = p
    for k in range(first, last):
        if not (is_partial(label[k]) or slides(k, w, cap)):
            p = _step(p, length[k], source[k], growth[k], _law(label[k]))
        out[k + 1] = p


@leaf
def _stiffness(length, w, price, k):
    """∂²H/∂w² = ¾λ/v⁵, times the length of cell k."""
    middle = 0.5 * (w[k] + w[k + 1])
    return 0.75 * price * length[k] / (middle * middle * math.sqrt(middle))


@kernel
def _shoot(first, last, p, end_p, length, w, source, growth, out):
    """Costates of coasting from p at the start of cell ``first`` to ``end_p``, along a run of another speed.

    The blend of two solutions is right to first order in their mismatch. Here the whole phase is driven faster or
    slower: D, the difference in w, decays as coasting has it, and p' = λ/(2v³) + 2p·∂ρ/∂w at w + D. The end of p is a
    convex, falling function of the first D, found by Newton's rule. Returns the last D, NaN where there is none.
    """
    shift = 0.0
    for _ in range(_SHOTS):
        out[first] = p
        by_shift = 0.0
        decay = 1.0
        for k in range(first, last):
            half = 0.5 * length[k] * growth[k, 1]
            here = 0.5 * (w[k] + w[k + 1])
            decay_k = decay * (1.0 - half)
            there = here + shift * decay_k
            if not (there > 0.1 * here and abs(half) < 0.5):
                return math.nan
            rate = source[k, 1] * (here / there) * math.sqrt(here / there)
            out[k + 1] = (out[k] * (1.0 + half) + length[k] * rate) / (1.0 - half)
            by_shift = (by_shift * (1.0 + half) - 1.5 * length[k] * rate * decay_k / there) / (1.0 - half)
            decay *= (1.0 - half) / (1.0 + half)
        missed = out[last] - end_p
        if abs(missed) <= _HIT:
            out[last] = end_p
            return shift * decay
        shift -= missed / by_shift
    return math.nan


@kernel
def _fill_phase(
    k, last, start_pin, end_pin, hold, retard, length, w, cap, price, label, source, growth, left, right, ahead, back
):
    """Costates of the cells k to ``last`` − 1 from their values at the ends, either of which may be unknown (NaN).

    A mismatch δ between the two solutions costs ½∫(δ')²/H_ww ds, least where δ' is proportional to H_ww.
    Returns ∫H_ww ds, and where p would end if nothing but its start were known: for large δ, as if costs were of
    second order.
    """
    use_back = not math.isnan(end_pin)
    use_ahead = not math.isnan(start_pin)
    if use_back:
        _backward(k, last, end_pin, hold, retard, length, w, cap, label, source, growth, back)
    if use_ahead:
        _forward(k, last, start_pin, length, w, cap, label, source, growth, ahead)
    reach = ahead[last] if use_ahead else math.nan
    total = 0.0
    for j in range(k, last):
        total += _stiffness(length, w, price, j)
    if use_ahead and use_back and label[k] == COASTING:
        shift = _shoot(k, last, start_pin, end_pin, length, w, source, growth, ahead)
        use_back = math.isnan(shift)
        if not use_back:
            reach = end_pin + shift * total
        else:
            _forward(k, last, start_pin, length, w, cap, label, source, growth, ahead)
    done = 0.0
    for j in range(k, last):
        share = done / total
        done += _stiffness(length, w, price, j)
        after = done / total
        if not use_back:
            left[j] = ahead[j]
            right[j] = ahead[j + 1]
        elif not use_ahead:
            left[j] = back[j]
            right[j] = back[j + 1]
        else:
            left[j] = (1.0 - share) * ahead[j] + share * back[j]
            right[j] = (1.0 - after) * ahead[j + 1] + after * back[j + 1]
    return total, reach


@leaf
def _held_costate(level, ahead, stiff, effort, source, growth):
    """Costate where partial braking begins after a coasting phase that is known from its start, p = ``ahead`` at its end.

    Coasting that meets the limit just before it would turn: bending p to the level of braking over the phase costs
    ½δ²/∫H_ww. Where p is δ below the level while the brakes hold, it rises by p' of coasting, and δ²·|f|/p' is lost
    until it is there. The sum is least here.
    """
    rise = source[1] + growth[1] * level
    if ahead >= level or rise <= 0.0:
        return level
    return level - (level - ahead) / (1.0 + 2.0 * max(-effort, 0.0) * stiff / rise)


@kernel
def integrate_costates(length, w, cap, effort, price, hold, retard, label, source, growth, left, right, ahead, back):
    """Costates along a run.

    Parameters
    ----------
    length : (K,) float64
        Cells, m.
    w : (K + 1,) float64
        Squared speed at their ends, m²/s².
    cap, effort : (K,) float64
        Squared speed limit, and effort per unit of inertia.
    price : float
        λ per unit of inertia.
    hold, retard : float
        Levels of p at which traction holds a speed, and the dynamic brake does.
    label, source, growth
        From `front.phases.label_cells`.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell. The cells next to a standstill have none; they repeat their neighbour's.
    ahead, back : (K + 1,) float64
        Scratch.
    """
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
        level = _lowest(label[k], hold, retard)
        if is_partial(label[k]) and not end_pin > level:
            p = level if math.isnan(held) else held
            held = math.nan
            for j in range(k, last):
                left[j] = p
                if p < level:
                    p = min(_step(p, length[j], source[j], growth[j], _law(COASTING)), level)
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
                start_pin = right[k - 1] if k > first else min(_highest(label[k], hold, retard), 0.0)
            stiff, reach = _fill_phase(
                k, last, start_pin, end_pin, hold, retard, length, w, cap, price, label, source, growth,
                left, right, ahead, back,
            )  # fmt: skip
            again = free and touch and right[last - 1] > _highest(label[k], hold, retard)
            if again:  # between two touches of the limit p may jump down at both: what it may be at the end counts
                start_pin = math.nan
                end_pin = _highest(label[k], hold, retard)
            elif not is_partial(label[k]) and math.isnan(start_pin) and k > first and left[k] > right[k - 1]:
                start_pin = right[k - 1]  # p may not jump upwards
                again = True
            held_next = last < stop and touch and label[k] == COASTING and (label[last] in (RETARDED, HELD_BACK))
            if held_next and not (again or math.isnan(start_pin)):
                level = _lowest(label[last], hold, retard)
                held = _held_costate(level, reach, stiff, effort[last], source[last], growth[last])
                end_pin = held
                again = True
            if again:
                _fill_phase(
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
