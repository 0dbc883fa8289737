"""A run in phases: its cells labelled by regime.

The regimes are ordered by the costate p that they go with (per unit of inertia; a = 1/η_t the price of traction work,
η = η_r what a joule of dynamic braking returns; at the wheel a = 1, η = 0):

    traction  −a/2  coasting  −η/2  regeneration  0  full braking

At the levels between them effort may be partial: holding by traction, held back by the dynamic brake, or by friction.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import NOT_MERGED, load_in, merged_in, piece_at, piece_value, price_in
from tgvdp.line.cells import Cells
from tgvdp.physics.codes import (
    BRAKING,
    COASTING,
    DYNAMIC,
    DYNAMIC_BRAKING,
    HELD_BACK,
    HOLDING,
    RETARDED,
    TRACTION,
)
from tgvdp.physics.forces import mean_resistance

#: Place of each regime of `physics.codes` in that order.
_ORDER = (0, 1, 2, 6, 4, 3, 5, 7)

#: Effort above this share of its limit counts as full.
_FULL_SHARE = 0.97
#: Effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4
#: Relative distance of w from the limit within which a run touches it.
TOUCH = 1e-4
#: Relative change of w in a cell below which the speed is kept.
_STEADY = 1e-6
#: Relative difference of λ/(2v³) and ∂ρ/∂w above which a speed is not the optimal holding speed.
_OFF_HOLDING = 0.05
#: Partial effort below the limit over which p would change by less than this is none.
_NO_DRIFT = 3e-3
#: Another regime for less than this share of the cells before and after it, which are of the same one, is none.
_MOMENT = 0.05


class LabelledRun(NamedTuple):
    """A run in cells, and the equation of its costate in each.

    Attributes
    ----------
    cells : Cells
    w : (K + 1,) float64
        Squared speed at the ends of the cells, m²/s².
    effort : (K,) float64
        Mean effort of the row that a cell belongs to, per unit of inertia.
    multiplier : float
        λ per unit of inertia.
    hold, retard : float
        The levels −a/2 and −η/2 of p.
    label : (K,) int8
        Regimes.
    source, growth : (K, 4) float64
        Coefficients of p' = source + growth·p: one column each for traction, coasting, regeneration and braking.
    """

    cells: Cells
    w: NDArray[np.float64]
    effort: NDArray[np.float64]
    multiplier: float
    hold: float
    retard: float
    label: NDArray[np.int8]
    source: NDArray[np.float64]
    growth: NDArray[np.float64]


@leaf
def is_standstill(end_w, next_w):
    """Whether the cell at an end of a trip holds a (near) standstill: no other cell spans such a ratio of speeds."""
    return end_w < 0.5 * next_w


@leaf
def is_partial(label):
    """Whether effort is partial: p keeps one level."""
    return label in (HOLDING, RETARDED, HELD_BACK)


@leaf
def order_of(label):
    """Place of a regime in the order of its costates."""
    return _ORDER[label]


@leaf
def lowest_costate(run, label):
    """Lowest p of a regime."""
    if label == TRACTION:
        return -math.inf
    if label in (HOLDING, COASTING):
        return run.hold
    return 0.0 if label in (HELD_BACK, BRAKING) else run.retard


@leaf
def highest_costate(run, label):
    """Highest p of a regime."""
    if label in (TRACTION, HOLDING):
        return run.hold
    if label in (COASTING, RETARDED):
        return run.retard
    return 0.0 if label in (DYNAMIC, HELD_BACK) else math.inf


@kernel
def row_efforts(train, x, w, grade, air, effort):
    """Mean effort of each row in N, positive traction; ``effort`` (n − 1,) in place."""
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        load = mean_resistance(train, air[i], math.sqrt(w[i]), math.sqrt(w[i + 1])) + grade[i]
        effort[i] = 0.5 * train.inertia_kg * (w[i + 1] - w[i]) / d + load


@leaf
def _by_w(pieces, n, v, m1, m3):
    """Derivative by w of a table of pieces, averaged over a cell: ``m1``, ``m3`` are the means of 1/v and 1/v³."""
    i = piece_at(pieces, n, v)
    return -0.5 * pieces[i, 1] * m3 + 0.5 * pieces[i, 3] * m1 + pieces[i, 4] + 1.5 * pieces[i, 5] * v


@leaf
def _regime(effort, v, no_effort, regeneration, pieces, merged):
    """Regime that a mean effort per unit of inertia at speed v belongs to."""
    _, pulls, brakes, dynamics = merged
    if abs(effort) <= no_effort:
        return COASTING
    if effort > 0.0:
        return TRACTION if effort >= _FULL_SHARE * piece_value(pieces[0], piece_at(pieces[0], pulls, v), v) else HOLDING
    most = piece_value(pieces[1], piece_at(pieces[1], brakes, v), v)
    full = -effort >= _FULL_SHARE * most
    if regeneration == 0.0:
        return BRAKING if full else HELD_BACK
    returned = piece_value(pieces[2], piece_at(pieces[2], dynamics, v), v)
    if full:
        return DYNAMIC_BRAKING if returned >= _FULL_SHARE * most else BRAKING
    if -effort < _FULL_SHARE * returned:
        return RETARDED
    return DYNAMIC if -effort * _FULL_SHARE <= returned else HELD_BACK


@kernel
def label_cells(train, tables, run, top_v, pieces):
    """Label the cells of a run by regime, with the coefficients of p' = source + growth·p in it; in place.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
    run : LabelledRun, modified in place
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 3n, 6) float64
        Scratch for the pieces of the effort curves.
    """
    label, source, growth = run.label, run.source, run.growth
    w = run.w
    no_effort = _NO_EFFORT * train.traction[0, 2] / train.inertia_kg
    merged = NOT_MERGED
    for k in range(label.shape[0]):
        load = load_in(train, run.cells, k)
        merged = merged_in(train, run.cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        v0 = math.sqrt(w[k])
        v1 = math.sqrt(w[k + 1])
        v = 0.5 * (v0 + v1)
        label[k] = _regime(run.effort[k], v, no_effort, tables.regeneration, pieces, merged)
        if v0 <= 0.0 or v1 <= 0.0:
            continue  # cells at a standstill have no costate
        m1 = 1.0 / v
        m3 = 1.0 / (v0 * v1 * v)
        price = price_in(train, run.cells, k, run.multiplier)
        load_w = 0.5 * load.r1 * m1 + load.r2
        pull_w = _by_w(pieces[0], pulls, v, m1, m3)
        brake_w = _by_w(pieces[1], brakes, v, m1, m3)
        dynamic_w = _by_w(pieces[2], dynamics, v, m1, m3)
        for j in range(4):
            source[k, j] = 0.5 * price * m3
            growth[k, j] = 2.0 * load_w
        source[k, 0] -= tables.traction * pull_w
        growth[k, 0] -= 2.0 * pull_w
        source[k, 2] += tables.regeneration * dynamic_w
        growth[k, 2] += 2.0 * dynamic_w
        source[k, 3] += tables.regeneration * dynamic_w
        growth[k, 3] += 2.0 * brake_w


@kernel
def tidy_labels(run, sliver, moment_s, bound_w):
    """Give cells that no optimal run could have the label of a neighbour; in place.

    Such are phases shorter than ``sliver`` metres or ``moment_s`` seconds, or much shorter than the cells around it if
    these are of one regime, and partial effort away from both the limit and the optimal holding speed, at which p' = 0
    whatever the gradient: the run only steps from one switching speed to the next. The limit, along which both ends of
    a cell must lie, is that of the cell, or where a run keeps a speed ``bound_w``, (K,): where effort drops it goes no
    faster. A speed that is kept by friction on top of the whole dynamic brake is optimal where that returns most energy
    for the time.
    """
    label, source, growth = run.label, run.source, run.growth
    w = run.w
    cap = run.cells.limit_w
    length = run.cells.length_m
    count = label.shape[0]
    for sweep in range(2):
        k = 0
        while k < count:
            last = k
            span = 0.0
            lasts_s = 0.0
            drift = 0.0
            scale = 0.0
            free = is_partial(label[k])
            level = run.hold if label[k] == HOLDING else (run.retard if label[k] == RETARDED else 0.0)
            while last < count and label[last] == label[k]:
                span += length[last]
                lasts_s += 2.0 * length[last] / (math.sqrt(w[last]) + math.sqrt(w[last + 1]))
                drift += (source[last, 1] + level * growth[last, 1]) * length[last]
                scale += source[last, 1] * length[last]
                free = free and min(w[last], w[last + 1]) < cap[last] * (1.0 - TOUCH)
                steady = abs(w[last + 1] - w[last]) <= _STEADY * w[last]
                free = free and not (steady and (w[last] > bound_w[last] * (1.0 - TOUCH) or label[k] == HELD_BACK))
                last += 1
            short = span <= sliver or lasts_s < moment_s
            if k > 0 and last < count and label[k - 1] == label[last]:
                short = short or span < _MOMENT * (length[k - 1] + length[last])
            if sweep == 1:
                short = free and (scale < _NO_DRIFT or abs(drift) > _OFF_HOLDING * scale)
            if short:
                neighbour = label[k - 1] if k > 0 else (label[last] if last < count else label[k])
                for j in range(k, last):
                    label[j] = neighbour
            k = last


@leaf
def slides(run, k):
    """Whether the run keeps the limit all along a cell."""
    top = run.cells.limit_w[k] * (1.0 - TOUCH)
    return run.w[k] >= top and run.w[k + 1] >= top


@leaf
def goes_on(before, after):
    """Whether a phase goes on in another cell: in one regime, or where only what the brakes can do changes."""
    return before == after or (max(before, after) == DYNAMIC_BRAKING and min(before, after) in (DYNAMIC, BRAKING))


@kernel
def phase_end(run, k):
    """First cell after the phase of cell k: another regime, or the run meets or leaves the limit there."""
    label = run.label
    w = run.w
    cap = run.cells.limit_w
    j = k + 1
    while j < label.shape[0] and goes_on(label[j - 1], label[j]):
        touches = w[j] >= min(cap[j - 1], cap[j]) * (1.0 - TOUCH)
        peak = w[j] >= w[j - 1] and w[j] >= w[j + 1] and (w[j] > w[j - 1] or w[j] > w[j + 1])
        meets_drop = label[k] == COASTING and cap[j] < cap[j - 1] and w[j] < w[j - 1]
        if not is_partial(label[k]) and touches and (peak or meets_drop):
            break
        j += 1
    return j
