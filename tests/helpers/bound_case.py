"""What tests of bounds share: random trips with what their runs cost, and the slopes of a bound for given costates."""

import numpy as np
import pytest

from tests.helpers.twins.trips import random_trip, with_rates
from tgvdp import TgvdpError
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.slopes import SLOPES, fill_slopes
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run


def costs_of(trip, fastest, problem, multiplier_j_per_s):
    """E + λT of optimal runs of many multipliers, and of blends of their policies with full traction, J."""
    mesh, counters = Mesh.of(trip, fastest, 8.0), {"extremals": 0, "runs": 0, "costates": 0}
    for factor in (0.3, 1.0, 4.0):
        policy = mesh.extremal(factor * problem.total(multiplier_j_per_s), counters).switch
        for share in (0.0, 0.05, 0.4):
            run = mesh.drive(policy + share * (mesh.fast[:, np.newaxis] - policy), counters)
            yield run.energy_j + problem.total(multiplier_j_per_s) * run.time_s


def random_bound(seed):
    """Fastest run of a random trip, its problem, a price of time in J/s, the bound there, the least cost seen in J."""
    trip = with_rates(random_trip(seed), seed)
    try:
        fastest = fastest_run(trip)
    except TgvdpError:
        pytest.skip("no such trip")
    problem = BoundingProblem(trip)
    price = max(fastest.total_energy_j, fastest.balance.wheel_j) / fastest.duration_s
    found = problem.ledger(fastest.position_m - trip.origin_m, fastest.speed_mps**2, price)
    return fastest, problem, price, found, min(costs_of(trip, fastest, problem, price))


def filled(problem, ledger, multiplier, left, right):
    """The bound for costates, per unit of inertia, and its `slopes.fill_slopes`."""
    slopes = np.empty((len(left), 2, SLOPES))
    total = fill_slopes(
        problem.train, problem.energy, ledger.cells, ledger.caps, ledger.w, multiplier, left, right, problem.top_mps,
        problem.pieces, slopes, np.empty(2),
    )  # fmt: skip
    return total, slopes
