"""Braking rates that depend on the speed: trips of the survey on which points once broke them."""

import math

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tgvdp import EffortCurve, Train
from tgvdp.methods.costate.brake_jumps import saturated_image
from tgvdp.methods.costate.characteristics import Step
from tgvdp.model.train import BrakingRate
from tgvdp.physics.codes import DYNAMIC
from tgvdp.physics.forces import kernel_train, per_kilogram
from tgvdp.units import JOULE_PER_KWH

#: 0.8 km up 17 ‰, which slow the train down more than its brakes may: the envelope is a run that coasts, and what pulls
#: beyond it finds no brakes that bring it back.
CLIMB = 1795378265
#: Below 12 m/s brakes do three and a half times what they do above: the best runs come there before the envelope does.
LATE_RATE = 1799000378
#: A dynamic brake that passes the rate as the train slows down: the last row of a cell made up for what all lacked.
DYNAMIC_BRAKE = 1795377964


@pytest.mark.parametrize("seed", [CLIMB, DYNAMIC_BRAKE])
def test_points_keep_to_braking_rates(seed):
    trip = proof_trip(seed)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    assert all(verdict.ok for verdict in result.verify())


def test_runs_come_early_to_a_speed_below_which_brakes_do_more():
    """They rode the envelope, for costates did not step where braking rates do: that took 0.11 % more energy.

    The energies are those of points that certificates with goals of their own for each line proved to 0.03 %.
    """
    trip = proof_trip(LATE_RATE)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    assert result.certify().gap_pct[8:].max() <= 0.12
    for time_s, energy_j in ((2090.948, 2.261477e9), (2131.137, 2.176361e9), (2170.851, 2.103195e9)):
        assert np.interp(time_s, result.front.time_s, result.front.energy_j) <= energy_j * (1.0 + 2e-4)


@pytest.mark.parametrize("below", [0.0, 0.3, 4.0])
def test_costates_step_where_the_braking_rate_does(below):
    """Against the derivative of what braking costs in closed form: a brake of 0.5 m/s² alone, then a rate of 0.2."""
    slow, fast, step_w, returned, price, length = 0.5, 0.2, 144.0, 0.6, 1.5, 40.0
    train = per_kilogram(
        kernel_train(
            Train(
                mass_kg=1.0, traction=EffortCurve.from_caps(1.0), braking=EffortCurve.from_caps(slow),
                braking_rates=(BrakingRate(0.0, 0.7), BrakingRate(12.0, fast)),
            )
        )
    )  # fmt: skip

    def back(w1):
        """Squared speed before the cell, and what the way through it costs."""
        braked_m = (step_w - w1) / (2.0 * slow)
        w0 = step_w + 2.0 * fast * (length - braked_m)
        seconds = (12.0 - math.sqrt(w1)) / slow + (math.sqrt(w0) - 12.0) / fast
        return w0, price * seconds - returned * (slow * braked_m + fast * (length - braked_m))

    w1, p1, change = step_w - below, -0.1, 1e-5
    step = Step(length, 0.0, 0.0, price, returned, math.inf, math.inf, 1.0, 400.0, step_w, 0.0)
    (ahead_w, ahead), (behind_w, behind) = back(w1 - change), back(w1 - 2.0 * change)
    w0, p0 = saturated_image(train, DYNAMIC, step, length, w1 - 1.5 * change, p1)
    assert w0 == pytest.approx(0.5 * (ahead_w + behind_w), rel=1e-6)
    assert p0 == pytest.approx((ahead - behind + p1 * change) / (ahead_w - behind_w), rel=2e-3)


def test_a_dent_before_a_descent_does_not_decide_about_all_that_is_faster():
    """Above the step of rates, short of a descent, a narrow dent of V told to brake by friction: 0.3 to 8 % dearer."""
    trip = proof_trip(1951297)
    result = tgvdp.search(trip.train, trip.track, points=12, **trip.options)
    assert all(verdict.ok for verdict in result.verify())
    assert result.front.energy_j[8] < 29.7 * JOULE_PER_KWH
    assert result.front.energy_j[10] < 17.6 * JOULE_PER_KWH
