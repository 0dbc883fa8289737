"""Digits that agree: log relative errors, and cases that fail."""

import math

import pytest

from tgvdp.verification.case import MOST_DIGITS, at_most, equal


@pytest.mark.parametrize(
    ("found", "expected", "digits"), [(1.001, 1.0, 3.0), (-99.0, -100.0, 2.0), (5.0, 5.0, MOST_DIGITS), (3.0, 1.0, 0.0)]
)
def test_digits_are_the_log_relative_error(found, expected, digits):
    assert equal("part", "name", found, expected, 1.0).digits == pytest.approx(digits)


def test_errors_of_zero_are_shares_of_a_scale():
    assert equal("part", "name", 1e-4, 0.0, 1.0, scale=100.0).digits == pytest.approx(6.0)
    assert equal("part", "name", 1e-4, 0.0, 1.0).digits == pytest.approx(4.0)


def test_a_bound_is_met_from_one_side():
    assert at_most("part", "name", 7.0, 8.0, 15.0).ok
    assert not at_most("part", "name", 8.1, 8.0, 3.0).ok


def test_too_few_digits_fail():
    assert equal("part", "name", 1.001, 1.0, 2.9).ok
    assert not equal("part", "name", 1.001, 1.0, 3.1).ok


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_number_that_is_none_has_no_digits(number):
    case = equal("part", "name", number, 1.0, 0.1)
    assert (case.digits, case.ok) == (0.0, False)
