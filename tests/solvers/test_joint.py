"""Joint dynamic program, its bound and its descent, and HiGHS, against all plans."""

from fractions import Fraction

import numpy as np
import pytest

from tests.helpers.substation_case import all_plans, random_substation, substation
from tgvdp.errors import InfeasibleError
from tgvdp.formulations.problem.substation import delivered, joint_speeds, shares
from tgvdp.solvers.exact.joint import _keys, joint_plan
from tgvdp.solvers.exact.joint_descent import descend
from tgvdp.solvers.exact.joint_prices import NEVER, SCALE, bound_of, train_of
from tgvdp.solvers.registry import solve


@pytest.mark.parametrize(
    ("seed", "zones"), [*((seed, False) for seed in range(24)), *((seed, True) for seed in range(32, 56))]
)
def test_the_joint_program_and_highs_find_the_optimum_of_all_plans(seed: int, zones: bool) -> None:
    """With ``zones`` the joint program counted plans that are too fast in a slow step, some cheaper than all others."""
    instance = random_substation(seed, trains=2 if seed % 4 else 3, steps=6 if seed % 4 else 5, zones=zones)
    best, count = all_plans(instance)
    if best is None:
        for solver in ("dp", "milp"):
            with pytest.raises(InfeasibleError):
                solve(instance, solver)
        return
    found = joint_plan(instance)
    assert found.proved
    assert (Fraction(found.cost, shares(instance).q), found.n_optimal) == (best, count)
    for solver in ("dp", "milp"):
        solution = solve(instance, solver)
        assert solution.optimal
        assert solution.feasible
        assert solution.replay["feasible"]
        assert solution.objective == float(2 * best)


@pytest.mark.parametrize("seed", range(12))
def test_any_prices_bound_all_plans_from_below_and_the_descent_ends_above(seed: int) -> None:
    instance = random_substation(seed)
    best, _ = all_plans(instance)
    trains = [train_of(train) for train in instance.trains]
    rng = np.random.default_rng(seed)
    q = shares(instance).q
    if any(
        bound_of(instance, trains, np.zeros(instance.steps, dtype=np.int64)).tables[k][0, 0] >= NEVER for k in (0, 1)
    ):
        return  # a train alone cannot arrive
    if best is None:
        assert descend(instance, trains, np.full(instance.steps, SCALE)) is None
        return
    for _ in range(20):
        prices = rng.integers(0, 3 * SCALE, instance.steps)
        assert bound_of(instance, trains, prices).total <= best * q
    plan = descend(instance, trains, np.full(instance.steps, SCALE))
    if plan is not None:
        net = delivered(instance, joint_speeds(instance, plan))
        assert net.max() <= q * instance.power_units
        assert net.sum() >= best * q


def test_a_budget_that_ends_leaves_a_plan_and_a_bound_but_no_proof() -> None:
    trains = [{"N": 12, "cap_units": 4, "D_units": 20 + k, "start": k} for k in range(3)]
    instance = substation(trains, power_units=9, alpha=0.5)
    proved, cut = joint_plan(instance), joint_plan(instance, most_states=3)
    assert proved.proved
    assert not cut.proved
    assert cut.bound <= proved.cost <= cut.cost


def test_a_train_that_cannot_arrive_is_named() -> None:
    instance = substation([{"N": 4, "cap_units": 1, "D_units": 3}, {"N": 4, "cap_units": 1, "D_units": 4}])
    with pytest.raises(InfeasibleError, match="train 2 alone"):
        joint_plan(instance)


def test_states_of_many_trains_are_told_apart() -> None:
    """Eight trains of 10⁴ states have more states together than 64 bits number."""
    trains = [{"N": 8, "cap_units": 4, "D_units": 1000 if k else 16} for k in range(8)]
    tables = [train_of(train) for train in substation(trains).trains]
    states = np.array([[0, 0], *([[5, 5]] * 6), [7, 8]])
    keys = _keys(tables, states)
    assert len(keys) > 1
    assert any(key[0] != key[1] for key in keys)


def test_more_trains_than_joint_actions_can_be_tried_of_get_a_plan_and_a_bound() -> None:
    """Fifteen trains have 14 million joint actions in each step: the search did not end."""
    found = joint_plan(substation([{"N": 4, "cap_units": 2, "D_units": 3} for _ in range(15)], alpha=0.5))
    assert not found.proved
    assert 0 < found.bound <= found.cost


def test_trains_beyond_any_search_get_a_plan_and_a_bound() -> None:
    trains = [{"N": 20, "cap_units": 6, "D_units": 50 + k, "start": k % 3} for k in range(5)]
    found = joint_plan(substation(trains, power_units=60, alpha=0.5), most_states=50)
    assert not found.proved
    assert 0 < found.bound <= found.cost
