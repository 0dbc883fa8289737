"""The best bound of a potential with kinks where brakes change, and that is curved in the speed.

Where braking rates drop at a speed, or the dynamic brake begins, jumps or has risen, the least energy from a place on
has a kink there, wherever the train is, and no p·w touches it on both sides. Where that brake works at its full power
on a descent, or at long running times, the least energy is concave in w. All costates of such a potential (`bands`) are
found at once, by a linear program for sampled speeds (`sampled`); the speeds of the exact least values join the
samples, until that gains nothing.
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
from tgvdp.physics.brake_shape import JUMPS, begins_mps, ramps_to_mps

_Floats = NDArray[np.float64]

#: Speeds that are sampled at first at an end of a cell, relative to the largest one there, and to that of the run.
_OF_LARGEST = np.linspace(0.25, 1.0, 9)
_OF_RUN = np.array([0.9, 0.96, 0.985, 1.0, 1.015, 1.04, 1.1])
#: ... and to those of kinks: below them, and just above.
_OF_KINK = np.array([0.3, 0.6, 0.8, 1.0 - 1e-9, 1.0 + 1e-9])
#: Kinks at most.
_MOST_KINKS = 3
#: Rounds at most in which speeds join the samples; and what one must gain, in units of what a linear program may leave.
_MOST_ROUNDS = 6
_WORTH = 4.0


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
        What costates for sampled speeds may be short of.
    clock : Clock, optional
    enough_j : float
        A bound that needs no further round.

    Returns
    -------
    Ledger
        With the costates of the lowest band.
    """
    kinks_w = kinks_of(problem, found)
    if len(kinks_w) == 0 and not problem.may_curve(multiplier_j_per_s):
        return found
    multiplier = problem.total(multiplier_j_per_s) / problem.train.inertia_kg
    potential, speeds, best, before_j = _begin(found, kinks_w), _first_speeds(found, kinks_w), found, -math.inf
    for _ in range(_MOST_ROUNDS):
        left_s = clock.left_s() if clock else math.inf
        potential = best_sampled(
            problem.train, problem.energy, found, multiplier, potential, speeds, problem.top_mps, problem.pieces,
            gain_j / problem.train.inertia_kg, clock,
        )  # fmt: skip
        ledger, least = bounded(problem, found, multiplier, potential)
        best = max(best, ledger, key=problem.line_j)
        gained_j, before_j = problem.line_j(ledger) - before_j, problem.line_j(ledger)
        if problem.line_j(best) >= enough_j or not gained_j > _WORTH * gain_j:
            break
        if clock and clock.left_s() < 0.5 * left_s:  # another round, of more speeds, takes longer than that
            break
        speeds = np.concatenate((speeds, least), axis=2)
    return best


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
    """Speeds to sample at both ends of each cell, (K, 2, S), m/s: in all bands that the cell has speeds of."""
    most = np.sqrt(found.caps.cell)[:, np.newaxis, np.newaxis].repeat(2, axis=1)
    of_run = np.sqrt(np.stack((found.w[:-1], found.w[1:]), axis=1))[:, :, np.newaxis] * _OF_RUN
    of_kinks = (np.sqrt(kinks_w)[:, np.newaxis] * _OF_KINK).ravel()
    return np.concatenate((most * _OF_LARGEST, np.minimum(of_run, most), np.minimum(of_kinks, most)), axis=2)


def kinks_of(problem: BoundingProblem, found: Ledger) -> _Floats:
    """Squared speeds at which brakes change most, m²/s², rising; not those that a cell of a standstill may reach."""
    changes = {
        float(after[0]): 1.0 - float(after[2] / before[2])
        for before, after in itertools.pairwise(problem.train.rates)
        if after[2] < before[2]
    }
    if problem.energy.regeneration > 0.0:
        brake = problem.trip.train.dynamic_brake_limit
        for before, after in itertools.pairwise(brake.pieces):
            less_n, more_n = sorted(one.effort_n(after.from_mps) for one in (before, after))
            if more_n > (1.0 + JUMPS) * less_n:
                changes[after.from_mps] = max(changes.get(after.from_mps, 0.0), 1.0 - less_n / more_n)
        changes |= {begins_mps(brake): 1.0, ramps_to_mps(brake): 1.0}
    first, last = _regular(found.w)
    lowest = float(np.max(np.append(found.caps.cell[:first], found.caps.cell[last + 1 :]), initial=0.0))
    within = [v for v in changes if v > 0.0 and lowest <= v**2 < float(found.caps.cell.max())]
    chosen = sorted(within, key=lambda v: -changes[v])[:_MOST_KINKS]
    return np.square(np.sort(np.array(chosen, dtype=np.float64)))
