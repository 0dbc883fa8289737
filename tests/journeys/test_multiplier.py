"""One multiplier for all: the split in closed form, and hulls of fronts that are not convex."""

from types import SimpleNamespace

import numpy as np
import pytest

from tgvdp.journeys.multiplier import Demand, demand_of, on_hull, split
from tgvdp.pareto import ParetoFront


def demand(scale, top_s=100.0):
    """What a front E = scale·exp(−T) takes: λ = scale·exp(−T)."""
    supplement_s = np.linspace(0.0, top_s, 5)
    return Demand(supplement_s, np.log(scale) - supplement_s)


def test_the_split_is_the_closed_form():
    """With λ_i = a_i·exp(−T_i) equal for all, T_i = mean + ln a_i − mean of ln a, as long as none is below 0."""
    scales = np.array([1.0, 3.0, 10.0])
    total_s = np.array([6.0, 12.0, 60.0])
    found = split([demand(scale) for scale in scales], total_s)
    expected_s = total_s[:, None] / 3.0 + np.log(scales) - np.log(scales).mean()
    assert found.supplement_s == pytest.approx(expected_s)
    assert np.log(found.multiplier_j_per_s) == pytest.approx(np.log(scales).mean() - total_s / 3.0)


def test_what_saves_least_gets_nothing_of_a_small_supplement():
    found = split([demand(1.0), demand(10.0)], np.array([0.0, 1.0]))
    assert found.supplement_s == pytest.approx(np.array([[0.0, 0.0], [0.0, 1.0]]))
    assert np.isinf(found.multiplier_j_per_s[0])


def test_no_more_is_split_than_all_can_take():
    assert split([demand(1.0, 5.0), demand(2.0, 7.0)], np.array([20.0])).supplement_s.tolist() == [[5.0, 7.0]]


@pytest.mark.parametrize(
    ("energy", "kept"),
    [([4.0, 1.0, 0.0], [0, 1, 2]), ([4.0, 3.9, 0.0], [0, 2]), ([4.0, 2.0, 0.0], [0, 2]), ([4.0], [0])],
)
def test_vertices_of_the_hull(energy, kept):
    assert on_hull(np.arange(len(energy), dtype=float), np.array(energy)).tolist() == kept


@pytest.mark.parametrize("bend_s", [2.1, 3.0, 5.9])
def test_multipliers_between_runs_save_what_lies_between_their_energies(bend_s):
    """Wherever the front bends, which evenly falling multipliers take to be in the middle."""
    times_s, slopes = np.array([0.0, 2.0, 6.0]), np.array([np.inf, 12.0, 10.0])
    energy_j = np.array([200.0, 150.0, 150.0 - 12.0 * (bend_s - 2.0) - 10.0 * (6.0 - bend_s)])
    runs = SimpleNamespace(
        front=ParetoFront.of(times_s, energy_j), supplement_s=times_s, multiplier_j_per_s=slopes
    )  # fmt: skip
    taken = demand_of(runs)
    fine_s = np.linspace(2.0, 6.0, 4001)
    multiplier = np.exp(np.interp(fine_s, taken.supplement_s, taken.log_multiplier))
    saved_j = np.sum(0.5 * (multiplier[1:] + multiplier[:-1]) * np.diff(fine_s))
    assert saved_j == pytest.approx(energy_j[1] - energy_j[2], rel=1e-3)
