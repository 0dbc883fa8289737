"""The lowest cap on speeds that is possible."""

import pytest

from tgvdp.runs.caps import lowest_cap_mps


@pytest.mark.parametrize("least_mps", [0.011, 3.0, 17.3, 49.9])
def test_it_is_known_to_a_factor(least_mps):
    found_mps = lowest_cap_mps(lambda cap_mps: cap_mps >= least_mps, 0.01, 50.0, 1.001)
    assert least_mps <= found_mps <= 1.001 * least_mps


def test_what_is_known_well_enough_is_not_tried():
    assert lowest_cap_mps(pytest.fail, 10.0, 10.005, 1.001) == 10.005
