"""Mean forces, the arc and marching against quadrature, closed forms and independent integration."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.twins import running
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.train import BrakingRate, Train
from tgvdp.physics import codes
from tgvdp.physics.arc import arc, within_effort_at
from tgvdp.physics.cell import Cell, Rows
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import kernel_train, mean_brake, mean_effort, mean_resistance
from tgvdp.physics.march import march
from tgvdp.physics.motion import land, net_force, net_force_at

CURVES = {
    "constant": EffortCurve.from_caps(2e5),
    "power": EffortCurve.from_caps(2e5, 3e6),
    "table": EffortCurve.from_points([(0, 2e5), (10, 1.8e5), (30, 6e4), (60, 2e4)]),
    "drops": EffortCurve.from_points([(0, 2e5), (10, 2e5), (10, 1.2e5), (25, 9e4), (25, 4e4), (60, 3e4)]),
    "rise": EffortCurve.from_points([(0, 1e5), (12, 1e5), (12, 1.5e5), (60, 8e4)]),
    "polynomial": EffortCurve(
        (EffortPiece(0.0, c0_n=2e5, c1=-1e3, c2=-40.0, c3=0.5), EffortPiece(20.0, power_w=3e6, c0_n=-1e4, c2=2.0))
    ),
}
SPEEDS = [(0.0, 5.0), (0.0, 40.0), (40.0, 0.0), (3.0, 3.0), (9.0, 11.0), (11.0, 9.0), (8.0, 45.0), (10.0, 25.0)]
SPEEDS += [(20.0, 20.0 + 1e-9), (25.0, 10.0), (59.9, 70.0), (1e-6, 2e-6)]
REGIMES = {"traction": TRACTION, "coasting": COASTING, "braking": BRAKING}
speeds = st.floats(0.0, 70.0)


def railcar(curve="power", **changes):
    values = {
        "mass_kg": 3e5,
        "traction": CURVES[curve],
        "braking": CURVES[curve],
        "friction_brake_n": 5e4,
        "rotating_mass_factor": 1.07,
        "davis_a_n": 3e3,
        "davis_b_n_per_mps": 40.0,
        "davis_c_n_per_mps2": 7.0,
    }
    return Train(**(values | changes))


def drive(train, regime, length_m, permil, v0, sign=1.0, target_mps=0.0):
    """Rows of a march: distances and speeds, the start included."""
    rows = Rows(*np.empty((2, 4096)))
    grade = running.grade_n(train, permil)
    cell = Cell(0.0, length_m, length_m, grade, train.davis_c_n_per_mps2, math.inf)
    n = march(kernel_train(train), regime, sign, cell, length_m, v0**2, target_mps**2, rows, 0)[2]
    assert 0 < n < 4096
    return np.concatenate(([0.0], rows.x[:n])), np.sqrt(np.concatenate(([v0 * v0], rows.w[:n])))


def duration_s(x, v):
    return float(np.sum(2.0 * np.diff(x) / (v[1:] + v[:-1])))


@pytest.mark.nojit
@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize(("v0", "v1"), SPEEDS)
def test_mean_effort_is_the_mean_over_distance(name, v0, v1):
    curve = CURVES[name]
    expected = running.mean_over_distance(curve.effort_n, v0, v1, running.breaks_of(curve))
    assert mean_effort(curve.table, v0, v1) == pytest.approx(expected, rel=1e-6 if abs(v1 - v0) < 1e-6 else 1e-11)


def test_mean_effort_has_closed_forms():
    assert mean_effort(CURVES["constant"].table, 3.0, 30.0) == 2e5
    assert mean_effort(CURVES["power"].table, 20.0, 30.0) == pytest.approx(3e6 * 2 / 50, rel=1e-15)
    # 15 m/s is the corner of 200 kN and 3 MW: distance weights are differences of v².
    expected = (2e5 * (15**2 - 10**2) + 3e6 * 2 * (25 - 15)) / (25**2 - 10**2)
    assert mean_effort(CURVES["power"].table, 10.0, 25.0) == pytest.approx(expected, rel=1e-14)
    assert mean_effort(CURVES["power"].table, 0.0, 0.0) == 2e5


@pytest.mark.nojit
@pytest.mark.parametrize(("v0", "v1"), SPEEDS)
def test_mean_resistance_and_brake(v0, v1):
    train = railcar()
    kernel = kernel_train(train)
    rel = 1e-6 if abs(v1 - v0) < 1e-6 else 1e-11
    expected = running.mean_over_distance(train.resistance_n, v0, v1)
    assert mean_resistance(kernel, train.davis_c_n_per_mps2, v0, v1) == pytest.approx(expected, rel=rel)
    brakes = running.mean_over_distance(lambda v: running.brake_n(train, v), v0, v1, running.breaks_of(train.braking))
    assert mean_brake(kernel, 0.0, v0, v1) == pytest.approx(brakes, rel=rel)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.sampled_from(sorted(CURVES)), speeds, speeds, st.floats(0.1, 5e4), st.floats(-40.0, 40.0))
def test_arc_agrees_with_its_definition(name, v0, v1, length_m, permil):
    train = railcar(name, max_acceleration_mps2=0.9, max_deceleration_mps2=1.1)
    if v0 + v1 < 1e-3:
        return
    status, seconds, work = arc(
        kernel_train(train), length_m, running.grade_n(train, permil), train.davis_c_n_per_mps2, v0**2, v1**2
    )
    expected_s, expected_j = running.arc(train, length_m, permil, v0, v1)
    scale = train.inertia_kg * (v0**2 + v1**2) + length_m * 1e4
    assert seconds == pytest.approx(expected_s, rel=1e-6)
    assert work == pytest.approx(expected_j, rel=1e-9, abs=1e-9 * scale)
    assert (status == codes.OK) == running.arc_fits(train, length_m, permil, v0, v1)


def test_arc_from_standstill_and_at_standstill():
    train = kernel_train(railcar())
    status, seconds, work = arc(train, 100.0, 0.0, 7.0, 0.0, 9.0)
    assert (status, seconds) == (codes.OK, pytest.approx(200.0 / 3.0))
    assert work > 0.5 * train.inertia_kg * 9.0
    assert arc(train, 100.0, 0.0, 7.0, 0.0, 0.0)[0] == codes.STANDSTILL


@pytest.mark.parametrize("name", CURVES)
def test_on_short_segments_the_mean_limit_is_the_pointwise_limit(name):
    train = railcar(name)
    kernel = kernel_train(train)
    for v in np.linspace(0.5, 55.0, 40):
        if any(abs(v - at) < 0.1 for at in running.breaks_of(train.traction)):
            continue
        for share, fits in ((0.995, True), (1.005, False)):
            acceleration = (share * train.traction.effort_n(v) - train.resistance_n(v)) / train.inertia_kg
            after = v * v + 2.0 * acceleration * 0.05
            assert (arc(kernel, 0.05, 0.0, 7.0, v * v, after)[0] == codes.OK) == fits
            assert within_effort_at(kernel, 0.0, 7.0, acceleration, v) == fits


CASES = [
    ("traction", "constant", 800.0, 0.0, 0.0),
    ("traction", "power", 3000.0, 0.0, 0.0),
    ("traction", "power", 60000.0, 5.0, 0.0),  # approaches the balancing speed
    ("traction", "table", 2000.0, -4.0, 0.0),
    ("traction", "polynomial", 2000.0, 2.0, 1.0),
    ("traction", "rise", 1500.0, 0.0, 0.0),
    ("traction", "power", 4000.0, 38.0, 33.0),  # slows down on a climb
    ("coasting", "power", 5000.0, 0.0, 30.0),
    ("coasting", "power", 3000.0, -12.0, 0.0),  # rolls off downhill
    ("coasting", "power", 300.0, 60.0, 30.0),  # loses speed faster than comfort would let it brake
    ("traction", "power", 300.0, -60.0, 5.0),  # gains speed faster than comfort would let it pull
    ("braking", "constant", 900.0, 0.0, 40.0),
    ("braking", "table", 400.0, -20.0, 30.0),
    ("braking", "power", 300.0, 10.0, 25.0),
]


@pytest.mark.parametrize(("regime", "curve", "length_m", "permil", "v0"), CASES)
@pytest.mark.parametrize("comfort", [math.inf, 0.45])
def test_march_follows_the_equation_of_motion(regime, curve, length_m, permil, v0, comfort):
    train = railcar(curve, max_acceleration_mps2=comfort, max_deceleration_mps2=comfort)
    x, v = drive(train, REGIMES[regime], length_m, permil, v0)
    speed, seconds = running.follow(train, regime, length_m, permil, v0)
    assert x[-1] == length_m
    assert v[-1] == pytest.approx(speed, rel=3e-4)
    assert duration_s(x, v) == pytest.approx(seconds, rel=2e-4)
    assert (np.diff(x) > 0.0).all()


@pytest.mark.parametrize(
    ("regime", "curve", "length_m", "permil", "v0"),
    [case for case in CASES if case[2] < 1e4],  # backwards the balancing speed repels: 60 km cannot be undone
)
def test_march_backwards_returns(regime, curve, length_m, permil, v0):
    train = railcar(curve)
    v0 = max(v0, 2.0)
    _, v = drive(train, REGIMES[regime], length_m, permil, v0)
    _, back = drive(train, REGIMES[regime], length_m, permil, v[-1], sign=-1.0)
    assert back[-1] ** 2 == pytest.approx(v0**2, abs=3e-4 * v.max() ** 2)


def test_march_stops_at_its_target_and_where_the_train_stalls():
    train = railcar()
    x, v = drive(train, TRACTION, 5000.0, 0.0, 0.0, target_mps=20.0)
    assert v[-1] == 20.0
    assert x[-1] < 5000.0
    x, v = drive(train, TRACTION, 5000.0, 100.0, 5.0)
    assert v[-1] == 0.0


def test_march_holds_at_a_drop_of_the_effort():
    """Above 10 m/s this train has 120 kN, below 200 kN, and the climb takes 160 kN: it stays at 10 m/s."""
    train = railcar("drops")
    permil = 1000.0 * (160e3 - train.resistance_n(10.0)) / (train.mass_kg * 9.81)
    for v0 in (0.0, 9.9999, 10.0, 10.0 * (1.0 - 1e-10), 14.0):
        _x, v = drive(train, TRACTION, 20000.0, permil, v0)
        assert v[-1] == pytest.approx(10.0, rel=1e-8)
        assert len(v) < 120


@pytest.mark.parametrize("excess_n", [50.0, 1e3, 2e4])
def test_march_slows_down_to_its_balance_below_a_drop(excess_n):
    """At 10 m/s the climb takes a little more than the 150 kN below the drop: the train comes to rest below it."""
    train = railcar(traction=EffortCurve.from_points([(0, 2e5), (10, 1.5e5), (10, 1e5), (60, 8e4)]))
    permil = 1000.0 * (150e3 + excess_n - train.resistance_n(10.0)) / (train.mass_kg * 9.81)
    x, v = drive(train, TRACTION, 50000.0, permil, 14.0)
    load_n = running.grade_n(train, permil)
    assert train.traction.effort_n(v[-1]) == pytest.approx(train.resistance_n(v[-1]) + load_n, rel=1e-5)
    assert v[-1] < 10.0
    for d, v0, v1 in zip(np.diff(x), v, v[1:], strict=False):
        known = kernel_train(train)
        effort_n = 0.5 * known.inertia_kg * (v1**2 - v0**2) / d + mean_resistance(known, 7.0, v0, v1) + load_n
        assert effort_n <= mean_effort(known.traction, v0, v1) * (1.0 + 1e-6)


def test_march_over_a_thousand_kilometres_is_short():
    x, v = drive(railcar(), TRACTION, 1e6, 0.0, 0.0)
    power_n = 3e6 / v[-1]
    assert power_n == pytest.approx(railcar().resistance_n(v[-1]), rel=1e-6)
    assert len(x) < 400


@pytest.mark.parametrize(
    ("regime", "sign", "start_mps"), [(TRACTION, 1.0, 0.0), (BRAKING, 1.0, 55.0), (BRAKING, -1.0, 1.0)]
)
@pytest.mark.parametrize("curve", ["power", "table", "drops"])
def test_a_row_ends_where_a_comfort_limit_begins_or_ends(regime, sign, start_mps, curve):
    """A row of both took some milliseconds more or less than its motion."""
    train = kernel_train(railcar(curve, max_acceleration_mps2=0.35, max_deceleration_mps2=0.35, friction_brake_n=0.0))
    cell = Cell(0.0, 9e3, 9e3, 0.0, 6.0, math.inf)
    rows = Rows(*np.empty((2, 5000)))
    _, _, n = march(train, regime, sign, cell, cell.length_m, start_mps**2, 50.0**2 if start_mps < 50 else 1.0, rows, 0)
    speed = np.sqrt(np.concatenate(([start_mps**2], rows.w[:n])))
    limits = []
    for before, after in itertools.pairwise(speed):
        inside = before + (after - before) * np.array([1e-4, 0.5, 1.0 - 1e-4])
        nets = np.array([net_force(train, regime, cell, v, v) for v in inside])
        at_limit = np.abs(nets) >= 0.35 * train.inertia_kg * (1.0 - 1e-12)
        assert at_limit.all() or not at_limit.any()
        limits.append(at_limit.all())
    assert any(limits) and not all(limits)


@pytest.mark.parametrize("regime", [TRACTION, COASTING, BRAKING, DYNAMIC])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("length_m", [1.0, 60.0, 300.0])
def test_a_row_lands_where_its_mean_force_leads(regime, sign, length_m):
    """To 1e-12: what is met from both sides was 1e-9 apart, and each cell ended with a sliver of coasting."""
    train = kernel_train(railcar(friction_brake_n=0.0))
    for v in (25.0, 40.0):
        w = v * v
        cell = Cell(0.0, length_m, length_m, -4e3, 7.0, math.inf)
        landed = land(train, regime, sign, cell, length_m, w)
        force = net_force(train, regime, cell, v, math.sqrt(landed))
        assert landed == pytest.approx(w + sign * 2.0 * length_m / train.inertia_kg * force, rel=1e-12)
        assert land(train, regime, -sign, cell, length_m, landed) == pytest.approx(w, rel=1e-12)
        rows = Rows(*np.empty((2, 500)))
        _, driven, n = march(train, regime, sign, cell, length_m, w, 1.0 if regime != TRACTION else 1e4, rows, 0)
        back = march(train, regime, -sign, cell, length_m, driven, w, rows, 0)[1]
        assert n > 1 or back == pytest.approx(w, rel=1e-12)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("regime", [TRACTION, COASTING, BRAKING, DYNAMIC])
@pytest.mark.parametrize("rates", [False, True])
def test_the_force_at_one_speed_is_the_mean_from_it_to_itself(curve, regime, rates):
    train = kernel_train(railcar(curve, max_deceleration_mps2=0.6))
    if rates:
        train = train._replace(rates=np.array([[0.0, 0.0, 3e5, 0, 0, 0], [15.0, 0.0, 2e5, 0, 0, 0]]))
    cell = Cell(0.0, 1.0, 1.0, 2e3, 7.0, math.inf)
    for v in (0.0, 3.0, 10.0, 12.0, 15.0, 25.0, 55.0):
        assert net_force_at(train, regime, cell, v) == pytest.approx(net_force(train, regime, cell, v, v), rel=1e-12)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("regime", [TRACTION, BRAKING, DYNAMIC])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_row_lands_beyond_a_jump_of_the_effort_too_or_at_it(curve, regime, sign):
    """It stalled where the first step went below a standstill, and came to nothing next to one."""
    train = kernel_train(railcar(curve, friction_brake_n=0.0))
    for v, length_m in itertools.product((2e-3, 10.0, 12.0, 17.0, 25.0, 26.0), (1.0, 60.0, 300.0)):
        w = v * v
        cell = Cell(0.0, length_m, length_m, 1e3, 7.0, math.inf)

        def left(x, w=w, v=v, cell=cell):
            """What a landing at x is too low by."""
            return (
                w + sign * 2.0 * cell.length_m / train.inertia_kg * net_force(train, regime, cell, v, math.sqrt(x)) - x
            )

        landed = land(train, regime, sign, cell, length_m, w)
        if landed == 0.0:
            assert left(1e-9 * (w + 1.0)) <= 0.0
        else:
            assert left(landed * (1.0 - 1e-7)) >= 0.0 >= left(landed * (1.0 + 1e-7))


def test_braking_rates_bring_a_train_to_its_stop_although_the_dynamic_brake_fades():
    """The rate drives the motion, whatever curve is behind it; rows grew ever shorter."""
    fades = EffortCurve.from_points([(0, 0.0), (5, 2e5), (60, 1e5)])
    train = railcar(braking=fades, braking_rates=(BrakingRate(0.0, 0.8),), friction_brake_n=0.0)
    x, v = drive(train, BRAKING, 1e3, 0.0, 20.0)
    assert v[-1] == 0.0
    assert x[-1] == pytest.approx(0.5 * 20.0**2 / 0.8, rel=1e-9)
    assert len(x) < 10
