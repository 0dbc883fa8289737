"""Lines, each from the optimal run of a multiplier, with more or less care, side by side where they are long."""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.banded import banded
from tgvdp.certificate.line import BoundingProblem
from tgvdp.cores import shares, side_by_side
from tgvdp.errors import BudgetExceededError, TgvdpError
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

#: Cells of the front's mesh are cut into so many for the extremals of lines, and for those made with care.
_FINENESS, _FINE_WITH_CARE = 2.0, 4.0
#: What a line is short of, relative to what gaps are shares of, for which curved potentials are worth the time.
_CURVED = 2e-4
#: ... on so many cells; on more of them, of which a linear program takes longer, it is more in proportion, up to this.
_CURVED_CELLS, _MOST_CURVED = 1000, 5e-4
#: ... and for which all of their kinks are, before finer cells were tried.
_FAR = 1e-3
#: Care that lines are made with, in this order: none; ascent; and ascent with so many times more cells. All with care
#: have this many times more, for what other causes leave is more than what the width of cells does.
_CAREFUL = 1.5
NEXT_CARE = {0.0: 1.0, 1.0: 2.0, 2.0: 4.0, 4.0: math.nan}
#: What a step of an ascent must gain, relative to the energy.
_ASCENT_GAIN = 1e-5
#: Cells of meshes that are worth a thread: fewer are done sooner by one.
_LEAST_CELLS = 500


class Line(NamedTuple):
    """E ≥ line_j − multiplier_j_per_s·T for every run, and the run that suggested the costate: its T and its E + λT.

    ``care`` is how a better one could be made: 1 by ascent, above it by ascent with so many times more cells; NaN where
    that is not worth it.
    """

    multiplier_j_per_s: float
    line_j: float
    time_s: float
    cost_j: float
    care: float = math.nan


class Wanted(NamedTuple):
    """A line to be made.

    Attributes
    ----------
    multiplier_j_per_s : float
        Its λ.
    care : float
        0, or as `Line.care` has it.
    enough_j : float
        It needs no more care than bounds E + λT by this.
    """

    multiplier_j_per_s: float
    care: float = 0.0
    enough_j: float = math.inf


#: A line; none where the costate program finds none, or the time is up; or why there was no memory for it.
Made: TypeAlias = Line | BudgetExceededError | None


def level_line(problem: BoundingProblem) -> Line:
    """The line of λ = 0, which no run suggests."""
    return Line(0.0, problem.least_energy_j, math.inf, problem.least_energy_j)


def _optimal(problem: BoundingProblem, mesh: Mesh, multiplier: float) -> Run:
    """The optimal run of a multiplier, J/s, in rows that the next one of this thread overwrites.

    The power of auxiliaries is part of the multipliers of a mesh, and of the run's, which otherwise know none.
    """
    return mesh.optimal_run(problem.total(multiplier), {"extremals": 0, "runs": 0, "costates": 0})


def least_cost_j(trip: Trip, fastest: Profile, multiplier: float, size_j: float, clock: Clock) -> float:
    """Lower bound of E + λT, less the trip's credits, of all of its runs, J, by ascent from the optimal one.

    Parameters
    ----------
    trip : Trip
        Whose credits leave the multiplier above 0 everywhere.
    fastest : Profile
        Its fastest run.
    multiplier : float
        λ, J/s.
    size_j : float
        Energy of which gains of the ascent are shares.
    clock : Clock

    Raises
    ------
    TgvdpError
        When the costate program fails.
    """
    problem, mesh = BoundingProblem(trip), Mesh.of(trip, fastest, _FINE_WITH_CARE)
    run = _optimal(problem, mesh, multiplier)
    return problem.line(run.x_m, run.w, multiplier, gain_j=_ASCENT_GAIN * size_j, clock=clock)


def _more_short(cells: int) -> float:
    """By how much more than a line of few cells one of so many must be short, relative to what gaps are shares of."""
    return max(min(_CURVED * cells / _CURVED_CELLS, _MOST_CURVED) - _CURVED, 0.0)


class LineMaker:
    """Makes lines under the points of a front.

    Parameters
    ----------
    problem : BoundingProblem
    fastest : Profile
        Fastest run of its trip.
    time_s, size_j : (n,) float64
        Running times of the points, s, and of what J their gaps are shares.
    """

    def __init__(
        self, problem: BoundingProblem, fastest: Profile, time_s: NDArray[np.float64], size_j: NDArray[np.float64]
    ) -> None:
        self._problem, self._fastest = problem, fastest
        self._time_s, self._size_j = time_s, size_j
        self._mesh = Mesh.of(problem.trip, fastest, _FINENESS)

    @property
    def usual_multiplier(self) -> float:
        """A multiplier to begin with, J/s."""
        return self._mesh.usual_multiplier

    def size_at(self, time_s: float) -> float:
        """What gaps are shares of at a running time, J."""
        return float(np.interp(time_s, self._time_s, self._size_j))

    def made(self, wanted: Sequence[Wanted], clock: Clock) -> list[Made]:
        """Make lines, as many at once as there are cores; what they are does not depend on that."""
        self._mesh.share()
        if any(one.care for one in wanted):
            self._fine_mesh.share()
        if shares(len(wanted) * len(self._mesh.cells.length_m), _LEAST_CELLS) == 1:
            return [self._made(one, clock) for one in wanted]
        return side_by_side(lambda one: self._made(one, clock), wanted)

    def _made(self, wanted: Wanted, clock: Clock) -> Made:
        if clock.expired:
            return None
        try:
            return self._line(*wanted, clock)
        except BudgetExceededError as error:
            return error

    @cached_property
    def _fine_mesh(self) -> Mesh:
        return Mesh.of(self._problem.trip, self._fastest, _FINE_WITH_CARE)

    def _line(self, multiplier: float, care: float, enough_j: float, clock: Clock) -> Line | None:
        """Line from the optimal run of a multiplier, J/s; none where the costate program finds none."""
        problem = self._problem
        try:
            run = _optimal(problem, self._fine_mesh if care else self._mesh, multiplier)
        except BudgetExceededError:
            raise
        except TgvdpError:
            return None
        size_j = self.size_at(run.time_s)
        gain_j = _ASCENT_GAIN * size_j if care else math.inf
        cost_j = run.energy_j + run.multiplier * run.time_s
        ledger = problem.ledger(run.x_m, run.w, multiplier, max(_CAREFUL * care, 1.0), gain_j, clock, enough_j)
        line_j = problem.line_j(ledger)
        more_j = _more_short(len(ledger.bound)) * size_j
        if care and line_j < min(enough_j, cost_j - _CURVED * size_j) - more_j:
            is_far = care > 1.0 or line_j < min(enough_j, cost_j) - _FAR * size_j
            line_j = problem.line_j(banded(problem, ledger, multiplier, gain_j, clock, enough_j, is_far))
        return Line(multiplier, line_j, run.time_s, cost_j, care if line_j >= enough_j else NEXT_CARE[care])
