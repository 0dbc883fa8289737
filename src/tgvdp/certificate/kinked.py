"""The bound of a potential with a kink at one speed: a costate for the speeds below it, and one for those above.

Where braking rates drop at a speed, or the dynamic brake jumps, the least energy from a place on has a kink there,
wherever the train is, and no p·w touches it on both sides. The potential is lower·min(w, w_k) + upper·max(w − w_k, 0)
instead, each costate linear in a cell. The least of H is then the lesser of two, each over the speeds of its side, so
that the trapezoid of `cell_bounds` holds for it as it does for one; at a jump the potential falls most at w = 0, w_k or
the cap. The costates of one side are raised by the ascent as ever, with those of the other side held, by turns.
"""

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.certificate.cell_bounds import UNIT_ROUNDOFF, Side, cell_kernel
from tgvdp.certificate.cut_out import NOTHING, cut_out_w
from tgvdp.certificate.efforts import NOT_MERGED, load_in, merged_in, price_in
from tgvdp.certificate.hamiltonian import ROUNDINGS, Hamiltonian
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.slopes import regular_cells
from tgvdp.methods.budget import Clock
from tgvdp.physics.brake_shape import JUMPS

_Floats = NDArray[np.float64]

#: Squared speeds nearer than this share to that of a kink are that.
_AT_KINK = 1e-6
_JUST_BELOW = 1.0 - 1e-9
#: Rounds at most, in each of which both sides are raised.
_MOST_ROUNDS = 12


@kernel
def side_kernel(
    train, tables, cells, caps, w, multiplier, side, kink_w, left, right, top_v, pieces, least, doubt
):  # fmt: skip
    """Least values of H on one side of a kink, per unit of inertia, with the potential taken as 0 at the kink.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, left, right, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    side : Side
    kink_w : float
        Squared speed of the kink, m²/s².
    least : (K, 2) float64, modified in place
        At the two ends of each cell; infinite where it has no speed of that side.
    doubt : (K,) float64, modified in place
        Bounds of the rounding errors of their means times the length of the cell, in units of 2⁻⁵³.
    """
    first, last = regular_cells(w)
    merged = NOT_MERGED
    for k in range(first, last + 1):
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        size = (train.davis_a_n + abs(cells.grade_n[k])) / train.inertia_kg
        h = Hamiltonian(pieces, pulls, brakes, dynamics, tables.traction, tables.regeneration, load, size, price)
        cell_v = min(math.sqrt(caps.cell[k]) * (1.0 + 4.0 * UNIT_ROUNDOFF), top_v)
        rise = caps.rise[k]
        start, end, rounding, _, _, _, _ = cell_kernel(
            h, side, left[k], right[k], 0.0, 0.0, d, cell_v, rise[0], rise[1]
        )
        slope = (right[k] - left[k]) / d
        above = slope * (kink_w - side.low_w)
        least[k, 0] = start - above
        least[k, 1] = end - above
        doubt[k] = d * (rounding + ROUNDINGS * abs(slope) * kink_w)


@kernel
def _regular(w):
    """`regular_cells`, for Python."""
    return regular_cells(w)


class _Half(NamedTuple):
    """One side of a kink: its costates at the two ends of each cell, (K,), and what `side_kernel` finds with them."""

    side: Side
    left: _Floats
    right: _Floats
    least: _Floats
    doubt: _Floats


def kinked(
    problem: BoundingProblem,
    found: Ledger,
    multiplier_j_per_s: float,
    gain_j: float,
    clock: Clock | None = None,
    enough_j: float = math.inf,
) -> Ledger:
    """The best bound with a kink at a speed where brakes jump, or ``found`` where none is better.

    Parameters
    ----------
    problem : BoundingProblem
    found : Ledger
        A bound without kink, whose costates both sides start from.
    multiplier_j_per_s : float
        Its multiplier λ.
    gain_j : float
        What a step of an ascent, and both sides together, must gain.
    clock : Clock, optional
    enough_j : float
        A bound that needs no further ascent.

    Returns
    -------
    Ledger
        With the costates below the kink.
    """
    multiplier = problem.total(multiplier_j_per_s) / problem.train.inertia_kg
    tried = [_Kinked(problem, found, multiplier, *kink, gain_j, clock) for kink in _kinks(problem, found)]
    best = found
    for round_ in range(_MOST_ROUNDS):
        before = best
        for one in tried:
            best = max(best, one.raised(), key=problem.line_j)
            if (clock and clock.expired) or problem.line_j(best) >= enough_j:
                return best
        if not problem.line_j(best) - problem.line_j(before) > gain_j:
            return best
        if round_ == 0:  # they compete for the same gap
            tried = [max(tried, key=lambda one: problem.line_j(one.ledger))]
    return best


def _kinks(problem: BoundingProblem, found: Ledger) -> Iterator[tuple[float, bool]]:
    """Squared speeds at which braking rates drop or the dynamic brake jumps, m²/s², and whether it cuts out there.

    Not those that a cell of a standstill may reach.
    """
    brake = problem.trip.train.dynamic_brake_limit
    kinks = {
        float(after[0]): False for before, after in itertools.pairwise(problem.train.rates) if after[2] < before[2]
    }
    if problem.energy.regeneration > 0.0:
        for v in brake.jumps_mps:
            below_n, above_n = brake.effort_n(v * _JUST_BELOW), brake.effort_n(v)
            if abs(above_n - below_n) > JUMPS * max(below_n, above_n):
                kinks[v] = below_n <= NOTHING * above_n
        cut_w = cut_out_w(problem.train)
        if cut_w > 0.0:  # a jump, or where it rises steeply
            kinks.setdefault(math.sqrt(cut_w), True)
    if kinks:
        lowest, highest = _standing_w(found), float(found.caps.cell.max())
        yield from ((v**2, cuts_out) for v, cuts_out in kinks.items() if lowest <= v**2 < highest)


def _standing_w(found: Ledger) -> float:
    """Largest squared speed in cells of a standstill, m²/s², whose bound knows no kink."""
    first, last = _regular(found.w)
    return float(np.max(np.append(found.caps.cell[:first], found.caps.cell[last + 1 :]), initial=0.0))


def _below_cut_out(
    problem: BoundingProblem, found: Ledger, multiplier: float, kink_w: float
) -> tuple[_Floats, _Floats]:
    """Costates below a speed at which the dynamic brake cuts out, at the two ends of each cell: those found, or more.

    Where the envelope falls through that speed, slower runs coast until they meet it, where p = 0, while faster ones
    use that brake. From there on all brakes follow the envelope.
    """
    left, right = found.left.copy(), found.right.copy()
    cap, v = found.caps.node, math.sqrt(kink_w)
    for last in np.flatnonzero(
        (cap[:-1] > kink_w * (1.0 + _AT_KINK)) & (cap[1:] <= kink_w * (1.0 + _AT_KINK))
    ).tolist():
        p = 0.0
        for k in range(last, -1, -1):
            drag = (0.5 * problem.train.davis_b / v + found.cells.air[k]) / problem.train.inertia_kg
            before = p - found.cells.length_m[k] * (0.5 * multiplier / v**3 + 2.0 * p * drag)
            if before <= left[k] and p <= right[k]:
                break
            left[k], right[k] = max(left[k], before), max(right[k], p)
            p = before
        for k in range(last + 1, len(left)):
            if cap[k + 1] > cap[k]:
                break
            left[k] = right[k] = 0.0
    return left, right


class _Kinked:
    """A bound with a kink at one speed, and its costates."""

    def __init__(
        self,
        problem: BoundingProblem,
        found: Ledger,
        multiplier: float,
        kink_w: float,
        cuts_out: bool,
        gain_j: float,
        clock: Clock | None,
    ) -> None:
        self._problem, self._found, self._multiplier, self._kink_w = problem, found, multiplier, kink_w
        self._gain_j, self._clock = gain_j, clock
        below = _below_cut_out(problem, found, multiplier, kink_w) if cuts_out else (found.left, found.right)
        self._lower = self._half(Side(0.0, kink_w), *below)
        self._upper = self._half(Side(kink_w, math.inf), found.left, found.right)
        self.ledger = found
        if cuts_out:  # those below are right, and those above a compromise
            self._raise_upper()

    def raised(self) -> Ledger:
        """The bound after another ascent of either side."""
        self._lower = self._climbed(self._lower, self._upper.least)
        self._raise_upper()
        self.ledger = self._together()
        return self.ledger

    def _raise_upper(self) -> None:
        self._upper = self._climbed(self._upper, self._lower.least)

    def _climbed(self, half: _Half, other: _Floats) -> _Half:
        """One side with better costates, the least values on the other being given."""
        start = self._found._replace(left=half.left, right=half.right)
        left, right, _ = self._problem.climbed(start, self._multiplier, half.side, other, self._gain_j, self._clock)
        return self._half(half.side, left, right)

    def _half(self, side: Side, left: _Floats, right: _Floats) -> _Half:
        """One side with given costates."""
        problem, found = self._problem, self._found
        least, doubt = np.full((len(left), 2), np.inf), np.zeros(len(left))
        side_kernel(
            problem.train, problem.energy, found.cells, found.caps, found.w, self._multiplier, side, self._kink_w,
            left, right, problem.top_mps, problem.pieces, least, doubt,
        )  # fmt: skip
        return _Half(side, left, right, least, doubt)

    def _together(self) -> Ledger:
        """The bound of both sides; cells of a standstill know the lower one only."""
        found, lower, upper, kink_w = self._found, self._lower, self._upper, self._kink_w
        first, last = _regular(found.w)
        bound = 0.5 * found.cells.length_m * np.minimum(lower.least, upper.least).sum(axis=1)
        bound += (lower.right - lower.left) * kink_w  # the potential at the kink
        doubt = lower.doubt + upper.doubt + ROUNDINGS * (np.abs(lower.right) + np.abs(lower.left)) * kink_w
        cap, w = found.caps.node[1:-1], found.w
        by_lower = (lower.left[1:] - lower.right[:-1]) * np.minimum(cap, kink_w)
        by_upper = (upper.left[1:] - upper.right[:-1]) * np.maximum(cap - kink_w, 0.0)
        bound[1:] += np.minimum(0.0, np.minimum(by_lower, by_lower + by_upper))
        doubt[1:] += ROUNDINGS * (np.abs(by_lower) + np.abs(by_upper))
        for k, node, p_lower, p_upper in ((0, 0, lower.left, upper.left), (-1, -1, -lower.right, -upper.right)):
            by_lower, by_upper = p_lower[k] * min(w[node], kink_w), p_upper[k] * max(w[node] - kink_w, 0.0)
            bound[k] += by_lower + by_upper
            doubt[k] += ROUNDINGS * (abs(by_lower) + abs(by_upper))
        standing = np.ones(len(bound), dtype=np.bool_)
        standing[first : last + 1] = False
        ledger = self._problem.evaluate(found, self._multiplier, lower.left, lower.right, wanted=standing)
        ledger.bound[first : last + 1] = bound[first : last + 1]
        ledger.doubt[first : last + 1] = doubt[first : last + 1]
        return ledger
