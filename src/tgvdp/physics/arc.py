"""ONE arc function: a segment and the squared speeds at its ends → feasible?, duration, work at the wheel.

Within the segment the acceleration is constant, so v² =: w is linear in position:

    duration T = 2·d/(v0 + v1)                                            exact, also from standstill
    work     X = ½·m_eff·(w1 − w0) + d·(mean resistance + grade force)    exact; E_wheel = max(X, 0)

Feasible means that the mean effort does not pass the mean of the limit, nor adds to an acceleration that passes the
comfort limit: without effort a train may gain or lose speed as the line has it.
On segments short enough for the effort limit to be nearly constant, as `physics.motion` makes them, that is the
pointwise limit; a caller with long segments adds `within_effort_at`.
"""

import math

from tgvdp._jit import leaf
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.physics.codes import OK, OVER_ACCELERATION, OVER_BRAKE, OVER_DECELERATION, OVER_TRACTION, STANDSTILL
from tgvdp.physics.forces import brake_at, effort_at, mean_brake, mean_effort, mean_resistance, resistance_at


@leaf
def duration_and_work(train, length_m, grade_n, air, w0, w1):
    """Duration in s and work of the effort in J of a segment of constant acceleration, limits or not; see `arc`.

    Two more numbers are what `arc` needs: the mean load in N, and the rounding error of the work.
    """
    return duration_and_work_of(train, length_m, grade_n, air, w0, w1, math.sqrt(w0), math.sqrt(w1))


@leaf
def duration_and_work_of(train, length_m, grade_n, air, w0, w1, v0, v1):
    """`duration_and_work` where the speeds are known: those at the end of a row are those at the start of the next."""
    gain = 0.5 * train.inertia_kg * (w1 - w0)
    mean_load = mean_resistance(train, air, v0, v1) + grade_n
    load = length_m * mean_load
    work = gain + load
    # Work near zero is the difference of large terms: its rounding error must not count as effort.
    noise = FEASIBILITY_RTOL * (abs(gain) + abs(load))
    return 2.0 * length_m / (v0 + v1), 0.0 if abs(work) <= noise else work, mean_load, noise


@leaf
def arc(train, length_m, grade_n, air, w0, w1):
    """Evaluate a segment of constant acceleration.

    Parameters
    ----------
    train : KernelTrain
    length_m : float
        Length d of the segment, m.
    grade_n : float
        Grade force on the train, N, positive uphill.
    air : float
        Coefficient of v² in the resistance, N/(m/s)².
    w0, w1 : float
        Squared speeds at its ends, m²/s².

    Returns
    -------
    status : int
        ``OK`` or the first limit that is broken.
    duration_s, work_j : float
        Defined whenever the status is not ``STANDSTILL``; the work is negative when braking.
    """
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    if v0 + v1 <= 0.0:
        return STANDSTILL, math.inf, math.inf
    duration, work, mean_load, noise = duration_and_work(train, length_m, grade_n, air, w0, w1)
    half_gain = 0.5 * (w1 - w0)
    slack = 1.0 + FEASIBILITY_RTOL
    if work > 0.0 and work > length_m * mean_effort(train.traction, v0, v1) * slack + noise:
        return OVER_TRACTION, duration, work
    if work < 0.0 and -work > length_m * mean_brake(train, mean_load, v0, v1) * slack + noise:
        return OVER_BRAKE, duration, work
    if work > noise and half_gain > length_m * train.max_acceleration * slack:
        return OVER_ACCELERATION, duration, work
    if work < -noise and -half_gain > length_m * train.max_deceleration * slack:
        return OVER_DECELERATION, duration, work
    return OK, duration, work


@leaf
def within_effort_at(train, grade_n, air, acceleration, v):
    """Whether the effort at one point of an arc, at speed v, stays within the effort curves."""
    resistance = resistance_at(train, air, v)
    effort = train.inertia_kg * acceleration + resistance + grade_n
    noise = FEASIBILITY_RTOL * (train.inertia_kg * abs(acceleration) + resistance + abs(grade_n))
    slack = 1.0 + FEASIBILITY_RTOL
    if effort > noise:
        return effort <= effort_at(train.traction, v) * slack + noise
    if effort < -noise:
        return -effort <= brake_at(train, resistance + grade_n, v) * slack + noise
    return True
