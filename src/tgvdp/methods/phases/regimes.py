"""Regimes of rows: what a row does to two per cent of its limit, and how regimes follow each other in effort."""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.methods.phases.way import cell_from, measure, measure_row, train_in
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.cell import is_row_of
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, HOLDING, TRACTION
from tgvdp.physics.forces import mean_brake, mean_effort, mean_resistance, resistance_at

#: An effort above this share of its limit is the limit.
_FULL = 0.98


@part
def regime_of_row(way, k, d, w0, w1):
    """Regime of a row; partial effort is `HOLDING`, be it at a speed that drifts."""
    work = duration_and_work(train_in(way, k), d, way.cells.grade_n[k], way.cells.air[k], w0, w1)[1]
    return _regime_of(way, k, work / d, d, w0, w1)


@leaf
def _regime_of(way, k, effort, d, w0, w1):
    """Regime of a row of a mean effort."""
    train = train_in(way, k)
    if abs(effort) <= way.little_n:
        return COASTING
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    if effort > 0.0:
        capped = w1 - w0 >= 2.0 * _FULL * d * train.max_acceleration
        return TRACTION if capped or effort >= _FULL * mean_effort(train.traction, v0, v1) else HOLDING
    capped = w0 - w1 >= 2.0 * _FULL * d * train.max_deceleration
    load = mean_resistance(train, way.cells.air[k], v0, v1) + way.cells.grade_n[k]
    if capped or -effort >= _FULL * mean_brake(train, load, v0, v1):
        return BRAKING
    dynamic = mean_effort(train.braking, v0, v1)
    return DYNAMIC if _FULL * dynamic <= -effort <= dynamic / _FULL else HOLDING


@kernel
def tell_regimes(way, runs, before, first, last):
    """Fill in the regime, running time and energy of each row of a run, ``first`` to ``last`` − 1.

    Those of rows that it has in common with another run, ``before`` to ``first`` − 2, are known.
    """
    k = 0
    g = before
    for j in range(first, last):
        while g < first - 1 and runs.x[g] < runs.x[j]:
            g += 1
        if g < first - 1 and is_row_of(runs, j, runs, g):
            runs.regime[j] = runs.regime[g]
            runs.time[j] = runs.time[g]
            runs.energy[j] = runs.energy[g]
            continue
        k = cell_from(way.cells, k, runs.x[j])
        effort = measure_row(way, k, runs, j)
        runs.regime[j] = _regime_of(way, k, effort, runs.x[j + 1] - runs.x[j], runs.w[j], runs.w[j + 1])


@leaf
def pull(way, k, regime, w):
    """Rank of a regime by its effort in a cell; to hold a speed takes more or less than to coast."""
    if regime == TRACTION:
        return 4
    if regime == HOLDING:
        load = resistance_at(way.train, way.cells.air[k], math.sqrt(w)) + way.cells.grade_n[k]
        return 3 if load > 0.0 else 1
    return 2 if regime == COASTING else 0 if regime == DYNAMIC else -1


@kernel
def without_touches(way, run, n):
    """Spread rows that follow coasting over the row before them where next to no effort is left then.

    A train that coasts up to a limit holds it for a hand's breadth, as no switch is so exact. Rows stay within cells.
    Returns the number of rows.
    """
    x = run.x
    w = run.w
    m = 1
    k = 0
    for i in range(1, n):
        if m < i:
            x[m] = x[i]
            w[m] = w[i]
            run.regime[m - 1] = run.regime[i - 1]
            run.time[m - 1] = run.time[i - 1]
            run.energy[m - 1] = run.energy[i - 1]
        m += 1
        if m == 2 or run.regime[m - 2] == COASTING or run.regime[m - 3] != COASTING:
            continue
        k = cell_from(way.cells, k, x[m - 2])
        if x[m - 3] >= way.cells.station_m[k]:
            d = x[m - 1] - x[m - 3]
            if regime_of_row(way, k, d, w[m - 3], w[m - 1]) == COASTING:
                m -= 1
                x[m - 1] = x[i]
                w[m - 1] = w[i]
                run.regime[m - 2] = COASTING
                measure(way, run, m - 2, m - 1)
    return m
