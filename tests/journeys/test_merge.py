"""The exact merge of fronts: equal to trying every combination, convex or not."""

import itertools

import numpy as np
import pytest

from tgvdp.journeys.merge import least_sums


def brute_force(parts_j):
    """Least sum for each total of steps, over all combinations."""
    best = {}
    for steps in itertools.product(*(range(len(part)) for part in parts_j)):
        energy_j = parts_j[0][steps[0]]
        for part, step in zip(parts_j[1:], steps[1:], strict=True):
            energy_j = energy_j + part[step]  # in the order of the merge: equal to the last bit
        best[sum(steps)] = min(best.get(sum(steps), np.inf), energy_j)
    return np.array([best[total] for total in sorted(best)])


@pytest.mark.parametrize("seed", range(20))
def test_the_merge_is_every_combination(seed):
    random = np.random.default_rng(seed)
    parts_j = [np.sort(random.uniform(1e6, 1e8, random.integers(1, 8)))[::-1] for _ in range(random.integers(1, 6))]
    sums = least_sums(parts_j)
    assert sums.energy_j.tolist() == brute_force(parts_j).tolist()
    assert sums.steps.sum(axis=1).tolist() == list(range(len(sums.energy_j)))
    for energy_j, steps in zip(sums.energy_j, sums.steps, strict=True):
        assert energy_j == pytest.approx(sum(part[step] for part, step in zip(parts_j, steps, strict=True)))


def test_a_front_that_is_not_convex_keeps_its_points_above_the_hull():
    step_down = np.array([10.0, 9.9, 0.0])  # nothing at the first step, all at the second
    assert least_sums([step_down, step_down]).energy_j.tolist() == [20.0, 19.9, 10.0, 9.9, 0.0]
