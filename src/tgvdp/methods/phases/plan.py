"""Plans: the phases of a run, one after the other, without those that are too short to drive."""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.phases.way import cell_from, row_at
from tgvdp.model.track import POWERED
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import HOLDING
from tgvdp.physics.motion import net_force_at

#: Columns of a plan, (n, 6): regime, where it begins in m, squared speed there, seconds it lasts, whether it may be
#: left out, and whether the run slows down before it.
REGIME, AT, START_W, LASTS_S, MAY_GO, FROM_ABOVE = range(6)
PLAN_COLUMNS = 6


@part
def acceleration(way, k, regime, w):
    """Acceleration in a regime, m/s²; none where a speed is held."""
    if regime == HOLDING:
        return 0.0
    v = math.sqrt(w)
    cell = Cell(0.0, 0.0, 0.0, way.cells.grade_n[k], way.cells.air[k], math.inf)
    return net_force_at(way.train, regime, cell, v) / way.train.inertia_kg


@part
def _balance(way, plan, i):
    """Share of a phase's length that its first neighbour may take so that the speed after it stays what it was."""
    cells = way.cells
    k = row_at(cells.station_m, cells.station_m.shape[0], plan[i, AT])
    before = acceleration(way, k, int(plan[i - 1, REGIME]), plan[i, START_W])
    after = acceleration(way, k, int(plan[i + 1, REGIME]), plan[i + 1, START_W])
    if plan[i + 1, AT] <= plan[i, AT] or before == after:
        return 0.5
    own = 0.5 * (plan[i + 1, START_W] - plan[i, START_W]) / (plan[i + 1, AT] - plan[i, AT])
    return min(max((own - after) / (before - after), 0.0), 1.0)


@part
def _drop(plan, count, at, how_many):
    """Take phases out of a plan; returns the number of those that are left."""
    for i in range(at, count - how_many):
        for column in range(PLAN_COLUMNS):
            plan[i, column] = plan[i + how_many, column]
    return count - how_many


@kernel
def plan_of(way, run, n, plan):
    """Phases of a run; −1 if there is no room for them.

    Parameters
    ----------
    way : Way
    run : Run
        Of ``n`` rows.
    plan : (size, PLAN_COLUMNS) float64, modified in place
        What is without current may not be left out: it is no choice.
    """
    count = 0
    k = 0
    regime = -1
    has_power = had_power = True
    lasts_s = 0.0
    for i in range(n - 1):
        if not way.has_power:
            k = cell_from(way.cells, k, run.x[i])
            has_power = way.cells.supply[k] == POWERED
        if run.regime[i] != regime or has_power != had_power:
            if count == plan.shape[0]:
                return -1
            if count > 0:
                plan[count - 1, LASTS_S] = lasts_s
            regime = run.regime[i]
            had_power = has_power
            lasts_s = 0.0
            plan[count, REGIME] = regime
            plan[count, AT] = run.x[i]
            plan[count, START_W] = run.w[i]
            plan[count, MAY_GO] = 1.0 if has_power else 0.0
            plan[count, FROM_ABOVE] = 1.0 if i > 0 and run.w[i - 1] > run.w[i] else 0.0
            count += 1
        lasts_s += run.time[i]
    if count > 0:
        plan[count - 1, LASTS_S] = lasts_s
    return count


@part
def shortest(plan, count, least_s):
    """The shortest phase of those that may be left out and are shorter than ``least_s``; −1 if there is none.

    The last one may not: it brings the train to the speed at which it must end.
    """
    least = -1
    for i in range(count - 1):
        short = plan[i, LASTS_S] < least_s and plan[i, MAY_GO] > 0.0
        if short and (least < 0 or plan[i, LASTS_S] < plan[least, LASTS_S]):
            least = i
    return least


@part
def leave_out(way, plan, count, least_s):
    """Leave phases shorter than ``least_s`` out of a plan, the shortest first; returns the number of the others.

    One between two of the same regime becomes part of them; another is shared by its neighbours.
    """
    while count > 1:
        i = shortest(plan, count, least_s)
        if i < 0:
            break
        if i == 0:
            plan[1, AT] = plan[0, AT]
            plan[1, START_W] = plan[0, START_W]
            plan[1, LASTS_S] += plan[0, LASTS_S]
            count = _drop(plan, count, 0, 1)
        elif plan[i - 1, REGIME] == plan[i + 1, REGIME]:
            plan[i - 1, LASTS_S] += plan[i, LASTS_S] + plan[i + 1, LASTS_S]
            count = _drop(plan, count, i, 2)
        else:
            first = _balance(way, plan, i)
            plan[i + 1, AT] = plan[i, AT] + first * (plan[i + 1, AT] - plan[i, AT])
            plan[i - 1, LASTS_S] += first * plan[i, LASTS_S]
            plan[i + 1, LASTS_S] += (1.0 - first) * plan[i, LASTS_S]
            count = _drop(plan, count, i, 1)
    return count
