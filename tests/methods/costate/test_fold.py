"""Levels that the costate polyline passes three times, and images that turn back."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tgvdp.methods.costate.fold import cross_thrice, unfold
from tgvdp.methods.costate.polyline import Polyline

_STEPS = st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-1.0, 1.0)), min_size=2, max_size=20)
_LEVEL = -0.2


def _line(steps):
    """A polyline of steps of w and values of p."""
    return Polyline(np.cumsum([step for step, _ in steps]), np.array([p for _, p in steps]))


def _sides(line):
    """Which side of the level the polyline is on, part by part, from one below it on."""
    above = [False, *(line.p >= _LEVEL).tolist()]
    return [side for i, side in enumerate(above) if i == 0 or side != above[i - 1]]


@settings(deadline=None)  # the first call compiles
@given(_STEPS)
def test_it_passes_the_level_three_times_at_most(steps):
    line = _line(steps)
    before = line.p.copy()
    cross_thrice(line, 0, len(before), _LEVEL)
    assert len(_sides(line)) <= 4
    stays = (line.p != _LEVEL) & (line.p != _LEVEL - 1e-12)
    np.testing.assert_array_equal(line.p[stays], before[stays])


@settings(deadline=None)  # the first call compiles
@given(_STEPS)
def test_what_passes_it_no_more_often_stays_as_it_is(steps):
    line = _line([(d, p + 1e-3 if abs(p - _LEVEL) < 1e-3 else p) for d, p in steps])
    before = line.p.copy()
    few = len(_sides(line)) <= 4
    cross_thrice(line, 0, len(before), _LEVEL)
    if few:
        np.testing.assert_array_equal(line.p, before)


def test_of_more_the_part_of_least_area_goes():
    w = np.arange(7.0)
    line = Polyline(w, np.array([-1.0, 0.5, -0.3, 0.5, -1.0, 0.5, 0.6]))
    cross_thrice(line, 0, 7, _LEVEL)
    np.testing.assert_allclose(line.p, [-1.0, 0.5, _LEVEL, 0.5, -1.0, 0.5, 0.6])


def test_a_part_of_no_width_goes_in_any_case():
    line = Polyline(np.array([0.0, 1.0, 1.0, 1.0, 2.0]), np.array([-1.0, -0.3, 0.1, -0.3, 0.0]))
    cross_thrice(line, 0, 5, _LEVEL)
    np.testing.assert_allclose(line.p, [-1.0, -0.3, _LEVEL, -0.3, 0.0])


def _least_energy(w, p, at_w):
    """The least V at a squared speed on the rising parts of a curve that may turn back, V = 0 where it begins."""
    energy = np.concatenate(([0.0], np.cumsum(0.5 * (p[1:] + p[:-1]) * np.diff(w))))
    least = np.inf
    for i in range(1, len(w)):
        if w[i - 1] < w[i] and w[i - 1] <= at_w <= w[i]:
            at_p = p[i - 1] + (at_w - w[i - 1]) / (w[i] - w[i - 1]) * (p[i] - p[i - 1])
            least = min(least, energy[i - 1] + 0.5 * (p[i - 1] + at_p) * (at_w - w[i - 1]))
    return least


_RISING = st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(0.0, 0.3)), min_size=1, max_size=6)


@settings(deadline=None)  # the first call compiles
@given(_RISING, _RISING, st.floats(0.1, 0.9), st.floats(0.2, 1.0))
def test_of_images_that_turn_back_the_branch_of_less_energy_is_left(before, after, back, fall):
    """Two branches on which p rises, and a third one, on which it falls, from the end of the one back to the other."""
    w = np.concatenate(([1.0], 1.0 + np.cumsum([d for d, _ in before])))
    p = np.concatenate(([-1.0], -1.0 + np.cumsum([d for _, d in before])))
    foot_w = w[-1] - back * (w[-1] - w[0])
    later_w = foot_w + np.concatenate(([0.0], np.cumsum([d for d, _ in after])))
    later_p = p[-1] - fall + np.concatenate(([0.0], np.cumsum([d for _, d in after])))
    both_w = np.linspace(foot_w, min(w[-1], later_w[-1]), 50)
    assume(np.all(np.interp(both_w, later_w, later_p) <= np.interp(both_w, w, p)))  # V of the third one falls faster
    w, p = np.concatenate((w, later_w)), np.concatenate((p, later_p))
    known = len(before) + 1
    along = np.sum(0.5 * (p[1 : known + 1] + p[:known]) * np.diff(w[: known + 1]))
    assume(along > _least_energy(w[:known], p[:known], foot_w) + 1e-6)  # else p is higher on the way back
    line = Polyline(w.copy(), p.copy())
    n = unfold(line, len(w))
    assert np.all(np.diff(line.w[:n]) >= 0.0)
    peak_w = w[len(before)]
    for at_w in np.linspace(w[0], min(peak_w, line.w[n - 1]), 13):
        energy = _least_energy(line.w[:n], line.p[:n], at_w)
        np.testing.assert_allclose(energy, _least_energy(w, p, at_w), atol=1e-7)


def test_where_p_rises_on_the_way_back_the_images_stay():
    """That is an error of theirs: the higher p is right, as ever."""
    line = Polyline(np.array([0.0, 2.0, 1.5, 3.0]), np.array([-1.0, -0.2, -0.1, -0.05]))
    assert unfold(line, 4) == 4
    np.testing.assert_array_equal(line.w, [0.0, 2.0, 1.5, 3.0])


def test_a_branch_that_never_comes_to_less_energy_goes_on_from_the_peak():
    line = Polyline(np.array([0.0, 2.0, 1.9, 1.9, 3.0]), np.array([-1.0, -0.2, -0.9, -0.2, -0.1]))
    assert unfold(line, 5) == 4
    np.testing.assert_allclose(line.w[:4], [0.0, 2.0, 2.0, 3.0])
    np.testing.assert_allclose(line.p[:4], [-1.0, -0.2, -0.2 + 0.1 / 11.0, -0.1])
