"""The costate polyline passes each level once, where the least energy says so, and is as it was elsewhere."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tgvdp.methods.costate.polyline import Polyline, cross_once, make_unique

_STEPS = st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(-1.0, 1.0)), min_size=1, max_size=30)
_LEVEL = -0.2


def _line(steps):
    """A polyline of steps of w and values of p."""
    return Polyline(np.cumsum([step for step, _ in steps]), np.array([p for _, p in steps]))


def _least(line):
    """Where the integral of p − level is least, by many small steps."""
    w = np.unique(np.concatenate((line.w, np.linspace(line.w[0], line.w[-1], 4001))))
    middle = 0.5 * (w[1:] + w[:-1])
    area = np.append(0.0, np.cumsum((np.interp(middle, line.w, line.p) - _LEVEL) * np.diff(w)))
    return w[np.flatnonzero(area <= area.min() + 1e-12)]


@settings(deadline=None)  # the first call compiles
@given(_STEPS)
def test_it_passes_the_level_once(steps):
    line = _line(steps)
    before = line.p.copy()
    cross_once(line, 0, len(before), _LEVEL)
    above = line.p >= _LEVEL
    assert np.all(np.diff(above.astype(int)) >= 0)
    stays = (line.p != _LEVEL) & (line.p != _LEVEL - 1e-12)
    np.testing.assert_array_equal(line.p[stays], before[stays])


@settings(deadline=None)  # the first call compiles
@given(st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-1.0, 1.0)), min_size=2, max_size=12))
def test_it_does_so_where_the_least_energy_is_least_against_the_level(steps):
    line = _line(steps)
    least = _least(line)
    cross_once(line, 0, len(line.p), _LEVEL)
    at = int(np.argmax(line.p >= _LEVEL)) if (line.p >= _LEVEL).any() else len(line.p)
    low = line.w[at - 1] if at > 0 else line.w[0]
    high = line.w[at] if at < len(line.w) else line.w[-1]
    assert any(low - 2e-3 <= w <= high + 2e-3 for w in least)


@settings(deadline=None)  # the first call compiles
@given(_STEPS)
def test_what_rises_stays_as_it_is(steps):
    line = _line(steps)
    line.p.sort()
    before = line.p.copy()
    cross_once(line, 0, len(before), _LEVEL)
    np.testing.assert_array_equal(line.p, before)


def test_a_narrow_dent_does_not_decide_about_what_is_beyond_it():
    """The running maximum put 0.03 everywhere above 10.01."""
    w = np.array([0.0, 10.0, 10.0, 10.01, 10.01, 20.0])
    line = Polyline(w, np.array([-0.2, -0.1, 0.03, 0.03, -0.1, 0.0]))
    cross_once(line, 0, len(w), 0.0)
    np.testing.assert_allclose(line.p, [-0.2, -0.1, 0.0, 0.0, -0.1, 0.0], atol=1e-9)
    assert np.argmax(line.p >= 0.0) == 5


def test_points_of_no_width_decide_nothing():
    """Two images in one place, one on either side of the level, were both put above it."""
    line = Polyline(np.array([4.0, 4.0, 4.0]), np.array([-0.6, -0.6, -0.1]))
    cross_once(line, 0, 3, _LEVEL)
    np.testing.assert_array_equal(line.p, [-0.6, -0.6, -0.1])
    below = Polyline(np.array([4.0, 4.0]), np.array([-0.6, -0.3]))
    cross_once(below, 0, 2, _LEVEL)
    np.testing.assert_array_equal(below.p, [-0.6, -0.3])


def test_p_may_fall_between_two_levels():
    """Its hull hid what is worth less there: runs braked too early, or too late."""
    line = Polyline(np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, -0.05, -0.15, -0.1]))
    assert make_unique(line, 4, 2.5, _LEVEL, 0.0, False, False) == 4
    np.testing.assert_allclose(line.p, [-1.0, -0.05, -0.15, -0.125])
    np.testing.assert_allclose(line.w, [0.0, 1.0, 2.0, 2.5])


def test_where_no_dynamic_brake_works_its_level_means_nothing():
    """Runs braked from far away, as what they coast below the speed at which it begins is worth more than that."""
    line = Polyline(np.array([0.0, 1.0, 1.999, 2.0, 3.0, 4.0]), np.array([-1.0, -0.05, -0.04, -0.3, -0.25, -0.1]))
    assert make_unique(line, 6, 4.0, _LEVEL, 2.0, False, False) == 6
    np.testing.assert_array_equal(line.p, [-1.0, -0.05, -0.04, -0.3, -0.25, -0.1])


def test_where_images_overlap_the_higher_p_is_right():
    line = Polyline(np.array([0.0, 2.0, 1.5, 3.0]), np.array([-1.0, -0.1, -0.15, -0.05]))
    assert make_unique(line, 4, 3.0, _LEVEL, 0.0, False, False) == 4
    np.testing.assert_array_equal(line.w, [0.0, 2.0, 2.0, 3.0])
    np.testing.assert_array_equal(line.p, [-1.0, -0.1, -0.1, -0.05])


def test_a_line_that_stays_below_its_levels():
    line = Polyline(np.array([0.0, 1.0, 2.0]), np.array([-1.0, -0.7, -0.8]))
    assert make_unique(line, 3, 2.0, _LEVEL, 0.0, False, False) == 3
    assert line.p.max() == pytest.approx(-0.7)
