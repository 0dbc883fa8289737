"""Texts of running-time supplements: what they mean, and what is none."""

import math

import pytest

from tgvdp.errors import InputError
from tgvdp.options.texts import parse_margins


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5%", [(0.0, math.inf, (0.05, 0.0, 0.0))]),
        ("4.5min/100km", [(0.0, math.inf, (0.0, 0.0027, 0.0))]),
        ("2s/km", [(0.0, math.inf, (0.0, 0.002, 0.0))]),
        ("90s", [(0.0, math.inf, (0.0, 0.0, 90.0))]),
        ("0:10km:5%, 10 km::1.5min", [(0.0, 1e4, (0.05, 0.0, 0.0)), (1e4, math.inf, (0.0, 0.0, 90.0))]),
        (":500:1%", [(0.0, 500.0, (0.01, 0.0, 0.0))]),
    ],
)
def test_margins(text, expected):
    assert [(one.from_m, one.to_m, one.supplement) for one in parse_margins(text)] == [
        (from_m, to_m, pytest.approx(supplement)) for from_m, to_m, supplement in expected
    ]


@pytest.mark.parametrize("text", ["", "5", "5 %%", "10km:5%", "a:b:5%", "1min/0km", "5%;3%", "0:1:2:5%"])
def test_texts_that_are_no_margins(text):
    with pytest.raises(InputError, match="must be"):
        parse_margins(text)
