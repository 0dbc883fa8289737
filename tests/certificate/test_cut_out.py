"""The speed at which a dynamic brake cuts out as a train slows down."""

import pytest

from tests.helpers.brake_case import CUTS_OUT, DROPS, metro
from tgvdp.certificate.cut_out import cut_out_w
from tgvdp.physics.forces import kernel_train


@pytest.mark.parametrize(
    ("points", "cut_mps"),
    [
        (CUTS_OUT, 2.2),
        (DROPS, 0.0),
        (((0.0, 0.0), (1.0, 0.0), (3.0, 150e3), (22.0, 100e3)), 90.0 / 74.7),  # rises evenly and steeply
        (((0.0, 0.0), (0.5, 0.0), (3.0, 150e3), (22.0, 100e3)), 0.0),  # not steeply, for where it begins
        (((0.0, 0.0), (4.0, 0.0), (5.5, 40e3), (22.0, 40e3)), 0.0),  # it is nearly all there when runs use it
        (((0.0, 0.0), (2.0, 0.0), (2.0, 8e3), (22.0, 100e3)), 0.0),  # begins with next to nothing
        (((0.0, 0.0), (22.0, 0.0)), 0.0),
        (((0.0, 1.0), (5.0, 1.0), (5.0, 150e3), (22.0, 95e3)), 5.0),  # next to nothing below
        (((0.0, 150e3), (1.0, 150e3), (1.0, 0.0), (5.0, 0.0), (5.0, 150e3), (22.0, 95e3)), 0.0),
    ],
)
def test_the_speed_at_which_a_dynamic_brake_cuts_out(points, cut_mps):
    assert cut_out_w(kernel_train(metro(points))) == pytest.approx(cut_mps**2)
