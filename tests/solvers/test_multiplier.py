"""The unary form with a multiplier: bound, graph, outer loop and repair."""

import itertools

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance, random_instance
from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.binary import features_of_speeds
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.penalties import best_multiplier
from tgvdp.formulations.qubo.unary import encode_unary
from tgvdp.solvers.allowance import Allowance, BetaRange
from tgvdp.solvers.greedy import repaired
from tgvdp.solvers.registry import solve

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")


def lowest(instance, multiplier):
    """Least energy over all strings of the form with a multiplier, by enumeration."""
    return encode_unary(instance, 1e3, multiplier=multiplier).qubo.all_energies().min()


@pytest.mark.parametrize("model", ["constant", "kinetic", "efficiency"])
def test_the_best_multiplier_gives_the_best_lower_bound(model):
    one = binary_instance(6, model=model, alpha=0.3, distance_units=5.0, dv_mps=0.5)
    optimum = solve(one, "dp").objective
    best = best_multiplier(one)
    bound = lowest(one, best)
    assert bound <= optimum + 1e-9
    for shift in (-0.2, -0.01, 0.01, 0.2):
        assert lowest(one, best + shift * 0.25) <= bound + 1e-9
    assert encode(one, "unary+multiplier").qubo.all_energies().min() == pytest.approx(bound, rel=1e-9)


def test_a_multiplier_leaves_a_strip_of_few_couplers():
    square, strip = (encode(binary_instance(16), word).qubo.stats for word in ("unary", "unary+multiplier"))
    assert square.variables == strip.variables
    assert square.couplers == square.variables * (square.variables - 1) // 2
    assert strip.couplers < 4 * strip.variables


def test_between_two_corners_of_the_hull_no_multiplier_makes_the_optimum_the_minimum():
    """N = 6: distances up to 5 take one climb, up to 8 two; the hull's edge from 5 to 8 leaves 6 and 7 out."""
    one = binary_instance(6, distance_units=6.0)
    for multiplier in np.linspace(-1.0, 1.0, 81):
        encoded = encode_unary(one, 1e3, multiplier=float(multiplier))
        energies = encoded.qubo.all_energies()
        assert energies.min() < solve(one, "dp").objective - 1e-3


def test_the_repair_meets_the_distance_by_the_cheapest_single_moves():
    rng = np.random.default_rng(3)
    limits = np.array([0, 1, 2, 2, 3, 2, 1, 0])
    for _ in range(20):
        target = int(rng.integers(0, int(limits.sum()) + 1))
        one = binary_instance(7, model="kinetic", distance_units=float(target), cap_units=3)
        found = repaired(one, np.array([0, 1, 1, 1, 1, 1, 1, 0]), limits)
        assert abs(np.diff(found)).max() <= 1 and (found <= limits).all() and found.min() >= 0
        if found.sum() == target and target == 7:  # one move from the start: no other is cheaper
            costs = [
                features_of_speeds(one, np.array(v)).exact()
                for v in itertools.product(*(range(limit + 1) for limit in limits))
                if sum(v) == 7 and abs(np.array(v) - [0, 1, 1, 1, 1, 1, 1, 0]).sum() == 1 and abs(np.diff(v)).max() <= 1
            ]
            assert features_of_speeds(one, found).exact() == min(costs)
        assert found.sum() == target or target > 13


def test_the_outer_loop_solves_small_instances_and_never_beats_the_optimum():
    pytest.importorskip("dwave.samplers")
    allowance = Allowance(reads=5, sweeps=100, beta=BetaRange(0.5, 20.0))
    rng = np.random.default_rng(7)
    solved = tried = 0
    while tried < 12:
        one = random_instance(rng)
        if one.acc_units != one.dec_units:
            continue
        try:
            optimum = solve(one, "dp").objective
        except InfeasibleError:
            continue
        tried += 1
        found = solve(one, "multiplier", allowance=allowance)
        if found.feasible:
            assert found.replay["feasible"]
            assert found.objective >= optimum - 1e-9 * abs(optimum)
            assert found.details["best_reads_unrepaired"] <= found.details["best_reads"] <= 5
            solved += abs(found.objective - optimum) <= 1e-9 * abs(optimum)
    assert solved >= 10


def test_unequal_steps_are_refused():
    with pytest.raises(InputError, match="needs equal steps"):
        solve(binary_instance(4, dec_units=2), "multiplier")
