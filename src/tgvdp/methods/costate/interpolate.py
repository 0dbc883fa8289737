"""Runs between two extremals: blends of their policies that take given running times, one after the other.

Two extremals know the front between them by their running times, energies and slopes −λ: a Hermite cubic. A blend of
their policies that drives worse than that is refused, for an extremal to be solved there.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, leaf, part
from tgvdp.methods.costate.blend import Blend, fill_blend
from tgvdp.methods.costate.extremal import foretell
from tgvdp.methods.costate.forward import drive_blend, find_rides
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import NO_ROOM, NOT_KEPT, NOT_MET, NOT_TRIED, OK
from tgvdp.physics.roots import Bracket, narrowed, secant

#: Columns of the runs that `drive` returns: rows from .. to, running time, energy, multiplier, bracket of shares, and
#: how it went with a target.
RUN_COLUMNS = 8
#: Blends of two extremals whose running times are remembered, at most.
SAMPLES = 128
#: A search for a running time ends, for it jumps, when it would change by less than this share of the tolerance within
#: the bracket of shares if it changed evenly with them; or after so many runs.
_EVEN = 0.1
_MOST_RUNS = 30
#: Of these the first are foretold, each from those before it; after that running times jump, or nearly.
_FORETOLD_RUNS = 3
#: A run that costs less than extremals promise tells as well that they do not know the front between them; in so many
#: times what it may cost more.
CHEAPER = 4.0


_foretell = leaf(foretell)


class Scratch(NamedTuple):
    """What kernels write on their way.

    Attributes
    ----------
    march : Rows
        Rows of one march at a time.
    passed : (K + 1, 3) float64
        Squared speed, running time and energy of the run that was driven last, at each station.
    blend : Blend
        Of the two extremals between which runs were driven last.
    samples : (S, 2) float64
        Shares of the second policy and running times of its blends that are known, in order.
    resumed : (3,) float64
        Where targets of two extremals are too many for the room: the slower one, its known samples, and the energy of
        the last run; −1 for the first if there are none.
    """

    march: Rows
    passed: NDArray[np.float64]
    blend: Blend
    samples: NDArray[np.float64]
    resumed: NDArray[np.float64]


class _Between(NamedTuple):
    """Two neighbouring extremals, (3,) float64 each: running time, energy and multiplier."""

    first: NDArray[np.float64]
    second: NDArray[np.float64]


@leaf
def _astray(ends, samples, i):
    """How much larger the share of a sample is than that foretold for its running time."""
    return samples[i, 0] - _foretell(ends.first, ends.second, samples[i, 1]).share


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
    return _foretell(ends.first, ends.second, time_s).share + correction


@part
def _meet(train, tables, course, ends, known, target_s, tolerance_s, scratch, rows, run):
    """Drive blends until one takes the target time; returns its rows, known samples, runs, and whether it is met.

    The first ones are foretold, the others follow the Illinois rule. ``run`` gets running time, energy, and the bracket
    of shares that is left, from its third entry on.
    """
    samples = scratch.samples
    at = 1
    while at < known - 1 and samples[at, 1] < target_s:
        at += 1
    bracket = Bracket(samples[at - 1, 0], samples[at, 0], samples[at - 1, 1] - target_s, samples[at, 1] - target_s, 0)
    bracketed = bracket.f_lo < 0.0 < bracket.f_hi
    share = bracket.lo if bracket.f_lo >= 0.0 else bracket.hi
    span_s = ends.second[0] - ends.first[0]
    runs = 0
    while True:
        if bracketed:
            share = secant(bracket)
            foretold = _foretold_share(ends, samples, known, at, target_s)
            if ends.first[2] < math.inf and runs < _FORETOLD_RUNS and bracket.lo < foretold < bracket.hi:
                share = foretold
        n, time, energy = drive_blend(train, tables, course, scratch.blend, share, scratch.march, scratch.passed, rows)
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


@part
def _drive_all(train, tables, course, start_w, policies, passed, rows, scratch, runs):
    """Drive policies one after the other; the first four columns of their runs are filled in."""
    for i in range(policies.shape[0]):
        policy = policies[i]
        run = runs[i]
        rows.x[0] = 0.0
        rows.w[0] = start_w
        blend = Blend(policy, policy, policy, policy)
        n, run[2], run[3] = drive_blend(train, tables, course, blend, 0.0, scratch.march, passed[i], rows)
        if n < 0:
            return i, NO_ROOM, i + 1
        run[1] = n
    return policies.shape[0], OK, policies.shape[0]


@part
def _resumable(resumed, first, i, second, samples, faster_j):
    """The target to go on with in other room: the first between two extremals, unless that was the first of all."""
    if first > 0 or i == 0:
        return first
    resumed[0], resumed[1], resumed[2] = second, samples, faster_j
    return i


@entry
def drive(
    train, tables, course, start_w, policies, passed, known, losses, base_j, targets, tolerance_s, rows, scratch,
    runs,
):  # fmt: skip
    """Drive through the whole trip: policies one after the other, or blends of two that take given times.

    Both in one kernel, for most of it is what drives.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        Of which only the two factors count.
    course : Course
        Without policies and targets its rides are found, and no more.
    start_w : float
        Squared speed at the origin.
    policies : (m, K + 1, 4) float64
        Those to drive, each in place of the one before it; or, where targets are given, those of the extremals.
    passed : (m, K + 1, 3) float64, modified in place
        Squared speed, running time and energy of each policy at each station.
    known : (m, 3) float64
        Running times, energies and multipliers of the extremals, in order.
    losses : (m,) float64
        A run between an extremal and the one before it may cost more than the cubic through the two promises by this
        share of its energy, and less by `CHEAPER` times that,
    base_j : float
        but of no less than so much, and no more than a faster one; an infinite loss refuses no run, nor does an
        infinite multiplier of the first extremal.
    targets : (n,) float64
        Increasing running times that are wanted, s.
    tolerance_s : float
        How well.
    rows : Rows, modified in place
        Rows of the runs: positions from the origin, squared speeds.
    scratch : Scratch
    runs : (m or n, 8) float64, modified in place
        `RUN_COLUMNS` of each policy's or target's run; of a time that is not met, the run next to it. The last column
        is OK, NOT_MET, NOT_KEPT, or NOT_TRIED where an earlier target between the same extremals was not kept.

    Returns
    -------
    done : int
        Policies done before the kernel ended; or targets: all or none of those between the same extremals, but where
        they are the first ones, and too many for the room. So nothing depends on how much room there is.
    status : int
        OK, or why it ended: NO_ROOM for the next ones, or NOT_MET by the last target done, whose ``scratch.blend``
        stands. Targets between the same extremals are not tried then.
    driven : int
        Number of runs.
    """
    if course.stays[0] < 0:
        find_rides(train, tables, course)
    if targets.shape[0] == 0:
        return _drive_all(train, tables, course, start_w, policies, passed, rows, scratch, runs)
    resumed = scratch.resumed
    second = int(resumed[0])
    samples = int(resumed[1])
    faster_j = resumed[2]
    resumed[0] = -1.0
    first = driven = stored = 0
    kept = True
    for i in range(targets.shape[0]):
        at = max(second, min(1, known.shape[0] - 1))
        while at < known.shape[0] - 1 and known[at, 0] < targets[i]:
            at += 1
        ends = _Between(known[max(at - 1, 0)], known[at])
        if at != second:
            second = at
            fill_blend(train, course.cells, known, policies, second, course.fast, scratch.blend)
            scratch.samples[0, 0], scratch.samples[0, 1] = 0.0, ends.first[0]
            scratch.samples[1, 0], scratch.samples[1, 1] = 1.0, ends.second[0]
            samples = 2
            faster_j = ends.first[1]
            kept = True
            first = i
        run = runs[i]
        run[7] = NOT_TRIED
        if not kept:
            continue
        if stored >= rows.x.shape[0]:
            return _resumable(resumed, first, i, second, samples, faster_j), NO_ROOM, driven
        free = Rows(rows.x[stored:], rows.w[stored:])
        free.x[0] = 0.0
        free.w[0] = start_w
        n, samples, tried, met = _meet(
            train, tables, course, ends, samples, targets[i], tolerance_s, scratch, free, run
        )
        driven += tried
        if n < 0:
            return _resumable(resumed, first, i, second, samples, faster_j), NO_ROOM, driven
        if not met:
            run[7] = NOT_MET
            return i + 1, NOT_MET, driven
        foretold = _foretell(ends.first, ends.second, run[2])
        run[4] = foretold.multiplier
        loss_j = losses[second] * max(run[3], base_j)
        judged = ends.first[2] < math.inf and loss_j < math.inf
        told = -CHEAPER * loss_j <= run[3] - foretold.energy_j <= loss_j
        kept = not judged or (told and run[3] <= faster_j)
        run[7] = OK if kept else NOT_KEPT
        faster_j = run[3]
        run[0] = stored
        run[1] = stored + n
        if kept:
            stored += n
    return targets.shape[0], OK, driven
