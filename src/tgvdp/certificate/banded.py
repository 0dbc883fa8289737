"""The best bound of a potential with kinks where efforts change, and that is curved in the speed.

Where traction or braking rates change at a speed, or the dynamic brake begins, jumps or has risen, the least energy
from a place on has a kink there, wherever the train is, and no p·w touches it on both sides. It has one as well where
the load alone slows a faster train by more than its braking rate. Where the dynamic brake works at its full power on a
descent, or at long running times, the least energy is concave in w. All costates of such a potential (`bands`) are
found at once, by a linear program for sampled speeds (`sampled`) that lets them go so far and no farther. The bound is
concave in them: the best of it on the way there is where the next round begins, which the speeds of the exact least
values join.
"""

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.certificate.bands import Potential, bands_kernel
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.sampled import best_sampled
from tgvdp.certificate.slopes import regular_cells
from tgvdp.methods.budget import Clock
from tgvdp.physics.brake_shape import begins_mps, jumps, ramps_to_mps

_Floats = NDArray[np.float64]

#: Speeds that are sampled at first at an end of a cell, besides those of least values: relative to the largest one
#: there, to that of the run, and to those of kinks.
_OF_LARGEST = np.linspace(0.25, 1.0, 9)
_OF_RUN = np.array([0.94, 0.985, 1.0, 1.015, 1.06])
_OF_KINK = np.array([1.0 - 1e-9, 1.0 + 1e-9])
#: Kinks at most, and on which share of a line one must be that depends on its gradient.
_MOST_KINKS = 4
_LEAST_SHARE = 0.1
#: How far costates may go in the first round, relative to the level of traction; how much farther after a round that
#: was best at its end, before the middle of its way, or nowhere.
_REACH = 0.3
_FARTHER, _LESS_FAR, _NEAR = 2.0, 0.5, 0.25
#: Parts of the way that are tried.
_PARTS = (0.25, 0.5, 0.75, 1.0)
#: Rounds at most; what one must gain after the first, and what its linear program may leave, in units of the gain of
#: which the ascent takes note.
_MOST_ROUNDS = 6
_WORTH, _LEFT = 4.0, 20.0


@kernel
def _regular(w):
    """`regular_cells`, for Python."""
    return regular_cells(w)


def banded(
    problem: BoundingProblem,
    found: Ledger,
    multiplier_j_per_s: float,
    gain_j: float,
    clock: Clock | None = None,
    enough_j: float = math.inf,
    of_all: bool = True,
) -> Ledger:
    """The best bound with kinks and a curve of the potential, or ``found`` where none is better.

    Parameters
    ----------
    problem : BoundingProblem
    found : Ledger
        A bound of one costate, which the search starts from.
    multiplier_j_per_s : float
        Its multiplier λ.
    gain_j : float
        The gain of which the ascent takes note.
    clock : Clock, optional
    enough_j : float
        A bound that needs no further round.
    of_all : bool
        Whether there are kinks where traction jumps, and where braking rates rise or the load alone slows a train by
        more than they do, too: more bands take more time.

    Returns
    -------
    Ledger
        With the costates of the lowest band.
    """
    kinks_w = kinks_of(problem, found, of_all)
    if len(kinks_w) == 0 and not problem.may_curve(multiplier_j_per_s):
        return found
    multiplier = problem.total(multiplier_j_per_s) / problem.train.inertia_kg
    potential, best = _begin(found, kinks_w), found
    least = bounded(problem, found, multiplier, potential)[1]
    speeds = np.concatenate((_first_speeds(found, kinks_w), least), axis=2)
    reach = _REACH * problem.energy.traction
    for round_ in range(_MOST_ROUNDS):
        left_s, before_j = clock.left_s() if clock else math.inf, problem.line_j(best)
        aim = best_sampled(
            problem.train, problem.energy, found, multiplier, potential, np.sort(speeds, axis=2), problem.top_mps,
            problem.pieces, reach, _LEFT * gain_j / problem.train.inertia_kg, clock,
        )  # fmt: skip
        on_the_way = [_between(potential, aim, part) for part in _PARTS]
        tried = [bounded(problem, found, multiplier, one) for one in on_the_way]
        which = int(np.argmax([problem.line_j(ledger) for ledger, _ in tried]))
        gained_j = problem.line_j(tried[which][0]) - before_j
        if gained_j > 0.0:
            best, potential = tried[which][0], on_the_way[which]
        if problem.line_j(best) >= enough_j or (round_ > 0 and not gained_j > _WORTH * gain_j):
            break
        if clock and clock.left_s() < 0.5 * left_s:  # another round, of more speeds, takes longer than that
            break
        reach *= _reach_after(gained_j, _PARTS[which])
        speeds = np.concatenate((speeds, *(tried[one][1] for one in {which, len(_PARTS) - 1})), axis=2)
    return best


def _reach_after(gained_j: float, part: float) -> float:
    """How much farther costates may go after a round, by what part of its way was best."""
    if not gained_j > 0.0:
        return _NEAR
    return _FARTHER if part == 1.0 else _LESS_FAR if part < 0.5 else 1.0


def _between(one: Potential, other: Potential, part: float) -> Potential:
    """A potential that is a part of the way from one to another."""
    left, right, bow = (
        before + part * (after - before)
        for before, after in ((one.left, other.left), (one.right, other.right), (one.bow, other.bow))
    )
    return Potential(one.edges, left, right, bow)


def bounded(problem: BoundingProblem, found: Ledger, multiplier: float, potential: Potential) -> tuple[Ledger, _Floats]:
    """The bound of a potential on the cells of a ledger, λ per unit of inertia.

    Also the speeds of the least values at both ends of each cell in each band, (K, 2, B), m/s.
    """
    first, last = _regular(found.w)
    standing = np.ones(len(found.left), dtype=np.bool_)
    standing[first : last + 1] = False
    lowest = potential.left[:, 0].copy(), potential.right[:, 0].copy()
    ledger = problem.evaluate(found, multiplier, *lowest, wanted=standing)
    speeds = np.ones((len(standing), 2, potential.left.shape[1]))
    bands_kernel(
        problem.train, problem.energy, found.cells, found.caps, found.w, multiplier, potential, problem.top_mps,
        problem.pieces, ledger.bound, ledger.doubt, speeds,
    )  # fmt: skip
    return ledger, speeds


def _begin(found: Ledger, kinks_w: _Floats) -> Potential:
    """The potential of one costate in all bands."""
    edges = np.concatenate(([0.0], kinks_w, [np.inf]))
    left, right = (side[:, np.newaxis].repeat(len(kinks_w) + 1, axis=1) for side in (found.left, found.right))
    return Potential(edges, left, right, np.zeros(len(found.w)))


def _first_speeds(found: Ledger, kinks_w: _Floats) -> _Floats:
    """Speeds at both ends of each cell, (K, 2, S), m/s: in all bands that the cell has speeds of."""
    most = np.sqrt(found.caps.cell)[:, np.newaxis, np.newaxis].repeat(2, axis=1)
    of_run = np.sqrt(np.stack((found.w[:-1], found.w[1:]), axis=1))[:, :, np.newaxis] * _OF_RUN
    of_kinks = (np.sqrt(kinks_w)[:, np.newaxis] * _OF_KINK).ravel()
    return np.concatenate((most * _OF_LARGEST, np.minimum(of_run, most), np.minimum(of_kinks, most)), axis=2)


def kinks_of(problem: BoundingProblem, found: Ledger, of_all: bool = True) -> _Floats:
    """Squared speeds at which efforts change most, m²/s², rising; not those that a cell of a standstill may reach."""
    train = problem.trip.train
    changes = {
        float(after[0]): 1.0 - float(min(before[2], after[2]) / max(before[2], after[2]))
        for before, after in itertools.pairwise(problem.train.rates)
        if of_all or after[2] < before[2]
    }
    curves = [train.traction_limit] if of_all else []
    if problem.energy.regeneration > 0.0:
        curves.append(train.dynamic_brake_limit)
    for speed_mps, *efforts_n in itertools.chain(*map(jumps, curves)):
        changes[speed_mps] = max(changes.get(speed_mps, 0.0), 1.0 - min(efforts_n) / max(efforts_n))
    if problem.energy.regeneration > 0.0:
        changes |= {begins_mps(train.dynamic_brake_limit): 1.0, ramps_to_mps(train.dynamic_brake_limit): 1.0}
        if of_all:
            changes |= _rates_begin(problem, found)
    first, last = _regular(found.w)
    lowest = float(np.max(np.append(found.caps.cell[:first], found.caps.cell[last + 1 :]), initial=0.0))
    within = [v for v in changes if v > 0.0 and lowest <= v**2 < float(found.caps.cell.max())]
    chosen = sorted(within, key=lambda v: -changes[v])[:_MOST_KINKS]
    return np.square(np.sort(np.array(chosen, dtype=np.float64)))


def _rates_begin(problem: BoundingProblem, found: Ledger) -> dict[float, float]:
    """Speeds above which the load slows a train by more than its braking rate, m/s, and on which share of the line."""
    train, cells = problem.train, found.cells
    length_m: dict[float, float] = {}
    for rate, after in itertools.zip_longest(train.rates, train.rates[1:]):
        from_mps, to_mps = rate[0], after[0] if after is not None else math.inf
        spare_n = rate[2] - train.davis_a_n - cells.grade_n
        root = np.sqrt(np.maximum(train.davis_b**2 + 4.0 * cells.air * spare_n, 0.0)) + train.davis_b
        speed_mps = np.divide(2.0 * spare_n, root, out=np.full_like(root, np.inf), where=root > 0.0)
        is_met = (speed_mps > from_mps) & (speed_mps < to_mps) & (speed_mps**2 < found.caps.cell)
        for v, more_m in zip(speed_mps[is_met].tolist(), cells.length_m[is_met].tolist(), strict=True):
            length_m[v] = length_m.get(v, 0.0) + more_m
    shares = {v: share_m / problem.trip.distance_m for v, share_m in length_m.items()}
    return {v: share for v, share in shares.items() if share >= _LEAST_SHARE}
