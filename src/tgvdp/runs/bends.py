"""Rows along which motion bends, cut so that a run's time is that of its motion.

A row has one acceleration, while under one effort a train gains speed ever more slowly. So a row is passed sooner or
later than it says, by some 10⁻⁶ of its time where a search drives: that is nothing on a section of a metro, and some
milliseconds on an hour's run.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, leaf, part
from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import ResolvedLine
from tgvdp.line.walk import piece_from
from tgvdp.model.train import Train
from tgvdp.physics.cell import Rows, is_row_of
from tgvdp.physics.energy import follows_dynamic
from tgvdp.physics.forces import (
    brake_at,
    effort_at,
    kernel_train,
    mean_brake,
    mean_effort,
    mean_resistance,
    resistance_at,
)
from tgvdp.runs.batch import Batch
from tgvdp.runs.effort_jumps import NO_EFFORT
from tgvdp.runs.resistance_correction_kernel import (
    NEARLY_FULL,
    append_parts,
    drag_change,
    follows_traction,
    is_bound,
    is_comfort,
    passes,
)

#: How far the time of a run may be off, s; and by what is worth this share of its energy at most, as far as rows can
#: tell: next to the fastest run, or to one that brakes from its start on, half a millisecond may be worth 0.1 %.
MOST_S = 5e-4
_WORTH = 1e-4
_LEAST_S = 1e-5
#: How many times as many rows a search drives as motion makes on its own (`KernelTrain.rows`): usual ones, cut on long
#: runs only, and rougher ones, which are cut anyway; by at most this share of their time, over the square of it, are
#: they off.
USUAL_ROWS = 4.0
_ROUGH_ROWS = 2.0
_OFF = 7.5e-5
#: ... by twice as much where a strong train is at its top speed within a minute: so from there on rows are cut.
_CUT_FROM_S = 60.0
#: What bends by more than this share of its change is no parabola: a speed that is held.
_MOST_BENT = 0.5
#: Rows that one is cut into at most.
_MOST_PARTS = 64
#: Rows that are passed sooner than they say make up for others that are passed later: together they may be off by so
#: many times as much as the run, which on its way is off by three quarters of that at most.
_MADE_UP = 2.0
#: Parts of a row from or to a standstill miss about so many times as much of its time as those of others: 1.7 times
#: where there are four of them, 3.1 times where there are 64.
_STANDING = 2.0
#: How often a run is cut into more parts, as numbers of parts are whole, and by how much.
_TRIES = 8
_MORE = 1.1


def allowed_off_s(energy_j: Floats, multiplier_j_per_s: Floats) -> Floats:
    """How far the time of runs may be off, s, (n,), by what energy they take, J, and save with a second more, J/s."""
    worth_j = _WORTH * energy_j
    return np.asarray(np.maximum(worth_j / np.maximum(multiplier_j_per_s, worth_j / MOST_S), _LEAST_S))


def most_off_s(time_s: float, rows: float = USUAL_ROWS) -> float:
    """By how much a run of a search may last longer once its rows are cut, s; 0 for one that is short enough."""
    return _OFF / rows**2 * time_s if time_s > _CUT_FROM_S else 0.0


def are_cut(line: ResolvedLine, time_s: Floats, most_s: Floats | float = MOST_S) -> bool:
    """Whether rows of runs of some times, s, which may be off by so much, s, (n,) both, are cut where motion bends.

    Not where the resistance changes along a row: its effort is no law to cut it by.
    """
    return line.even and bool(((time_s > _CUT_FROM_S) | (_OFF / USUAL_ROWS**2 * time_s > most_s)).any())


def enough_rows(line: ResolvedLine, time_s: float, tolerance_s: float) -> float:
    """Rows of a search for runs of a time, s, so that cutting them changes that by no more than a tolerance, s."""
    is_cut = line.even and most_off_s(time_s) > 0.0
    return _ROUGH_ROWS if is_cut and most_off_s(time_s, _ROUGH_ROWS) <= tolerance_s else USUAL_ROWS


def cut_at_bends(
    train: Train, line: ResolvedLine, runs: Batch, most_s: Floats | float = MOST_S
) -> tuple[Batch, NDArray[np.int64]]:
    """Cut rows of runs so that the time of each is right to so much, with as few cuts as that takes.

    Along a row at nearly full effort the effort keeps its share of the limit, along any other its value, but where a
    comfort limit or a braking rate is kept.

    Parameters
    ----------
    train : Train
    line : ResolvedLine
    runs : Batch
        n of them, of N rows in all.
    most_s : (n,) float64 or float
        How far the time of each may be off, s.

    Returns
    -------
    Batch
        The runs given where no row need be cut.
    parts : (N,) int64
        Into how many each of the rows given is cut; 1 for the last of each run.
    """
    known = kernel_train(train)
    parts, first, nothing = np.empty(len(runs.x_m), dtype=np.int64), np.empty_like(runs.first), np.empty((2, 0))
    scratch = np.empty((2, len(parts)))
    most_s = np.full(len(first) - 1, most_s)
    count = cut_runs(known, line, *runs, most_s, parts, scratch, nothing[0], nothing[1], first)
    if count == len(runs.x_m):
        return runs, parts
    x_m, w = np.empty((2, count))
    cut_runs(known, line, *runs, most_s, parts, nothing, x_m, w, first)
    return Batch(x_m, w, first), parts


@leaf
def _bend(train, grade, air, d, w0, w1, v0, v1):
    """How far the squared speed is above a straight line half-way along a row, (m/s)²."""
    if w0 == w1:
        return 0.0
    acceleration = 0.5 * (w1 - w0) / d
    mean = train.inertia_kg * acceleration + mean_resistance(train, air, v0, v1) + grade
    is_any = abs(mean) > NO_EFFORT * effort_at(train.traction, 0.0)  # without effort the line may do more
    if not is_any:  # drag alone, whose mean is that of its ends but for what its curvature does
        bend = 0.25 * d * (v1 - v0) * (train.davis_b + air * (v0 + v1)) / train.inertia_kg
        return bend if abs(bend) <= _MOST_BENT * abs(w1 - w0) else 0.0
    if is_comfort(train, mean, acceleration):
        return 0.0
    middle = math.sqrt(0.5 * (w0 + w1))
    load = resistance_at(train, air, middle) + grade
    effort = train.inertia_kg * acceleration + load
    # Of halves, since a row may begin or end at a drop of the effort.
    change = drag_change(train, air, v0, middle, v1)
    follows_limit = True
    if effort > 0.0:
        follows_limit = follows_traction(train, effort, effort_at(train.traction, middle), v0, v1)
        if follows_limit:
            change += mean_effort(train.traction, v0, middle) - mean_effort(train.traction, middle, v1)
    elif follows_dynamic(train, d, -effort, v0, v1):
        change += mean_effort(train.braking, middle, v1) - mean_effort(train.braking, v0, middle)
    elif train.rates.shape[0] > 0:
        if is_bound(train, effort, acceleration, middle):
            return 0.0
        follows_limit = False
    elif -effort >= NEARLY_FULL * brake_at(train, load, middle):
        change += mean_brake(train, 0.0, middle, v1) - mean_brake(train, 0.0, v0, middle)
    else:
        follows_limit = False
    differs = change / train.inertia_kg
    if follows_limit and passes(train.max_acceleration, train.max_deceleration, mean, acceleration, differs):
        return 0.0
    bend = 0.5 * d * differs
    return bend if abs(bend) <= _MOST_BENT * abs(w1 - w0) else 0.0


@leaf
def _times_missed(w0, w1):
    """How many times as much of a row's time its parts miss as those of one that does not come from a standstill."""
    return _STANDING if w0 == 0.0 or w1 == 0.0 else 1.0


@part
def _count_in_run(train, line, run, before, before_off, most_s, parts, off, size):
    """Count the parts of one run; what its rows miss is known of those that are rows of the run before."""
    x = run.x
    w = run.w
    rows = x.shape[0] - 1
    last = before.x.shape[0] - 1
    parts[:] = 1
    step = 0
    g = 0
    off_s = 0.0
    sum_s = 0.0
    for k in range(rows):
        while g < last and before.x[g] < x[k]:
            g += 1
        if g < last and is_row_of(run, k, before, g):
            off[k] = before_off[g]
        else:
            d = x[k + 1] - x[k]
            step = piece_from(line.break_m, step, 0.5 * (x[k] + x[k + 1]))
            v0 = math.sqrt(w[k])
            v1 = math.sqrt(w[k + 1])
            v = 0.5 * (v0 + v1)
            bend = _bend(train, line.grade_n[step], line.air[step], d, w[k], w[k + 1], v0, v1)
            off[k] = d * bend / (3.0 * v * v * v)
        off_s += abs(off[k])
        sum_s += off[k]
    if max(abs(sum_s), off_s / _MADE_UP) <= most_s:
        return rows + 1
    left = 0.0
    sum_left = 0.0
    for k in range(rows):
        fourth = math.sqrt(math.sqrt(abs(off[k]) * _times_missed(w[k], w[k + 1])))
        size[k] = fourth * math.sqrt(fourth)
        left += fourth
        sum_left += fourth if off[k] > 0.0 else -fourth
    per_part = math.sqrt(most_s / max(abs(sum_left), left / _MADE_UP))
    total = 1
    for _ in range(_TRIES):
        total = 1
        sum_s = 0.0
        for k in range(rows):
            parts[k] = max(1, min(_MOST_PARTS, int(size[k] / per_part + 0.5)))
            total += parts[k]
            sum_s += off[k] / (parts[k] * parts[k]) * (_times_missed(w[k], w[k + 1]) if parts[k] > 1 else 1.0)
        if abs(sum_s) <= most_s:
            break
        per_part /= _MORE
    return total


@part
def _cut_run(train, line, run, parts, before, before_parts, before_cut, cut):
    """Cut one run; rows of the run before that have as many parts are cut as they are there."""
    rows = run.x.shape[0] - 1
    last = before.x.shape[0] - 1
    step = 0
    g = 0
    m = 0  # where row g begins in what the run before is cut into
    n = 0
    for k in range(rows):
        while g < last and before.x[g] < run.x[k]:
            m += before_parts[g]
            g += 1
        if g < last and before_parts[g] == parts[k] and is_row_of(run, k, before, g):
            for i in range(parts[k]):
                cut.x[n + i] = before_cut.x[m + i]
                cut.w[n + i] = before_cut.w[m + i]
            n += parts[k]
        else:
            step, n = append_parts(train, line, step, run.x, run.w, k, parts[k], cut.x, cut.w, n)
    cut.x[n] = run.x[rows]
    cut.w[n] = run.w[rows]
    return n + 1


@entry
def cut_runs(train, line, x, w, first, most_s, parts, scratch, cut_x, cut_w, cut_first):
    """Cut the rows of runs into parts, so that no time is off by more than ``most_s``; returns how many rows there are.

    Along a row from w₀ to w₁ the squared speed differs from a straight line by δ·4u(1 − u), and its time by
    t = d·δ/(3 v³), which n parts reduce by n². The sum of these is least, for as many parts in all, where n goes with
    t^(1/3); with t^(3/8), which leaves t^(1/4) of each time and takes square roots alone, it takes next to no more.
    Driving is passed sooner than rows say, coasting later: much of it cancels.

    Neighbours of a front have half of their rows in common, bit by bit: what one of them needs is not found out again.

    Parameters
    ----------
    train : KernelTrain
    line : ResolvedLine
    x, w : (N,) float64
    first : (n + 1,) int64
    most_s : (n,) float64
    parts : (N,) int64, modified in place
        1 for the last row of a run, which ends there.
    scratch : (2, N) float64, modified in place
        Where there is none the parts are known already, and rows are cut.
    cut_x, cut_w : (M,) float64, modified in place
    cut_first : (n + 1,) int64, modified in place
    """
    known = scratch.shape[1] < x.shape[0]
    n = 0
    c = 0  # where the run before begins, which the first one has not, and what it is cut into
    m = 0
    for i in range(first.shape[0] - 1):
        a = first[i]
        b = first[i + 1]
        cut_first[i] = n
        run, before = Rows(x[a:b], w[a:b]), Rows(x[c:a], w[c:a])
        if known:
            before_cut, cut = Rows(cut_x[m:n], cut_w[m:n]), Rows(cut_x[n:], cut_w[n:])
            more = _cut_run(train, line, run, parts[a:b], before, parts[c:a], before_cut, cut)
        else:
            off, before_off = scratch[0, a:b], scratch[0, c:a]
            more = _count_in_run(train, line, run, before, before_off, most_s[i], parts[a:b], off, scratch[1, a:b])
        c = a
        m = n
        n += more
    cut_first[first.shape[0] - 1] = n
    return n
