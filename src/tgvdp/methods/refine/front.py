"""The generic refinement: the front for any energy of an arc, by discrete differential dynamic programming.

For each of a few multipliers λ the run of least E + λT is found by repeated dynamic programs over a few speeds around
an incumbent, with ever smaller steps (docs/refine.md). Between two neighbouring runs the front lies above their
tangents, so that multipliers are added only until a blend of the two is as good as any run could be.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import NumericalError
from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.methods.costate.multipliers import OutOfTime
from tgvdp.methods.refine.extremals import Extremals
from tgvdp.methods.refine.mesh import mesh_for
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.runs.batch import Batch
from tgvdp.runs.followed import Followed
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.resistance_correction import follow

#: Cells are so many times as fine as those of the front method, whose cells hold more than one arc.
_FINENESS = 6.0
#: They are made finer, this far at most, until the mesh's own fastest run is as fast as the true one to this share, and
#: a run of the costate program costs as much on the mesh as it does. What is lost goes with the square of the cells,
#: which are taken so much finer than that says; where it no longer falls to this share, it is not the cells'.
_MESH_ERROR = 2e-4
_FINEST = 16.0
_MARGIN = 1.1
_FALLS = 0.7
_Floats = NDArray[np.float64]

#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.03
#: A run that crosses a drop of traction is aimed again so often at most.
_AIMS = 6
#: Relative difference below which running times are the same.
_SAME = 1e-9


def refine_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
    known: list[Extremals] | None = None,
) -> OptimalRuns:
    """Least energy, by any energy model, at given running times.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run, which is the point for every target that it meets.
    target_s : (n,) float64
        Increasing running times, s.
    budget : SearchBudget
        Its time limit is looked at between sweeps.
    tolerance_s : float, optional
        How well running times are met, s; by default a small share of the smallest step between them.
    known : list of Extremals, optional
        Those of this trip that calls before have solved, for other times, and left here; one call at a time.

    Returns
    -------
    OptimalRuns
        As `tgvdp.methods.costate.front.optimal_front` returns it, with the energy of the trip's model.

    Raises
    ------
    NumericalError
        When no run with one constant acceleration per cell is as fast as the envelope.
    """
    clock = budget.start()
    energy = energy_tables(trip.train, trip.energy)
    if tolerance_s is None:
        tolerance_s = _STEP_TOL * float(np.diff(target_s, prepend=0.0).min())
    half_s = 0.5 * tolerance_s  # as of the front method, no point is later than its target
    slower_s = target_s[target_s > fastest.duration_s * (1.0 + _SAME)]
    counters = {"extremals": 0, "sweeps": 0, "blends": 0}
    first_rows = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    found = [(fastest.duration_s, fastest.total_energy_j, math.inf)] * (len(target_s) - len(slower_s))
    rows = [first_rows] * len(found)
    complete, saves = True, True
    holds = known is None  # a journey asks for many times between which it then chooses
    known = [] if known is None else known
    try:
        if len(slower_s):
            front = known.pop() if known else _extremals(trip, fastest, energy, clock)
            known.append(front.asked(half_s, counters, clock, holds))
        for middle_s in (slower_s - half_s).tolist():
            saves = front.reach(middle_s)
            x_m, w, run, multiplier = _met(front, middle_s, half_s, saves)
            rows.append((x_m, w))
            found.append((run.duration_s, run.total_energy_j, multiplier))
            if not saves:
                break
    except OutOfTime:
        complete = False
    duration, joules, multipliers = np.array(found, dtype=np.float64).reshape(-1, 3).T
    true = [Followed(Batch.of(rows), None, duration, joules)] if rows else []
    return OptimalRuns(duration, joules, multipliers, complete, not saves, counters, true)


def _met(front: Extremals, middle_s: float, half_s: float, saves: bool) -> tuple[_Floats, _Floats, Profile, float]:
    """Rows of the run that takes a time to a tolerance, or of the thriftiest one; its profile, and its multiplier."""
    trip = front.mesh.trip
    aim_s = middle_s
    for _ in range(_AIMS):
        point = front.point(aim_s) if saves else front.thriftiest()
        x_m, w = follow(trip.train, resolve(trip), *front.rows(point))
        run = profile_of(trip, x_m, w)  # across a drop of traction a train is slower than its arcs
        late_s = run.duration_s - middle_s
        if not saves or abs(late_s) <= half_s:
            break
        aim_s -= late_s
    return x_m, w, run, point.multiplier


def _extremals(trip: Trip, fastest: Profile, energy: EnergyTables, clock: Clock) -> Extremals:
    """Those of a mesh so fine that with one acceleration per cell next to nothing is lost."""
    fineness, before_s, before = _FINENESS, math.inf, math.inf
    while True:
        front = Extremals(mesh_for(trip, fastest, fineness), fastest, energy)
        reference, lost = front.extremals[0], front.mesh_error()
        drivable = math.isfinite(reference.energy_j)
        nearest_s = min(abs(reference.time_s - known_s) for known_s in (fastest.duration_s, before_s))
        is_fast = nearest_s <= _MESH_ERROR * fastest.duration_s
        is_cheap = lost <= _MESH_ERROR or lost > _FALLS * before
        if drivable and ((is_fast and is_cheap) or fineness >= _FINEST):
            return front
        if fineness >= _FINEST:
            raise NumericalError("the refinement finds no fastest run with one acceleration per cell")
        if clock.expired:
            raise OutOfTime
        enough = _MARGIN * math.sqrt(lost / _MESH_ERROR) if drivable and is_fast else math.inf
        fineness, before_s, before = fineness * min(enough, 2.0), reference.time_s, lost
