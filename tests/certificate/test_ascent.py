"""Ascent of the certificate's costates: each pass is the best of all combinations, and no bound rises above a run."""

import itertools

import numpy as np
import pytest

import tgvdp
from tests.helpers.trips import commuter, trip_on
from tgvdp.certificate.ascent import STEPS, best_steps
from tgvdp.certificate.line import BoundingProblem, Ledger
from tgvdp.runs.fastest import fastest_run

TRIP = trip_on(
    [(0, 30), (3000, 20)],
    [(0, 0), (2000, 8), (4000, -6)],
    length_m=6000.0,
    start_speed_mps=10.0,
    end_speed_mps=12.0,
)


def few_cells(ledger, first, count):
    """A ledger of some cells in a row."""
    part, ends = slice(first, first + count), slice(first, first + count + 1)
    cells = ledger.cells._replace(
        station_m=ledger.cells.station_m[ends], **{n: getattr(ledger.cells, n)[part] for n in ledger.cells._fields[1:]}
    )
    caps = ledger.caps._replace(
        cell=ledger.caps.cell[part], node=ledger.caps.node[ends], rise=ledger.caps.rise[part].copy()
    )
    values = (ledger.bound[part], ledger.doubt[part], ledger.left[part], ledger.right[part])
    return Ledger(*(value.copy() for value in values), cells, caps, ledger.w[ends].copy(), ledger.label[part])


def one_pass(problem, ledger, multiplier, size):
    left, right, count = ledger.left.copy(), ledger.right.copy(), len(ledger.left)
    total = best_steps(
        problem.train, problem.energy, ledger.cells, ledger.caps, ledger.w, multiplier, left, right, size,
        problem.top_mps, problem._pieces, np.empty((2, STEPS)), np.empty((count, 2, STEPS), dtype=np.int8),
    )  # fmt: skip
    return total, left, right


@pytest.mark.nojit
@pytest.mark.parametrize(("first", "seed"), [(0, 1), (40, 2), (120, 3)])
def test_a_pass_takes_the_best_of_all_combinations_of_steps(first, seed):
    problem, profile = BoundingProblem(TRIP), fastest_run(TRIP)
    multiplier = 2e3
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, multiplier)
    ledger = few_cells(ledger, first, 3)
    multiplier /= problem.train.inertia_kg
    rng = np.random.default_rng(seed)
    ledger.left[:] = -rng.uniform(0.0, 1.0, 3)
    ledger.right[:] = np.append(ledger.left[1:], -0.3)  # no jumps but those that a pass makes
    size = rng.uniform(0.01, 0.2, (3, 2))
    total, left, right = one_pass(problem, ledger, multiplier, size)
    combinations = (np.array(steps) for steps in itertools.product((-1, 0, 1), repeat=6))
    brute = max(
        problem.evaluate(
            ledger, multiplier, ledger.left + by[:3] * size[:, 0], ledger.right + by[3:] * size[:, 1]
        ).total
        for by in combinations
    )
    assert total == pytest.approx(brute, rel=1e-12)
    assert problem.evaluate(ledger, multiplier, left, right).total == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_ascent_mends_costates_that_are_a_fifth_off_and_never_rises_above_a_run(energy):
    train = commuter(traction_efficiency=0.9, regeneration_efficiency=0.7)
    result = tgvdp.search(train, TRIP.track, start_speed_mps=10.0, end_speed_mps=12.0, points=8, energy=energy)
    problem = BoundingProblem(result.trip)
    point, price = 4, result.price_kwh_per_min[4] * 6e4
    time_s, energy_j = result.front.time_s[point], result.front.energy_j[point]
    profile = result.profile(point)
    multiplier = problem.total(price) / problem.train.inertia_kg
    ledger = problem.ledger(profile.position_m, profile.speed_mps**2, price)
    poor = problem.evaluate(ledger, multiplier, 0.8 * ledger.left, 0.8 * ledger.right)
    good = problem._ascended(poor, multiplier, 1e-6 * energy_j)
    poor_pct, good_pct = (
        100.0 * (1.0 - (problem.train.inertia_kg * (found.total - found.error) - price * time_s) / energy_j)
        for found in (poor, good)
    )
    assert poor_pct > 5.0
    assert -1e-4 < good_pct < 0.2 * poor_pct
