"""Points of a front by their index, and what is none."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import ArgumentError

WRONG = [
    (5, "index must be a whole number from -5 to 4, got 5"),
    (-6, "index must be a whole number from -5 to 4, got -6"),
    ("a", "index must be a whole number from -5 to 4, got 'a'"),
    (1.0, "index must be a whole number from -5 to 4, got 1.0"),
    (True, "index must be a whole number from -5 to 4, got True"),
    (None, "index must be a whole number from -5 to 4, got None"),
]


@pytest.fixture(scope="module")
def result():
    return tgvdp.search("tgv", "flat-100km", destination_m=5000.0, points=5)


@pytest.fixture(scope="module")
def journey():
    return tgvdp.journey(METRO, LINE, points=5)


@pytest.mark.parametrize(("index", "said"), WRONG)
@pytest.mark.parametrize(
    "method", ["profile", "instructions", "advice", "row_count", "linear_margin", "plot_run", "profile_to_pandas"]
)
def test_a_search_has_no_such_point(result, method, index, said):
    """It was an IndexError or a TypeError of numpy."""
    with pytest.raises(ArgumentError) as error:
        getattr(result, method)(index)
    assert str(error.value) == f"result: {said}"


@pytest.mark.parametrize(("index", "said"), WRONG)
@pytest.mark.parametrize("method", ["profile", "section_profiles", "advice", "linear_margin"])
def test_a_journey_has_no_such_point(journey, method, index, said):
    with pytest.raises(ArgumentError) as error:
        getattr(journey, method)(index)
    assert str(error.value) == f"journey: {said}"


def test_pictures_and_delays_of_a_journey_have_no_such_point(journey):
    with pytest.raises(ArgumentError, match="index must be a whole number from -5 to 4, got 7"):
        journey.plot("allocation", 7)
    with pytest.raises(ArgumentError, match="index must be a whole number from -5 to 4, got 'a'"):
        journey.robustness("a")


def test_points_count_from_both_ends_and_by_whole_numbers_of_any_kind(result, journey):
    for one in (result, journey):
        last = one.profile(4)
        for index in (-1, np.int64(4), np.uint8(4)):
            np.testing.assert_array_equal(one.profile(index).speed_mps, last.speed_mps)


def test_margins_are_named(journey):
    margins = journey.margins("5%")
    for method in (margins.profile, margins.deviations):
        with pytest.raises(ArgumentError) as error:
            method("mareco")
        assert str(error.value) == "margins: name must be one of linear, economy, uniform, optimum, got 'mareco'"
