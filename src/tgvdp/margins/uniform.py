"""The uniform margin: the least energy of all runs that keep near the linear one.

Between any two points the train takes the linear margin's time to within a share x. That is to say of the speed
anywhere: v_linear/(1 + x) ≤ v ≤ v_linear/(1 − x), a corridor around the linear run, which is searched by the dynamic
programs of the generic refinement (`methods.refine`). Time is met by blends of runs, which stay in the corridor.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.margins.curve import Curve, blended
from tgvdp.margins.parts import Part, met
from tgvdp.methods.budget import Clock
from tgvdp.methods.refine.convex_map import relaxed_tables
from tgvdp.methods.refine.mesh import HALF, Level, mesh_for
from tgvdp.physics.energy import energy_tables
from tgvdp.runs.fastest import fastest_run

_Floats = NDArray[np.float64]

#: Cells are so many times as fine as those of the front method, as the refinement's are; twice as fine where the linear
#: run bends within them by more than this share of the corridor, this far at most.
_FINENESS, _BEND, _FINEST = 2.5, 0.1, 5.0
#: The first and the last step between the speeds to choose from, as shares of the corridor's width.
_FIRST_STEP, _LAST_STEP = 0.25, 0.01
#: Corridors are widened from the linear run on by so much at a time, each searched from the run of the one before: wide
#: ones have several runs that nothing near is better than.
_WIDENED = 0.02
#: The first multiplier is the usual one; it is changed by this factor until there are times on both sides, and then
#: divided until it is known to the other factor, with so many solutions at most: blends do the rest.
_MARCH, _KNOWN, _MOST = 4.0, 1.2, 16


def uniform_run(part: Part, linear: Curve, within: float, clock: Clock) -> Curve:
    """Run of a part by the uniform margin.

    Parameters
    ----------
    part : Part
    linear : Curve
        Its run by the linear margin.
    within : float
        How far times between any two points may be from the linear ones, as a share of them.
    clock : Clock

    Raises
    ------
    OutOfTime
        When the time is up.
    """
    if linear is part.base:
        return linear
    try:
        level, linear_w, multiplier = _corridor(part, linear, within)
    except InfeasibleError:  # rounding keeps the mesh from a speed at its end that full traction only just gives
        return linear
    tables = relaxed_tables(part.trip.train, energy_tables(part.trip.train, part.trip.energy))
    start = level.blend(linear_w, linear_w, 0.0)
    if math.isinf(level.measured(tables, start)[1]):  # the linear run itself cannot be driven
        return linear
    level.low, level.fast = np.minimum(level.low, start), np.maximum(level.fast, start)
    width = float((level.fast - level.low).max()) / level.top_w
    if width == 0.0:  # no mesh follows the linear run so closely
        return linear

    corridors = _widening(level, start, within)

    def driven(w: _Floats) -> Curve:
        return part.driven(Curve(level.cells.station_m, w))

    def solved(multiplier: float) -> tuple[float, _Floats]:
        w = start.copy()
        for share, level.low, level.fast in corridors:
            step = share * width
            level.descend(tables, multiplier, w, HALF, _FIRST_STEP * step, _LAST_STEP * step, clock)
        return driven(w).duration_s, w

    around = _around(part.time_s, multiplier, solved)
    if around is None:
        return linear
    faster, slower = around

    return met(part, lambda share: driven(level.blend(faster, slower, share)), 0.0, 1.0, blended)


def _widening(level: Level, start: _Floats, within: float) -> list[tuple[float, _Floats, _Floats]]:
    """Shares of a corridor's width around a run, and its bounds there, from narrow to whole."""
    shares = np.linspace(0.0, 1.0, max(math.ceil(within / _WIDENED), 1) + 1)[1:-1].tolist()
    narrower = [(one, start + one * (level.low - start), start + one * (level.fast - start)) for one in shares]
    return [*narrower, (1.0, level.low, level.fast)]


def _around(
    time_s: float, multiplier: float, solved: Callable[[float], tuple[float, _Floats]]
) -> tuple[_Floats, _Floats] | None:
    """Runs of least energy that are a little faster and slower than a time; None where running slower saves nothing."""
    low, high = 0.0, math.inf
    faster, slower = np.empty(0), np.empty(0)
    for _ in range(_MOST):
        own_s, w = solved(multiplier)
        if own_s >= time_s:
            low, slower = multiplier, w
        else:
            high, faster = multiplier, w
        if high <= _KNOWN * low:
            break
        multiplier = high / _MARCH if low == 0.0 else min(math.sqrt(low * high), _MARCH * low)
    return (faster, slower) if low > 0.0 and high < math.inf else None


def _corridor(part: Part, linear: Curve, within: float) -> tuple[Level, _Floats, float]:
    """A mesh whose speeds are those of the corridor, the linear run on it, v², and the usual multiplier, J/s.

    Between two stations runs and the linear one are both taken as straight; what that leaves out of the latter is taken
    off the corridor.
    """
    fastest = fastest_run(part.trip)
    fineness = _FINENESS
    while True:
        mesh = mesh_for(part.trip, fastest, fineness)
        x_m = mesh.cells.station_m
        linear_w = np.interp(x_m, *linear)
        inside = (linear.x_m > 0.0) & (linear.x_m < x_m[-1])
        taken_w = np.interp(linear.x_m[inside], x_m, linear_w)
        bend = float(np.abs(np.sqrt(linear.w[inside] / taken_w) - 1.0).max(initial=0.0))
        if bend <= _BEND * within or fineness >= _FINEST:
            break
        fineness *= 2.0
    own = max((within - bend) / (1.0 + bend), 0.0)
    level = Level(part.trip, mesh.train, mesh.cells)
    level.low = np.minimum(np.maximum(level.low, linear_w / (1.0 + own) ** 2), linear_w)
    level.fast = np.maximum(np.minimum(level.fast, linear_w / (1.0 - own) ** 2), linear_w)
    for bound in (level.low, level.fast):
        bound[[0, -1]] = linear_w[[0, -1]]
    return level, linear_w, mesh.usual_multiplier
