"""Costates along a run: what a lower bound is best evaluated with.

Along an optimal run p obeys, per unit of inertia and with κ·M as in `front.bounds`,

    p' = λ/(2v³) + 2p·∂ρ/∂w − κ·∂M/∂w,       κ = 1 + 2p (full traction), 0 (coasting), −2p (full braking)

and p = −½ while traction holds a speed, p = 0 while brakes do. At a switch between regimes p takes the value between
them, −½ or 0; where the run touches the speed limit p may jump downwards. So each phase is integrated from the end at
which p is known; where it is known at both, the two solutions are blended. Whatever p is, the bound stays valid.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.front.phases import COASTING, HELD_BACK, HOLDING, TOUCH, TRACTION, is_standstill, phase_end


@leaf
def _law(label):
    return 0 if label <= HOLDING else (1 if label == COASTING else 2)


@leaf
def _step(p, d, source, growth, j):
    """Value of p after ``d`` metres, negative: before, by the trapezoidal rule."""
    half = 0.5 * d * growth[j]
    half = min(max(half, -0.5), 0.5)
    return (p * (1.0 + half) + d * source[j]) / (1.0 - half)


@leaf
def _pin(before, after, touch):
    """Values of p that a switch of regimes fixes: at the end of the phase before, at the start of the phase after."""
    fixed_before = -0.5 if before == HOLDING else (0.0 if before == HELD_BACK else math.nan)
    fixed_after = -0.5 if after == HOLDING else (0.0 if after == HELD_BACK else math.nan)
    driving_before = before <= HOLDING
    braking_after = after >= HELD_BACK
    if driving_before and braking_after:
        return 0.0, 0.0  # coasting is too short to be seen
    if touch:
        if before == COASTING and braking_after:
            return 0.0, 0.0
        if (driving_before and after == COASTING) or (before == TRACTION and after == HOLDING):
            return -0.5, -0.5
        return fixed_before, fixed_after
    if before <= COASTING and after <= COASTING:
        return (-0.5, -0.5) if before != after else (math.nan, math.nan)
    if before == HELD_BACK and after == COASTING:
        return 0.0, math.nan  # the limit has risen: a jump
    if before >= COASTING and after >= COASTING:
        return 0.0, 0.0
    return (0.0 if before >= HELD_BACK else fixed_before), -0.5  # braking to driving: a jump


@kernel
def _backward(first, last, p, length, label, source, growth, out):
    """Integrate from p at the end of cell ``last`` − 1 back to ``first``; the end of each cell in ``out`` (K + 1)."""
    out[last] = p
    ramp = p > -0.5 and label[last - 1] <= HOLDING
    for k in range(last - 1, first - 1, -1):
        if label[k] == HOLDING and not ramp:
            p = -0.5
        else:
            p = _step(p, -length[k], source[k], growth[k], 1 if ramp else _law(label[k]))
            if ramp and p <= -0.5:
                ramp = False
                if label[k] == HOLDING:
                    p = -0.5
        out[k] = p


@kernel
def _forward(first, last, p, length, label, source, growth, out):
    """Integrate from p at the start of cell ``first``; the start of each cell in ``out``."""
    out[first] = p
    for k in range(first, last):
        if label[k] != HOLDING:
            p = _step(p, length[k], source[k], growth[k], _law(label[k]))
        out[k + 1] = p


@leaf
def _stiffness(length, w, price, k):
    """∂²H/∂w² = ¾λ/v⁵, times the length of cell k."""
    middle = 0.5 * (w[k] + w[k + 1])
    return 0.75 * price * length[k] / (middle * middle * math.sqrt(middle))


@kernel
def _fill_phase(k, last, start_pin, end_pin, length, w, price, label, source, growth, left, right, ahead, back):
    """Costates of the cells k to ``last`` − 1 from their values at the ends, either of which may be unknown (NaN).

    A mismatch δ between the two solutions costs ½∫(δ')²/H_ww ds, least where δ' is proportional to H_ww.
    """
    use_back = not math.isnan(end_pin)
    use_ahead = not math.isnan(start_pin)
    if use_back:
        _backward(k, last, end_pin, length, label, source, growth, back)
    if use_ahead:
        _forward(k, last, start_pin, length, label, source, growth, ahead)
    total = 0.0
    for j in range(k, last):
        total += _stiffness(length, w, price, j)
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
    return total


@leaf
def _held_costate(last, stop, ahead, stiff, effort, length, label):
    """Costate of partial braking after a coasting phase that is known from its start, p = ``ahead`` at its end.

    Coasting that meets the limit just before it would turn: bending p to 0 over the phase costs ½δ²/∫H_ww, keeping
    p < 0 while the brakes hold costs 2|p|·∫|f|. The sum is least here.
    """
    braking = 0.0
    j = last
    while j < stop and label[j] == HELD_BACK:
        braking -= effort[j] * length[j]
        j += 1
    return min(0.0, ahead + 2.0 * braking * stiff)


@kernel
def integrate_costates(length, w, cap, effort, price, label, source, growth, left, right, ahead, back):
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
    held = 0.0
    while k < stop:
        last = min(phase_end(k, label, w, cap), stop)
        end_pin = math.nan
        next_pin = math.nan
        touch = False
        if last < stop:
            touch = w[last] >= min(cap[last - 1], cap[last]) * (1.0 - TOUCH)
            end_pin, next_pin = _pin(label[k], label[last], touch)
        if label[k] == HELD_BACK or (label[k] == HOLDING and not end_pin > -0.5):
            level = held if label[k] == HELD_BACK else -0.5
            for j in range(k, last):
                left[j] = level
                right[j] = level
        else:
            if label[k] == HOLDING:
                start_pin = math.nan
            elif math.isnan(start_pin) and math.isnan(end_pin):
                start_pin = right[k - 1] if k > first else (-0.5 if label[k] == TRACTION else 0.0)
            stiff = _fill_phase(
                k, last, start_pin, end_pin, length, w, price, label, source, growth, left, right, ahead, back
            )
            again = label[k] != HOLDING and math.isnan(start_pin) and k > first and left[k] > right[k - 1]
            if again:  # p may not jump upwards
                start_pin = right[k - 1]
            held = 0.0
            if touch and label[k] == COASTING and label[last] == HELD_BACK and not (again or math.isnan(start_pin)):
                held = _held_costate(last, stop, ahead[last], stiff, effort, length, label)
                end_pin = held
                again = True
            if again:
                _fill_phase(
                    k, last, start_pin, end_pin, length, w, price, label, source, growth, left, right, ahead, back
                )
        start_pin = next_pin
        k = last
    if first == 1:
        left[0] = left[1]
        right[0] = left[1]
    if stop == count - 1:
        left[count - 1] = right[count - 2]
        right[count - 1] = right[count - 2]
