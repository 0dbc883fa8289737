"""Runs between two extremals: blends of their policies that take given running times, one after the other.

Two extremals know the front between them by their running times, energies and slopes −λ: a Hermite cubic. A blend of
their policies that drives worse than that is refused, for an extremal to be solved there.
"""

import math

from tgvdp._jit import entry, leaf, part
from tgvdp.methods.costate.extremal import foretell
from tgvdp.methods.costate.forward import drive_blend, find_rides
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import NO_ROOM, NOT_KEPT, NOT_MET, OK
from tgvdp.physics.roots import Bracket, narrowed, secant

#: Columns of the runs that `drive` returns: rows from .. to, running time, energy, multiplier, bracket of shares.
RUN_COLUMNS = 7
#: Blends of two extremals whose running times are remembered, at most.
SAMPLES = 128
#: A search for a running time ends, for it jumps, when it would change by less than this share of the tolerance within
#: the bracket of shares if it changed evenly with them; or after so many runs.
_EVEN = 0.1
_MOST_RUNS = 30
#: Of these the first are foretold, each from those before it; after that running times jump, or nearly.
_FORETOLD_RUNS = 3


_foretell = leaf(foretell)


@leaf
def _astray(ends, samples, i):
    """How much larger the share of a sample is than that foretold for its running time."""
    return samples[i, 0] - _foretell(ends, samples[i, 1]).share


@leaf
def _foretold_share(ends, samples, known, at, time_s):
    """Share to try between the samples ``at − 1`` and ``at``.

    It is what is foretold, corrected by what that is astray at the samples around: a polynomial through four of them.
    """
    first = max(at - 2, 0)
    last = min(at + 1, known - 1)
    correction = 0.0
    for i in range(first, last + 1):
        weight = 1.0
        for j in range(first, last + 1):
            if j != i:
                weight *= (time_s - samples[j, 1]) / (samples[i, 1] - samples[j, 1])
        correction += weight * _astray(ends, samples, i)
    return _foretell(ends, time_s).share + correction


@part
def _meet(train, tables, course, blend, ends, samples, known, target_s, tolerance_s, scratch, rows, run):
    """Drive blends until one takes the target time; returns its rows, known samples, runs, and whether it is met.

    The first ones are foretold, the others follow the Illinois rule. ``run`` gets running time, energy, and the bracket
    of shares that is left, from its third entry on.
    """
    at = 1
    while at < known - 1 and samples[at, 1] < target_s:
        at += 1
    bracket = Bracket(samples[at - 1, 0], samples[at, 0], samples[at - 1, 1] - target_s, samples[at, 1] - target_s, 0)
    bracketed = bracket.f_lo < 0.0 < bracket.f_hi
    share = bracket.lo if bracket.f_lo >= 0.0 else bracket.hi
    span_s = ends[3] - ends[0]
    runs = 0
    while True:
        if bracketed:
            share = secant(bracket)
            foretold = _foretold_share(ends, samples, known, at, target_s)
            if ends[2] < math.inf and runs < _FORETOLD_RUNS and bracket.lo < foretold < bracket.hi:
                share = foretold
        n, time, energy = drive_blend(train, tables, course, blend, share, scratch, rows)
        runs += 1
        f = time - target_s
        if n > 0 and known < samples.shape[0] and samples[at - 1, 1] < time < samples[at, 1]:
            for i in range(known, at, -1):
                samples[i, 0] = samples[i - 1, 0]
                samples[i, 1] = samples[i - 1, 1]
            samples[at, 0] = share
            samples[at, 1] = time
            known += 1
            if f < 0.0:
                at += 1
        close = abs(f) <= tolerance_s or (bracket.hi - bracket.lo) * span_s < _EVEN * tolerance_s
        if n < 0 or not bracketed or close or runs >= _MOST_RUNS:
            break
        bracket = narrowed(bracket, share, f)
    run[2] = time
    run[3] = energy
    run[5] = bracket.lo
    run[6] = bracket.hi
    return n, known, runs, not bracketed or abs(f) <= tolerance_s


@entry
def drive(
    train, tables, course, start_w, blend, ends, loss, least_loss_j, samples, known, targets, tolerance_s, rows,
    stored, scratch, runs,
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
    blend : Blend
        Of the policies of the two extremals.
    ends : (6,) float64
        Running time, energy and multiplier of the first extremal, then of the second.
    loss, least_loss_j : float
        A run may cost more than the cubic through the extremals promises by this share of its energy, and at least by
        so much, but no more than a faster one; an infinite loss refuses no run, nor does an infinite multiplier of the
        first extremal.
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
        find_rides(train, tables, course)
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
            n, run[2], run[3] = drive_blend(train, tables, course, blend, samples[0, 0], scratch, free)
            driven += 1
        else:
            n, known, tried, met = _meet(
                train, tables, course, blend, ends, samples, known, targets[i], tolerance_s, scratch, free, run,
            )  # fmt: skip
            driven += tried
        if n < 0:
            return i, NO_ROOM, known, driven
        if not met:
            return i, NOT_MET, known, driven
        if known > 1:
            foretold = _foretell(ends, run[2])
            run[4] = foretold.multiplier
            faster_j = runs[i - 1, 3] if i > 0 else ends[1]
            dearest_j = min(foretold.energy_j + max(loss * run[3], least_loss_j), faster_j)
            if ends[2] < math.inf and loss < math.inf and run[3] > dearest_j:
                return i, NOT_KEPT, known, driven
        run[0] = stored
        stored += n
        run[1] = stored
    return targets.shape[0], OK, known, driven
