"""A trip prepared for lower bounds, and one bound with all that it is made of."""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.ascent import Progress, climb, room_for
from tgvdp.certificate.cell_bounds import bound_kernel
from tgvdp.certificate.cells import split_cells
from tgvdp.certificate.costates import run_costates
from tgvdp.certificate.costates_at_bound import lower_braking, raise_pulling
from tgvdp.certificate.curved import is_concave
from tgvdp.certificate.efforts import PIECE_COLUMNS
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.prepared import speed_bound_rows, with_rates
from tgvdp.certificate.regime_costates import Costates
from tgvdp.certificate.regimes import LabelledRun, label_cells
from tgvdp.certificate.rows import CELL_B, RunRows, cut_into_cells, rows_of
from tgvdp.certificate.speed_bound import Caps, lower_caps
from tgvdp.line.cells import Cells, cells_of
from tgvdp.memory import ask_for, scratch
from tgvdp.methods.budget import Clock
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.runs.fastest import within_reach

_Floats = NDArray[np.float64]

#: Largest change of the costate within a cell, relative to its distance from the levels; and how many times more cells
#: that must make for cells to be cut again.
_COSTATE_STEP, _WORTH_CUTTING = 0.3, 1.1
#: Phases shorter than this share of the trip are rounding errors.
_SLIVER = 1e-6
#: A run on a mesh may slip into another regime for less than this, s: friction where the dynamic brake met the limit
#: a hand's breadth too late. Costates are tried without such phases, too.
_MOMENT_S = 1.0
#: Costates whose squares are no numbers are none themselves.
_LARGEST = math.sqrt(float(np.finfo(np.float64).max))
#: Steps of an ascent at most, far more than most take, and cells that are moved between two looks at the clock.
_MOST_STEPS = 600
_CELLS_AT_ONCE = 50_000
#: Memory that a cell takes in an ascent, whose chains have up to 120 points for each of its ends, B.
_ASCENT_B = 4500.0
#: More than the rounding error of a sum over the cells of a line, relative to it.
_ROUNDING = 1e-10


class BoundingProblem:
    """A trip prepared for lower bounds of E + λT, E as the trip's energy model has it (but for maps)."""

    def __init__(self, trip: Trip) -> None:
        self.trip = trip
        self.train: KernelTrain = kernel_train(trip.train)
        self.energy: EnergyTables = energy_tables(trip.train, trip.energy)
        self.cells = within_reach(trip, cells_of(trip))
        self.top_mps = math.sqrt(float(self.cells.limit_w.max())) * (1.0 + 1e-15)
        self.train = with_rates(self.train)
        bounded = self.train, self.cells, self.pieces[0]
        ahead = speed_bound_rows(*bounded, trip.start_speed_mps**2, forward=True)
        self._speed_bounds = ahead, speed_bound_rows(*bounded, trip.end_speed_mps**2, forward=False)

    @property
    def pieces(self) -> _Floats:
        """What this thread writes pieces of efforts into, (3, n, PIECE_COLUMNS)."""
        most = 3 * max(len(self.train.traction), len(self.train.braking))
        return scratch("pieces", 3 * most, PIECE_COLUMNS).reshape(3, most, PIECE_COLUMNS)

    @property
    def least_energy_j(self) -> float:
        """Energy below which no run of any duration goes, J: effort never returns more than η of its work."""
        work_j = 0.5 * self.train.inertia_kg * (self.trip.end_speed_mps**2 - self.trip.start_speed_mps**2)
        work_j += float((self.train.davis_a_n + self.cells.grade_n) @ self.cells.length_m)
        work_j = max(self.energy.traction * work_j, self.energy.regeneration * work_j)
        drawn_w = self.energy.auxiliary_w - self.cells.saved_w
        least_s = self.cells.length_m / np.sqrt(self.cells.limit_w) * (1.0 - _ROUNDING)
        return work_j + float(drawn_w @ least_s)

    def total(self, multiplier_j_per_s: float) -> float:
        """The multiplier with the power of auxiliaries, which is a price of time, too: what kernels take, J/s."""
        return multiplier_j_per_s + self.energy.auxiliary_w

    def line(
        self,
        x_m: _Floats,
        w: _Floats,
        multiplier_j_per_s: float,
        fineness: float = 1.0,
        gain_j: float = math.inf,
        clock: Clock | None = None,
    ) -> float:
        """Lower bound of E + λT of every run, J, with the costates of `ledger`."""
        return self.line_j(self.ledger(x_m, w, multiplier_j_per_s, fineness, gain_j, clock))

    def line_j(self, ledger: Ledger) -> float:
        """Lower bound of E + λT of every run, J, whose cells are in a ledger."""
        return self.train.inertia_kg * (ledger.total - ledger.error)

    def ledger(
        self,
        x_m: _Floats,
        w: _Floats,
        multiplier_j_per_s: float,
        fineness: float = 1.0,
        gain_j: float = math.inf,
        clock: Clock | None = None,
        enough_j: float = math.inf,
    ) -> Ledger:
        """Bound of E + λT cell by cell.

        Parameters
        ----------
        x_m, w : (n,) float64
            Rows of a run that suggests the costate: positions from the origin, m, and squared speeds, m²/s². The bound
            holds for every run of the trip, whatever the rows.
        multiplier_j_per_s : float
            Multiplier λ, above 0.
        fineness : float
            How many times more cells than usual there are where speed or costate change.
        gain_j : float
            Costates of the run are improved by ascent for as long as a step promises to gain this, and there is time.
        clock : Clock, optional
        enough_j : float
            A bound that needs no further ascent.
        """
        multiplier = self.total(multiplier_j_per_s) / self.train.inertia_kg
        rows = rows_of(self.trip, self.train, self.cells, x_m, w)
        price_s = self.energy.traction / (multiplier * fineness**2)
        rows, node_m, node_w, row = cut_into_cells(rows, self.trip.distance_m, price_s)
        run = self._labelled(rows, node_m, node_w, row, multiplier)
        phases = self._costates(run)
        nodes = (node_m, node_w, row, phases.left, phases.right, multiplier, _COSTATE_STEP / fineness)
        nothing = np.empty(0)
        count = split_cells(*nodes, nothing, nothing, np.empty(0, dtype=np.int64))
        if count > _WORTH_CUTTING * len(row):
            ask_for(CELL_B * count, f"a bound on {count:,} cells")
            node_m, node_w, row = np.empty(count + 1), np.empty(count + 1), np.empty(count, dtype=np.int64)
            split_cells(*nodes, node_m, node_w, row)
            run = self._labelled(rows, node_m, node_w, row, multiplier)
            phases = self._costates(run)
        found = self.evaluate(phases, multiplier, phases.left, phases.right)
        found = self._raised(self._better(found, self._costates(run, phases.caps, _MOMENT_S), multiplier), multiplier)
        if not math.isfinite(gain_j) or self.line_j(found) >= enough_j:
            return found
        return self.ascended(found, multiplier, gain_j, clock, enough_j)

    def _raised(self, found: Ledger, multiplier: float) -> Ledger:
        """The bound with costates that go along the speed bounds in each phase in which that is better."""
        left, right = found.left.copy(), found.right.copy()
        along = found.cells, found.caps.cell, found.w, found.label, self.top_mps, self.pieces, left, right
        raise_pulling(self.train, self.energy, multiplier, *along)
        lower_braking(self.train, self.energy, multiplier, *along)
        return self._better(found, found._replace(left=left, right=right), multiplier)

    def _better(self, found: Ledger, other: Ledger, multiplier: float) -> Ledger:
        """The bound with the costates of another ledger of the same cells wherever these differ and are better."""
        changed = (other.left != found.left) | (other.right != found.right)
        changed[1:] |= other.right[:-1] != found.right[:-1]  # the jump at the start of a cell is part of its bound
        changed[0] |= changed[1]  # a cell of a standstill has the costate of its neighbour
        other = self.evaluate(found._replace(label=other.label), multiplier, other.left, other.right, wanted=changed)
        ends = np.append(np.flatnonzero(changed[1:] != changed[:-1]) + 1, len(changed))  # of phases by turns changed
        first = np.append(0, ends[:-1])
        better = (np.add.reduceat(other.bound - found.bound, first) > 0.0).repeat(ends - first)
        if not better.any():
            return found
        columns = ("bound", "doubt", "left", "right", "label")
        return found._replace(
            **{name: np.where(better, getattr(other, name), getattr(found, name)) for name in columns}
        )

    def ascended(
        self,
        found: Ledger,
        multiplier: float,
        gain_j: float,
        clock: Clock | None = None,
        enough_j: float = math.inf,
    ) -> Ledger:
        """The bound with costates all moved at once until a pass gains less than ``gain_j``, is enough, or time is up.

        See `climb`.
        """
        left, right, count = found.left.copy(), found.right.copy(), len(found.left)
        ask_for(_ASCENT_B * count, f"the ascent of a bound on {count:,} cells")
        room, progress = room_for(count), Progress(0.0, 0, 0, 0, False)
        steps = max(_CELLS_AT_ONCE // count, 1)
        while progress.steps < _MOST_STEPS and not progress.ended and not (clock and clock.expired):
            progress = climb(
                self.train, self.energy, found.cells, found.caps, found.w, multiplier, left, right, self.top_mps,
                self.pieces, gain_j / self.train.inertia_kg, enough_j / self.train.inertia_kg,
                min(steps, _MOST_STEPS - progress.steps), progress, room,
            )  # fmt: skip
        better = self.evaluate(found, multiplier, left, right)
        return better if found.total - found.error < better.total - better.error < math.inf else found

    def may_curve(self, multiplier_j_per_s: float) -> bool:
        """Whether H is concave at some speed, so that a potential that is curved there may be the better one."""
        return is_concave(self.train, self.energy, self.total(multiplier_j_per_s), self.top_mps)

    def _labelled(
        self, rows: RunRows, node_m: _Floats, node_w: _Floats, row: NDArray[np.int64], multiplier: float
    ) -> LabelledRun:
        """A run in given cells, each with its regime."""
        place = rows.place[row]
        grade_n, air = self.cells.grade_n[place], self.cells.air[place]
        supply, saved_w = self.cells.supply[place], self.cells.saved_w[place]
        cells = Cells(node_m, np.diff(node_m), grade_n, air, self.cells.limit_w[place], supply, saved_w)
        levels = -0.5 * self.energy.traction, -0.5 * self.energy.regeneration
        label, source, growth = np.empty(len(row), dtype=np.int8), np.zeros((len(row), 4)), np.zeros((len(row), 4))
        run = LabelledRun(cells, node_w, rows.effort[row], multiplier, *levels, label, source, growth)
        label_cells(self.train, self.energy, run, self.top_mps, self.pieces)
        return run

    def _costates(self, run: LabelledRun, caps: Caps | None = None, moment_s: float = 0.0) -> Ledger:
        """Costates along a run, not yet bounded; of phases that last ``moment_s`` at least."""
        run = run._replace(label=run.label.copy())
        caps = self._caps(run.cells) if caps is None else caps
        left, right, *scratch = np.zeros((4, len(run.label) + 1))
        left, right = left[:-1], right[:-1]
        costates = Costates(left, right, *scratch)
        run_costates(run, caps.cell, _SLIVER * self.trip.distance_m, moment_s, costates)
        lost = ~((np.abs(left) < _LARGEST) & (np.abs(right) < _LARGEST))  # where nothing bounds its growth p overflows
        left[lost] = right[lost] = 0.0
        return Ledger(np.empty_like(left), np.empty_like(left), left, right, run.cells, caps, run.w, run.label)

    def _caps(self, cells: Cells) -> Caps:
        """Squared speeds that no run passes."""
        cap = cells.limit_w.copy()
        node_cap = np.minimum(np.append(cap, np.inf), np.append(np.inf, cap))
        caps = Caps(cap, node_cap, np.empty((len(cap), 2)))
        lower_caps(self.trip.distance_m, cells.station_m, *self._speed_bounds, caps)
        return caps

    def evaluate(
        self,
        phases: Ledger,
        multiplier: float,
        left: _Floats,
        right: _Floats,
        wanted: NDArray[np.bool_] | None = None,
    ) -> Ledger:
        """Bound on the cells of a ledger for given costates, all per unit of inertia; any finite costates will do.

        Of cells that are not ``wanted``, whose costates and those of their neighbours must be as they were, the bound
        stays.
        """
        bound, doubt = phases.bound.copy(), phases.doubt.copy()
        wanted = np.ones(len(bound), dtype=np.bool_) if wanted is None else wanted
        bound_kernel(
            self.train, self.energy, phases.cells, phases.caps, phases.w, multiplier, left, right, self.top_mps,
            self.pieces, wanted, bound, doubt,
        )  # fmt: skip
        return phases._replace(bound=bound, doubt=doubt, left=left, right=right)
