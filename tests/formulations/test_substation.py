"""Trains at one substation: what is delivered, the limit, replay, program and QUBO."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.substation_case import all_plans, random_substation, substation
from tgvdp.errors import InputError
from tgvdp.formulations.problem.instances import SubstationInstance
from tgvdp.formulations.problem.reading import parse_instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.substation import delivered, joint_speeds, substation_schedule
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.qubo import bits_of

TRAIN = {"N": 4, "cap_units": 1, "D_units": 3}


def test_braking_feeds_a_train_that_draws_in_the_same_step() -> None:
    instance = substation([TRAIN, TRAIN | {"start": 3}], alpha=0.5)
    table = joint_speeds(instance, [[0, 1, 1, 1, 0], [0, 1, 1, 1, 0]])
    # Train 1 draws 1 in step 0; in step 3 it offers 1, of which half reaches train 2, which draws 1 there: q = 2.
    assert delivered(instance, table).tolist() == [2, 0, 0, 1, 0, 0, 0]


def test_masses_count_and_what_nobody_draws_is_lost() -> None:
    instance = substation([TRAIN | {"mass_units": 3}], alpha=1.0)
    schedule = substation_schedule(instance, [[0, 1, 1, 1, 0]])
    assert schedule.objective == 3 * 0.5 * 2.0**2


def test_the_limit_of_the_substation_is_a_constraint() -> None:
    both = substation([TRAIN, TRAIN], power_units=1)
    plan = [[0, 1, 1, 1, 0]] * 2
    schedule = substation_schedule(both, plan)
    assert [check.name for check in schedule.checks if not check.satisfied] == ["power of the substation"]
    assert not replay(both, schedule)["feasible"]
    assert replay(substation([TRAIN, TRAIN], power_units=2), schedule)["feasible"]


@pytest.mark.parametrize("seed", range(6))
def test_replay_in_si_agrees_with_the_model(seed: int) -> None:
    instance = random_substation(seed)
    rng = np.random.default_rng(seed)
    for _ in range(20):
        speeds = [np.append(0, rng.integers(0, 3, train.trip.steps)) for train in instance.trains]
        schedule = substation_schedule(instance, speeds)
        replayed = replay(instance, schedule)
        assert replayed["objective"] == pytest.approx(schedule.objective, rel=1e-12)
        assert replayed["feasible"] == schedule.feasible


@pytest.mark.parametrize(("alpha", "start", "mass"), [(0.0, 0, 1), (0.5, 1, 2), (1.0, 2, 1)])
def test_the_minimum_of_the_qubo_is_the_optimum(alpha: float, start: int, mass: int) -> None:
    short, other = {"N": 3, "cap_units": 1, "D_units": 1}, {"N": 3, "cap_units": 1, "D_units": 2}
    instance = substation([short, other | {"start": start, "mass_units": mass}], power_units=2, alpha=alpha)
    encoded = encode(instance, "unary")
    energies = encoded.qubo.all_energies()
    schedule = encoded.decode(bits_of(energies.argmin(), encoded.qubo.n))
    best, _ = all_plans(instance)
    assert schedule.feasible
    assert best is not None
    assert schedule.objective == float(best * Fraction(2))  # ½·Δv² with Δv = 2 m/s
    assert energies.min() == pytest.approx(schedule.objective, rel=1e-9)
    # A string breaks nothing exactly where its schedule obeys all constraints and its registers say what is delivered.
    clean = np.flatnonzero(encoded.violation.all_energies() < 0.5)
    assert all(encoded.decode(bits_of(z, encoded.qubo.n)).feasible for z in clean)


def test_a_share_with_more_digits_than_sums_can_hold_is_refused() -> None:
    """With 0.3333333333333333, q = 10¹⁶, sums overflowed and a feasible instance was proved infeasible."""
    tree = {"id": "two", "params": {
        "kind": "substation", "dt_s": 1, "dv_mps": 1, "power_units": 9, "alpha": 0.333333, "trains": [TRAIN, TRAIN],
    }}  # fmt: skip
    instance = parse_instance(Path("two"), tree)
    assert isinstance(instance, SubstationInstance) and instance.alpha == 0.333333
    tree["params"] |= {"alpha": 0.3333333333333333}  # type: ignore[operator]
    with pytest.raises(InputError, match=r"params.alpha: has too many digits"):
        parse_instance(Path("two"), tree)
