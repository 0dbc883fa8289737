"""The certificate of trains whose effort drops from gear to gear, or falls steeply: chords instead of tangents."""

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Track, Train
from tgvdp.certificate import line as problem
from tgvdp.certificate import lines

RAILCAR = Train(
    name="railcar", mass_kg=70e3, rotating_mass_factor=1.08, friction_brake_n=30e3, davis_a_n=1900.0,
    davis_c_n_per_mps2=4.0,
    traction=EffortCurve.from_points(
        [(0, 94e3), (9, 38e3), (14, 32e3), (14.5, 26e3), (19.5, 23e3), (20, 19e3), (24.5, 18e3), (25, 15e3), (34, 13e3)]
    ),
)  # fmt: skip
LEVEL = Track(length_m=10e3, speed_limits=((0.0, 33.0),))
LIMITS = Track(
    length_m=10e3,
    speed_limits=((0.0, 33.0), (4000.0, 16.0), (5000.0, 28.0)),
    gradients=((0.0, 0.0), (2000.0, 5.0), (6000.0, -3.0)),
)


#: Full effort does not keep the speed up the climb: the run comes down along the speed bound, to behind a drop.
CLIMB = Track(length_m=8e3, speed_limits=((0.0, 33.0),), gradients=((0.0, 0.0), (2500.0, 22.0), (6000.0, -2.0)))


@pytest.mark.parametrize(("track", "most_pct"), [(LEVEL, 0.1), (LIMITS, 0.12), (CLIMB, 0.2)])
def test_gaps_of_a_train_with_gears(track, most_pct):
    result = tgvdp.search(RAILCAR, track, points=12)
    certificate = result.certify()
    assert certificate.gap_pct.min() > -0.01
    assert certificate.gap_pct.max() < most_pct
    other = tgvdp.search(RAILCAR, track, method="exact", segment_m=500.0, speeds=14)
    for time_s, energy_j in zip(other.path_time_s, other.path_energy_j, strict=True):
        assert energy_j >= certificate.at(time_s) * (1.0 - 3e-4)


def _without_ascent(monkeypatch):
    monkeypatch.setattr(lines, "_MOST_IN_VAIN", 0)
    monkeypatch.setattr(lines.LinesUnder, "refine", lambda under, clock: None)


def _without_chords(monkeypatch):
    for kernel in ("raise_pulling", "lower_braking"):
        monkeypatch.setattr(problem, kernel, lambda *_: None)
    _without_ascent(monkeypatch)  # which would find them


def test_the_costate_equation_alone_is_much_looser(monkeypatch):
    result = tgvdp.search(RAILCAR, LEVEL, points=6)
    tight = result.certify().gap_pct
    _without_chords(monkeypatch)
    loose = result.certify().gap_pct
    assert (loose[1:3] > 4.0 * tight[1:3]).all()
    assert (loose[1:] > tight[1:]).all()


@pytest.mark.parametrize("train", [RAILCAR, tgvdp.load_train("alstom-emu")], ids=lambda train: train.name)
def test_chords_never_loosen_a_line(train, monkeypatch):
    result = tgvdp.search(train, LIMITS, points=6)
    bounding = problem.BoundingProblem(result.trip)
    cases = [
        (profile.position_m, profile.speed_mps**2, multiplier_j_per_s)
        for profile in (result.profile(0), result.profile(2), result.profile(5))
        for multiplier_j_per_s in (1e5, 1e6, 1e7)
    ]
    with_chords = np.array([bounding.line(*case) for case in cases])
    _without_chords(monkeypatch)
    without = np.array([bounding.line(*case) for case in cases])
    assert (with_chords >= without).all()
    assert (with_chords > without).any()


@pytest.mark.parametrize("multiplier_j_per_s", [3e4, 1e6, 3e7])
def test_a_bound_pieced_together_is_that_of_its_costates(multiplier_j_per_s):
    """Chords are kept where they are better: the bounds of the other cells are not made anew."""
    result = tgvdp.search(RAILCAR, LIMITS, points=6)
    profile, bounding = result.profile(1), problem.BoundingProblem(result.trip)
    ledger = bounding.ledger(profile.position_m, profile.speed_mps**2, multiplier_j_per_s)
    again = bounding.evaluate(ledger, multiplier_j_per_s / bounding.train.inertia_kg, ledger.left, ledger.right)
    np.testing.assert_array_equal(again.bound, ledger.bound)
    np.testing.assert_array_equal(again.doubt, ledger.doubt)


def test_trains_of_constant_power_keep_the_costate_equation(monkeypatch):
    train = Train(
        mass_kg=200e3, traction=EffortCurve.from_caps(300e3, 2.5e6), friction_brake_n=200e3, davis_a_n=4000.0,
        davis_c_n_per_mps2=9.0, max_acceleration_mps2=1.0,
    )  # fmt: skip
    result = tgvdp.search(train, LIMITS, points=6)
    _without_ascent(monkeypatch)
    gap_pct = result.certify().gap_pct
    _without_chords(monkeypatch)
    np.testing.assert_array_equal(result.certify().gap_pct, gap_pct)
