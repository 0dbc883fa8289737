"""The line as the referee sees it."""

import pytest

from tests.helpers.line_case import TRAIN
from tgvdp.model.convention import Convention
from tgvdp.model.track import Curve, Track
from tgvdp.model.trip import Trip
from tgvdp.referee.line import see_line


@pytest.mark.parametrize(("radii_m", "mean_permil"), [((800.0, 400.0), 1.5), ((400.0, -800.0), 2.0 / 3.0 + 1.0 / 6.0)])
def test_a_transition_by_800_r_is_exact_in_one_part_on_each_side(radii_m, mean_permil):
    """With 256 parts for each a line of 20,000 transitions took 1.8 s."""
    track = Track(length_m=1000.0, speed_limits=((0.0, 20.0),), curves=(Curve(0.0, *radii_m),))
    convention = Convention(name="curves", curves="800/R")
    trip = Trip(train=TRAIN, track=track, origin_m=0.0, destination_m=1000.0, convention=convention)
    line = see_line(trip)
    assert len(line.force_n) <= 3  # one of them before the line
    newton_per_permil = TRAIN.mass_kg * convention.gravity_mps2 / 1000.0
    assert line.force_nm[-1] / 1000.0 == pytest.approx(mean_permil * newton_per_permil, rel=1e-12)


def test_a_curve_of_300_m_has_one_resistance():
    """Röckl's formula jumps there: by rounding the referee took that of tighter curves at half of the places."""
    gradients = tuple((7.0 * k, 0.0) for k in range(142))
    track = Track(length_m=1000.0, speed_limits=((0.0, 20.0),), gradients=gradients, curves=(Curve(0.0, 300.0, 300.0),))
    convention = Convention(name="curves", curves="roeckl")
    trip = Trip(train=TRAIN, track=track, origin_m=0.0, destination_m=1000.0, convention=convention)
    line = see_line(trip)
    newton_per_permil = TRAIN.mass_kg * convention.gravity_mps2 / 1000.0
    assert line.force_nm[-1] / 1000.0 == pytest.approx(650.0 / 245.0 * newton_per_permil, rel=1e-12)
