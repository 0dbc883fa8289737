"""Runs between two extremals: blends of their policies that take given running times, one after the other.

Two extremals know the front between them by their running times, energies and slopes −λ: a Hermite cubic. A blend of
their policies that drives worse than that is refused, for an extremal to be solved there.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.methods.costate.forward import drive_blend, find_rides
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import NO_ROOM, NOT_KEPT, NOT_MET, OK
from tgvdp.physics.roots import Bracket, narrowed, secant

#: Columns of the runs that `drive` returns: rows from .. to, running time, energy, multiplier, bracket of shares.
RUN_COLUMNS = 7
#: Blends of two extremals whose running times are remembered, at most.
SAMPLES = 128
#: A search for a running time ends when its bracket of shares is smaller than this, or after so many runs.
_SAME_SHARE = 1e-9
_MOST_RUNS = 30


def cubic_energy_j(ends, time_s):
    """Energy at a time by the Hermite cubic through two runs, whose slopes are minus their multipliers.

    ``ends`` are running time, energy and multiplier of the first run, then of the second.
    """
    first_s, first_j, first_multiplier, second_s, second_j, second_multiplier = (
        ends[0], ends[1], ends[2], ends[3], ends[4], ends[5],
    )  # fmt: skip
    span = second_s - first_s
    u = (time_s - first_s) / span
    value = (1.0 + 2.0 * u) * (1.0 - u) ** 2 * first_j + u * u * (3.0 - 2.0 * u) * second_j
    return value - span * (u * (1.0 - u) ** 2 * first_multiplier - u * u * (1.0 - u) * second_multiplier)


def cubic_multiplier(ends, time_s):
    """Multiplier at a time: minus the slope of that cubic, within the multipliers of the two runs.

    The second's where that of the first is infinite.
    """
    first_s, first_j, first_multiplier, second_s, second_j, second_multiplier = (
        ends[0], ends[1], ends[2], ends[3], ends[4], ends[5],
    )  # fmt: skip
    if math.isinf(first_multiplier):
        return second_multiplier
    span = second_s - first_s
    u = min(max((time_s - first_s) / span, 0.0), 1.0)
    chord = (first_j - second_j) / span
    bends = (1.0 - 4.0 * u + 3.0 * u * u) * first_multiplier + (3.0 * u * u - 2.0 * u) * second_multiplier
    return min(max(6.0 * u * (1.0 - u) * chord + bends, second_multiplier), first_multiplier)


_cubic_energy_j = leaf(cubic_energy_j)
_cubic_multiplier = leaf(cubic_multiplier)


@leaf
def _first_share(samples, known, at, time_s):
    """Share to try between the samples ``at − 1`` and ``at``: by those two and one more, if there is one."""
    u0 = samples[at - 1, 0]
    t0 = samples[at - 1, 1]
    u1 = samples[at, 0]
    t1 = samples[at, 1]
    if not t0 < time_s < t1:
        return u0 if time_s <= t0 else u1
    straight = u0 + (u1 - u0) * (time_s - t0) / (t1 - t0)
    if known == 2:
        return straight
    third = at - 2 if at > 1 else at + 1
    bend = ((samples[third, 0] - u1) / (samples[third, 1] - t1) - (u1 - u0) / (t1 - t0)) / (samples[third, 1] - t0)
    bent = straight + bend * (time_s - t0) * (time_s - t1)
    return bent if u0 < bent < u1 else straight


@part
def _meet(
    train, tables, course, first_policy, second_policy, samples, known, target_s, tolerance_s, scratch, rows, run
):
    """Drive blends until one takes the target time (Illinois rule); returns its rows, known samples and runs.

    ``run`` gets running time, energy, and the bracket of shares that is left, from its third entry on.
    """
    at = 1
    while at < known - 1 and samples[at, 1] < target_s:
        at += 1
    share = _first_share(samples, known, at, target_s)
    bracket = Bracket(samples[at - 1, 0], samples[at, 0], samples[at - 1, 1] - target_s, samples[at, 1] - target_s, 0)
    bracketed = bracket.f_lo < 0.0 < bracket.f_hi
    runs = 0
    while True:
        n, time, energy = drive_blend(train, tables, course, first_policy, second_policy, share, scratch, rows)
        runs += 1
        f = time - target_s
        close = abs(f) <= tolerance_s or bracket.hi - bracket.lo < _SAME_SHARE
        if n < 0 or not bracketed or close or runs >= _MOST_RUNS:
            break
        bracket = narrowed(bracket, share, f)
        share = secant(bracket)
    run[2] = time
    run[3] = energy
    run[5] = bracket.lo
    run[6] = bracket.hi
    if n > 0 and known < samples.shape[0] and samples[at - 1, 1] < time < samples[at, 1]:
        for i in range(known, at, -1):
            samples[i, 0] = samples[i - 1, 0]
            samples[i, 1] = samples[i - 1, 1]
        samples[at, 0] = share
        samples[at, 1] = time
        known += 1
    return n, known, runs, not bracketed or abs(f) <= tolerance_s


@kernel
def drive(
    train, tables, course, start_w, first_policy, second_policy, ends, loss, least_loss_j, samples, known, targets,
    tolerance_s, rows, stored, scratch, runs,
):  # fmt: skip
    """Drive blends of two policies through the whole trip that take given times, one after the other.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        Of which only the two factors count.
    course : Course
    start_w : float
        Squared speed at the origin.
    first_policy, second_policy : (K + 1, 4) float64
        Policies of the two extremals.
    ends : (6,) float64
        Running time, energy and multiplier of the first extremal, then of the second.
    loss, least_loss_j : float
        A run may cost more than the cubic through the extremals promises by this share of its energy, and at least by
        so much; an infinite loss refuses no run, nor does an infinite multiplier of the first extremal.
    samples : (S, 2) float64, modified in place
        Shares of the second policy and running times of ``known`` blends, in order. Of a single one the share is
        driven, whatever time it takes.
    known : int
    targets : (n,) float64
        Running times that are wanted, s.
    tolerance_s : float
        How well.
    rows : Rows, modified in place
        Rows of the runs: positions from the origin, squared speeds.
    stored : int
        Rows that are taken already.
    scratch : Rows
    runs : (n, 7) float64, modified in place
        `RUN_COLUMNS` of each target's run; of a time that is not met, the run next to it.

    Returns
    -------
    done : int
        Targets done before the kernel ended.
    status : int
        OK, or why it ended at the next one: NO_ROOM, NOT_MET or NOT_KEPT.
    known : int
        Number of samples now.
    driven : int
        Number of runs.
    """
    if course.stays[0] < 0:
        find_rides(train, course)
    driven = 0
    for i in range(targets.shape[0]):
        if stored >= rows.x.shape[0]:
            return i, NO_ROOM, known, driven
        free = Rows(rows.x[stored:], rows.w[stored:])
        free.x[0] = 0.0
        free.w[0] = start_w
        run = runs[i]
        met = True
        if known == 1:
            n, run[2], run[3] = drive_blend(
                train, tables, course, first_policy, second_policy, samples[0, 0], scratch, free
            )
            driven += 1
        else:
            n, known, tried, met = _meet(
                train, tables, course, first_policy, second_policy, samples, known, targets[i], tolerance_s, scratch,
                free, run,
            )  # fmt: skip
            driven += tried
        if n < 0:
            return i, NO_ROOM, known, driven
        if not met:
            return i, NOT_MET, known, driven
        if known > 1:
            run[4] = _cubic_multiplier(ends, run[2])
            if ends[2] < math.inf:
                promised_j = _cubic_energy_j(ends, run[2])
                if run[3] > promised_j + max(loss * run[3], least_loss_j):
                    return i, NOT_KEPT, known, driven
        run[0] = stored
        stored += n
        run[1] = stored
    return targets.shape[0], OK, known, driven
