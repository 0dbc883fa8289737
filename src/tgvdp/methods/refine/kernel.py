"""Kernels of the generic refinement: what a run takes and draws, the fastest and the slowest run, blends of two.

Everything here works on one arc of constant acceleration per cell, so that a run is one squared speed per station and
any run in which each arc passes the one feasibility test is a run that the train can drive.
"""

from tgvdp._jit import kernel
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.physics.arc import arc
from tgvdp.physics.cell import cell_at
from tgvdp.physics.codes import (
    BRAKING,
    OK,
    OVER_ACCELERATION,
    OVER_BRAKE,
    OVER_DECELERATION,
    OVER_TRACTION,
    TRACTION,
)
from tgvdp.physics.energy import arc_energy
from tgvdp.physics.forces import unpowered
from tgvdp.physics.motion import land

#: A landing that rounding has put outside the limits is moved in by this share of w first, and four times more each
#: time after that, so often at most.
_NUDGE = 1e-14
_NUDGES = 16


@kernel
def measure(train, tables, cells, w):
    """Running time in s and energy in J of a run, and whether each of its arcs is feasible."""
    time = 0.0
    energy = 0.0
    feasible = True
    dark = unpowered(train)
    for k in range(cells.length_m.shape[0]):
        here = train if cells.supply[k] == POWERED else dark
        status, duration, work = arc(here, cells.length_m[k], cells.grade_n[k], cells.air[k], w[k], w[k + 1])
        feasible = feasible and status == OK
        time += duration
        if cells.supply[k] != LOWERED:
            energy += arc_energy(here, tables, cells.length_m[k], duration, work, w[k], w[k + 1])
    return time, energy, feasible


@kernel
def _landed(train, regime, cell, w):
    """Largest squared speed after the cell from w (traction), or before the cell to reach w (braking), by one arc."""
    sign = 1.0 if regime == TRACTION else -1.0
    x = land(train, regime, sign, cell, cell.length_m, w)
    nudge = _NUDGE
    for _ in range(_NUDGES):
        w0, w1 = (w, x) if regime == TRACTION else (x, w)
        if arc(train, cell.length_m, cell.grade_n, cell.air, w0, w1)[0] == OK:
            break
        x *= 1.0 - nudge
        nudge *= 4.0
    return x


@kernel
def envelope_kernel(train, cells, start_w, end_w, low, fast):
    """Slowest and fastest squared speed at each station with one arc per cell; ``low``, ``fast`` (K + 1,) in place."""
    count = cells.length_m.shape[0]
    dark = unpowered(train)
    fast[count] = min(end_w, cells.limit_w[count - 1])
    for k in range(count - 1, -1, -1):
        here = train if cells.supply[k] == POWERED else dark
        top = cells.limit_w[k] if k == 0 else min(cells.limit_w[k], cells.limit_w[k - 1])
        fast[k] = min(top, _landed(here, BRAKING, cell_at(cells, k), fast[k + 1]))
    fast[0] = min(fast[0], start_w)
    for k in range(count):
        here = train if cells.supply[k] == POWERED else dark
        fast[k + 1] = min(fast[k + 1], _landed(here, TRACTION, cell_at(cells, k), fast[k]))
    low[count] = fast[count]
    for k in range(count - 1, 0, -1):
        here = train if cells.supply[k] == POWERED else dark
        low[k] = min(land(here, TRACTION, -1.0, cell_at(cells, k), cells.length_m[k], low[k + 1]), fast[k])
    low[0] = fast[0]


@kernel
def blend(train, cells, low, fast, first, second, share, w):
    """Blend two runs into w: (1 − share)·first + share·second, cut where full effort does not suffice for it.

    The effort limits of a power-limited train are not convex in w, so that a blend of two runs at full effort asks for
    a little more than that. Cutting never takes it below the slower of the two.
    """
    count = cells.length_m.shape[0]
    dark = unpowered(train)
    for k in range(count + 1):
        w[k] = max(min(first[k] + share * (second[k] - first[k]), fast[k]), low[k])
    for k in range(count - 1, 0, -1):
        here = train if cells.supply[k] == POWERED else dark
        status = arc(here, cells.length_m[k], cells.grade_n[k], cells.air[k], w[k], w[k + 1])[0]
        if status in (OVER_BRAKE, OVER_DECELERATION):
            w[k] = min(w[k], _landed(here, BRAKING, cell_at(cells, k), w[k + 1]))
    for k in range(count - 1):
        here = train if cells.supply[k] == POWERED else dark
        status = arc(here, cells.length_m[k], cells.grade_n[k], cells.air[k], w[k], w[k + 1])[0]
        if status in (OVER_TRACTION, OVER_ACCELERATION):
            w[k + 1] = min(w[k + 1], _landed(here, TRACTION, cell_at(cells, k), w[k]))
