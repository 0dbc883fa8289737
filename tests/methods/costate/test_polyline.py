"""The costate polyline is made to rise: as the slope of the convex hull of what lies under it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tgvdp.methods.costate.polyline import Polyline, make_monotone, make_rise

_VALUES = st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(-1.0, 1.0)), min_size=1, max_size=30)


def _line(steps):
    """A polyline of steps of w and values of p."""
    return Polyline(np.cumsum([step for step, _ in steps]), np.array([p for _, p in steps]))


def _area(line):
    return float(np.trapezoid(line.p, line.w))


@settings(deadline=None)  # the first call compiles
@given(_VALUES)
def test_it_rises_and_stays_between_what_was_there(steps):
    line = _line(steps)
    before = line.p.copy()
    make_rise(line, 0, len(before), False)
    assert np.all(np.diff(line.p) >= -1e-12)
    assert line.p.min() >= before.min() - 1e-12
    assert line.p.max() <= before.max() + 1e-12


@settings(deadline=None)  # the first call compiles
@given(_VALUES)
def test_what_rises_stays_as_it_is(steps):
    line = _line(steps)
    line.p.sort()
    before = line.p.copy()
    make_rise(line, 0, len(before), False)
    np.testing.assert_array_equal(line.p, before)


def test_a_narrow_dent_does_not_decide_about_what_is_beyond_it():
    """The running maximum put 0.03 everywhere above 10.01."""
    w = np.array([0.0, 10.0, 10.0, 10.01, 10.01, 20.0])
    line = Polyline(w, np.array([-0.2, -0.1, 0.03, 0.03, -0.1, 0.0]))
    before = _area(line)
    make_rise(line, 0, len(w), False)
    assert _area(line) == pytest.approx(before, rel=1e-3)
    np.testing.assert_allclose(line.p, [-0.2, -0.1, -0.1, -0.1, -0.1, 0.0], atol=0.02)
    assert line.w[4] < 11.0


def test_there_lies_as_much_under_it_as_before():
    """A step down between two levels becomes their mean, by their widths."""
    line = Polyline(np.array([0.0, 0.0, 3.0, 3.0, 4.0, 4.0]), np.array([-1.0, 0.0, 0.0, -0.4, -0.4, 1.0]))
    make_rise(line, 0, 6, False)
    np.testing.assert_allclose(line.p, [-1.0, -0.1, -0.1, -0.1, -0.1, 1.0], rtol=1e-6)


def test_where_the_brake_drops_the_running_maximum_stays():
    line = Polyline(np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, 0.2, -0.5, 0.3]))
    make_rise(line, 0, 4, True)
    np.testing.assert_array_equal(line.p, [-1.0, 0.2, 0.2, 0.3])


def test_p_falls_where_the_dynamic_brake_cuts_out():
    line = Polyline(np.array([0.0, 1.0, 2.0, 3.0]), np.array([-1.0, -0.1, -0.5, -0.2]))
    assert make_monotone(line, 4, 2.5, 2.0, -0.3, False) == 4
    np.testing.assert_allclose(line.p, [-1.0, -0.1, -0.5, -0.35])
    np.testing.assert_allclose(line.w, [0.0, 1.0, 2.0, 2.5])
