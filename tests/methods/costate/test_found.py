"""Runs that a search found, as a table."""

import numpy as np
import pytest

from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.mesh import Run
from tgvdp.runs.batch import Batch
from tgvdp.runs.followed import Followed


def run(number):
    x_m = np.linspace(0.0, 1.0, number + 2)
    return Run(10.0 + number, 5.0 - number, 0.1 * number, x_m, number + x_m)


def check(found, numbers):
    assert found.rows.size == len(found.outcome) == len(numbers)
    for index, number in enumerate(numbers):
        one = run(number)
        assert tuple(found.outcome[index]) == one[:3]
        np.testing.assert_array_equal(found.rows.run(index), (one.x_m, one.w))


@pytest.mark.parametrize("numbers", [[3], [0, 1, 2], [5, 2, 4, 1]])
def test_a_table_has_the_runs_that_it_was_made_of(numbers):
    check(Found.of([run(number) for number in numbers]), numbers)


def test_tables_are_joined_and_picked_from():
    found = Found.joined([Found.of([run(0), run(1)]), Found.none(), Found.of([run(2)])])
    check(found, [0, 1, 2])
    check(found.picked(np.array([2, 0])), [2, 0])
    check(found.picked(np.array([], dtype=np.int64)), [])
    assert found.picked(np.arange(3)) is found
    check(Found.none(), [])


def test_neighbouring_runs_of_a_batch_are_a_batch():
    batch = Found.of([run(number) for number in range(5)]).rows
    part = batch.part(slice(1, 4))
    assert part.size == 3 and part.first.tolist() == [0, 3, 7, 12]
    for index in range(3):
        np.testing.assert_array_equal(part.run(index), batch.run(index + 1))
    assert Batch.joined([batch]) is batch


@pytest.mark.parametrize("told", [False, True])
def test_one_of_some_true_runs_has_its_regimes(told):
    batch = Found.of([run(number) for number in range(3)]).rows
    regime = np.arange(len(batch.x_m), dtype=np.int8) if told else None
    true = Followed(batch, regime, np.arange(3.0), -np.arange(3.0))
    for index in range(3):
        one = true.part(index)
        np.testing.assert_array_equal(one.runs.run(0), batch.run(index))
        assert one.time_s.tolist() == [index] and one.energy_j.tolist() == [-index]
        np.testing.assert_array_equal(one.regimes(0), true.regimes(index))
        assert told == (one.regimes(0) is not None)
