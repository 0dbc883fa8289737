"""The plan without search: feasible where it says so, and never better than the optimum."""

import time

import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.instances import SharedTrip, SubstationInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.instances import find, index
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve

NAMES = [n for n, row in index().items() if row["objective"] and row["family"] in ("easy", "zones", "substation")]


@pytest.mark.parametrize("name", [name for name in NAMES if int(index()[name]["N"]) <= 24])
def test_it_is_feasible_and_not_below_the_optimum(name):
    optimum = float(index()[name]["objective"])
    try:
        found = solve(read_instance(find(name)), "greedy")
    except BudgetExceededError:
        assert index()[name]["kind"] == "substation"
        return
    assert found.feasible and found.replay["feasible"] and not found.optimal
    assert found.objective >= optimum * (1.0 - 1e-12)


def test_it_finds_the_optimum_of_single_trains_and_not_of_those_that_share_a_substation():
    off = {
        name: solve(read_instance(find(name)), "greedy").objective / float(index()[name]["objective"])
        for name in ("easy-n012", "kinetic-n012", "zones-n012", "substation-k2-n012")
    }
    assert [name for name, ratio in off.items() if ratio > 1.0] == ["substation-k2-n012"]


def test_unequal_steps_are_refused():
    with pytest.raises(InputError, match="solver greedy needs equal steps"):
        solve(binary_instance(4, dec_units=2), "greedy")


@pytest.mark.parametrize("solver", ["greedy", "multiplier"])
@pytest.mark.parametrize("changes", [{"distance_units": 2.5}, {"acc_units": 2, "dec_units": 2, "distance_units": 3.0}])
def test_distances_between_whole_steps_are_refused(solver, changes):
    """Levels would go up and down around such a distance for ever."""
    if solver == "multiplier":
        pytest.importorskip("dwave.samplers")
    with pytest.raises(InfeasibleError, match="no distance of whole steps"):
        solve(binary_instance(6, **changes), solver)


def test_a_train_of_a_substation_that_cannot_cover_its_distance_is_named():
    """It is no matter of the limit, which is never reached here."""
    trips = (
        binary_instance(6, model="kinetic", distance_units=8.0),
        binary_instance(4, model="kinetic", distance_units=16.0),
    )
    shared = SubstationInstance(
        id="far", dt_s=10.0, dv_mps=1.0, power_units=100, alpha=0.5,
        trains=tuple(SharedTrip(start=0, mass_units=1, trip=trip) for trip in trips),
    )  # fmt: skip
    with pytest.raises(InfeasibleError, match="train 2 alone cannot cover its distance"):
        solve(shared, "greedy")


@pytest.mark.parametrize("solver", ["greedy", "milp"])
def test_a_long_trip_ends_at_the_time_limit(solver):
    """Greedy once kept a table of N × N speeds, and the program was written before any clock was looked at."""
    if solver == "milp":
        pytest.importorskip("scipy.optimize")
    trip = binary_instance(100_000, cap_units=30, distance_units=2_000_000.0)
    start = time.perf_counter()
    with pytest.raises(BudgetExceededError, match="the time limit ended"):
        solve(trip, solver, allowance=Allowance(time_limit_s=0.5))
    assert time.perf_counter() - start < 10.0


def test_trains_of_a_substation_end_at_the_time_limit():
    with pytest.raises(BudgetExceededError, match="the time limit ended before all trains had their turns"):
        solve(read_instance(find("substation-k2-n012")), "greedy", allowance=Allowance(time_limit_s=1e-9))
