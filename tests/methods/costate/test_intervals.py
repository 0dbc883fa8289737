"""Intervals in which a dynamic brake works below speeds at which runs coast: beside stations and policies without."""

import numpy as np
import pytest

from tests.helpers.brake_case import metro
from tgvdp.methods.costate.intervals import matched, through_cell
from tgvdp.physics.cell import Cell, Rows
from tgvdp.physics.forces import kernel_train

FLAT = kernel_train(metro(((0.0, 0.0), (10.0, 0.0), (10.0, 150e3), (22.0, 150e3))))
RAMP = kernel_train(metro(((0.0, 0.0), (10.0, 0.0), (12.0, 150e3), (22.0, 150e3))))


def _through(before, after, train=FLAT):
    """Speeds b, c, e and g before a level cell of 20 m and behind it, to b, e and g."""
    cell = Cell(0.0, 20.0, 20.0, 0.0, 6.0, 400.0)
    squared = [speed_mps**2 for speed_mps in (*before, *after)]
    found = np.sqrt(through_cell(train, cell, *squared, Rows(np.empty(4096), np.empty(4096))))
    return found[:3].tolist(), found[3:].tolist()


def test_two_that_have_one_or_none_stay_as_they_are():
    assert matched(9.0, 12.0, 4.0, 6.0, 9.0, 12.0, 3.0, 5.0) == (9.0, 4.0, 6.0)
    assert matched(9.0, 12.0, 4.0, 4.0, 8.0, 12.0, 4.0, 4.0) == (9.0, 4.0, 4.0)


def test_one_begins_at_no_width_where_that_of_its_neighbour_does():
    assert matched(9.0, 12.0, 0.0, 0.0, 8.0, 12.0, 3.0, 4.0) == (9.0, 3.0, 3.0)


def test_what_is_braked_above_b_has_a_part_that_the_neighbour_coasts():
    assert matched(3.1, 12.0, 0.0, 0.0, 8.0, 12.0, 3.0, 6.0) == (7.0, 3.1, 7.0)
    assert matched(3.1, 6.5, 0.0, 0.0, 8.0, 12.0, 3.0, 6.0) == (6.5, 3.1, 6.5)
    assert matched(3.1, 11.0, 0.0, 0.0, 12.0, 12.0, 3.0, 6.0) == (11.0, 3.1, 11.0)


def test_all_is_braked_where_b_is_the_speed_at_which_the_brake_begins():
    before, after = _through((10.0, 16.0, 10.0, 10.0), (10.0, 15.0, 10.0, 10.0))
    assert before == pytest.approx([16.0, 10.0, 16.0])
    assert after == pytest.approx([15.0, 10.0, 15.0])


def test_but_not_on_a_ramp():
    before, after = _through((10.0, 16.0, 10.0, 10.0), (10.0, 15.0, 10.0, 10.0), RAMP)
    assert before == pytest.approx([10.0, 10.0, 10.0])
    assert after == pytest.approx([10.0, 10.0, 10.0])


def test_what_is_coasted_ends_where_a_run_is_that_brakes_along_b():
    _, (b, e, g) = _through((14.0, 16.0, 10.0, 13.0), (10.0, 15.3, 10.0, 10.0))
    assert b == g < 13.5  # 0.7 m/s² over 20 m
    assert e == 10.0
    _, after = _through((16.0, 16.0, 10.0, 13.0), (10.0, 15.3, 10.0, 10.0))
    assert after == pytest.approx([15.3, 10.0, 15.3])


def test_what_is_coasted_down_to_the_begin_of_the_brake_ends_from_above():
    before, after = _through((14.0, 16.0, 10.0, 10.0), (10.0, 15.3, 10.0, 10.0))
    assert before == pytest.approx([14.0, 10.0, 10.0])
    assert after == pytest.approx([10.0, 10.0, 10.0])


def test_what_is_coasted_begins_amid_the_speeds_at_which_it_is():
    before, _ = _through((10.0, 16.0, 10.0, 10.0), (14.0, 15.3, 10.0, 12.0))
    assert before == pytest.approx([np.sqrt(0.5 * (14.0**2 + 12.0**2)), 10.0, np.sqrt(0.5 * (14.0**2 + 12.0**2))])
    before, _ = _through((10.0, 16.0, 10.0, 10.0), (15.3, 15.3, 10.0, 12.0))
    assert before == pytest.approx([16.0, 10.0, 16.0])
