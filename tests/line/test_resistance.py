"""The line as a train of some length meets it: closed forms, quadrature, and convergence of the steps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import tgvdp.line.resolved as resolved
from tgvdp.errors import InputError
from tgvdp.formats import load_track, load_train
from tgvdp.line.cells import cells_of, cut
from tgvdp.line.piecewise import Piecewise
from tgvdp.line.resistance import curve_permil
from tgvdp.line.resolved import resolve
from tgvdp.model.convention import CONVENTIONS, Convention, convention_of
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import LOWERED, NEUTRAL, POWERED, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.referee.line import met, parts_at, see_line
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run

TRAIN = Train(
    mass_kg=4e5,
    traction=EffortCurve.from_caps(3e5, 5e6),
    braking=EffortCurve.from_caps(2e5, 4e6),
    friction_brake_n=2e5,
    rotating_mass_factor=1.05,
    length_m=300.0,
    davis_a_n=4e3,
    davis_c_n_per_mps2=8.0,
    tunnel_drag=((24.0, 12.0), (40.0, 5.0)),
)
STRIP = Convention(name="test", mass_model="strip", limits="tail")
WEIGHT = TRAIN.mass_kg * 9.81 / 1000.0


def trip_on(convention=STRIP, train=TRAIN, origin_m=0.0, destination_m=5000.0, length_m=5000.0, **track):
    track = Track(length_m=length_m, **({"speed_limits": ((0, 30),)} | track))
    return Trip(train=train, track=track, origin_m=origin_m, destination_m=destination_m, convention=convention)


def forget_lines():
    """Have lines resolved anew."""
    resolve.cache_clear()
    resolved._on_steps.cache_clear()


def force_n(trip, x_m):
    line = resolve(trip)
    at = np.array([x_m])
    return float(line.force.on(line.force.piece_at(at), at)[0])


def test_a_piecewise_function_integrates_averages_and_finds_its_roots():
    knots = np.array([0.0, 2.0, 5.0])
    function = Piecewise.of(knots, np.array([-1.0, 3.0]), np.array([-0.5, 0.5]), np.array([3.0, -3.0]))

    def value(x):
        return float(function.on(function.piece_at(np.array([x])), np.array([x]))[0])

    assert (value(0.0), value(1.0), value(3.5)) == pytest.approx((-1.0, -0.5, 0.5))
    for a, b in ((0.0, 5.0), (0.5, 1.7), (1.0, 4.0)):
        area = quad(value, a, b, points=[2.0] if a < 2.0 < b else None)[0]
        assert function.mean(np.array([a]), np.array([b]))[0] == pytest.approx(area / (b - a), rel=1e-9)
    assert all(abs(value(x)) < 1e-12 for x in function.roots())
    assert len(function.roots()) == 2
    linear = Piecewise.of(knots, np.array([-1.0, 3.0]), np.array([1.0, 0.0]), np.array([3.0, -3.0]))
    behind = linear.mean_behind(1.5)
    at = np.array([1.0, 2.3, 4.9])
    expected = [
        quad(lambda x: np.interp(x, knots, (-1.0, 3.0, -3.0)), x - 1.5, x, points=[0.0, 2.0])[0] / 1.5 for x in at
    ]
    assert behind.on(behind.piece_at(at), at) == pytest.approx(expected, rel=1e-6)


def test_a_step_of_the_gradient_is_a_ramp_under_a_train():
    trip = trip_on(gradients=((0, 0), (2000, 10.0)))
    for x, share in ((1999.0, 0.0), (2000.0, 0.0), (2075.0, 0.25), (2150.0, 0.5), (2299.0, 299 / 300), (2400.0, 1.0)):
        assert force_n(trip, x) == pytest.approx(10.0 * share * WEIGHT, abs=1e-6 * WEIGHT)
    cells = cells_of(trip)
    work = np.sum(cells.grade_n * cells.length_m)
    assert work == pytest.approx(10.0 * WEIGHT * (3000.0 - 150.0), rel=1e-12)  # the tail has climbed 300 m less
    point = trip_on(Convention(name="test"), gradients=((0, 0), (2000, 10.0)))
    assert (force_n(point, 1999.9), force_n(point, 2000.1)) == pytest.approx((0.0, 10.0 * WEIGHT))
    assert len(cells_of(point).length_m) == 2


def test_the_line_behind_the_origin_counts():
    gradients = ((0, 12.0), (1000, 0.0))
    assert force_n(trip_on(origin_m=1100.0, gradients=gradients), 0.0) == pytest.approx(8.0 * WEIGHT)
    # Before the track its first value is held.
    assert force_n(trip_on(gradients=gradients), 0.0) == pytest.approx(12.0 * WEIGHT)


def test_curvature_is_linear_along_a_transition():
    curves = ((0, math.inf, math.inf), (1000, math.inf, -400.0), (1200, -400.0, -400.0), (1500, -400.0, 400.0))
    track = Track(length_m=2000.0, speed_limits=((0, 30),), curves=curves)
    permil = curve_permil(track, "800/R")

    def at(x):
        return float(permil.on(permil.piece_at(np.array([x])), np.array([x]))[0])

    found = [at(x) for x in (500.0, 1050.0, 1100.0, 1300.0, 1625.0, 1750.0, 1875.0)]
    assert found == pytest.approx([0.0, 0.5, 1.0, 2.0, 1.0, 0.0, 1.0])  # straight in the middle of a reverse curve
    trip = trip_on(replace(STRIP, curves="800/R"), length_m=2000.0, destination_m=2000.0, curves=curves)
    assert force_n(trip, 1100.0) == pytest.approx(WEIGHT * 0.5 * 100.0 / 300.0)  # triangle: 100 m long, 1 ‰ high
    assert force_n(trip, 1500.0) == pytest.approx(WEIGHT * 2.0)


@pytest.mark.parametrize(
    ("radius_m", "permil"), [(1000.0, 650 / 945), (300.0, 650 / 245), (299.0, 500 / 269), (-150, 500 / 120)]
)
def test_roeckl(radius_m, permil):
    curves = ((0, radius_m, radius_m),)
    trip = trip_on(replace(STRIP, curves="roeckl"), curves=curves)
    assert force_n(trip, 1000.0) == pytest.approx(permil * WEIGHT)


def test_roeckl_along_a_transition_agrees_with_quadrature():
    curves = ((0, math.inf, math.inf), (1000, math.inf, 200.0), (1300, 200.0, 200.0))
    trip = trip_on(replace(STRIP, mass_model="point", curves="roeckl"), curves=curves)

    def permil(x):
        radius_m = 200.0 * 300.0 / (x - 1000.0)
        return 650.0 / (radius_m - 55.0) if radius_m >= 300.0 else 500.0 / (radius_m - 30.0)

    mean = quad(permil, 1000.0, 1300.0, points=[1200.0])[0] / 300.0
    assert resolve(trip).force.mean(np.array([1000.0]), np.array([1300.0]))[0] == pytest.approx(mean * WEIGHT, rel=5e-4)


def test_a_radius_below_the_formula():
    with pytest.raises(InputError, match=r"curves\[0\].radius must be above 30 m for Röckl's formula, got 25 m"):
        fastest_run(trip_on(replace(STRIP, curves="roeckl"), curves=((0, 25.0, 25.0),)))


def test_drag_in_tunnels():
    tunnels = ((1000, 600, 40.0), (1600, 100, 24.0))
    point = trip_on(Convention(name="test", tunnels=True), tunnels=tunnels)
    cells = cells_of(point)
    assert dict(zip(cells.station_m.tolist(), cells.air.tolist(), strict=False)) == {
        0: 8.0,
        1000: 13.0,
        1600: 20.0,
        1700: 8.0,
    }
    line = resolve(trip_on(replace(STRIP, tunnels=True), tunnels=tunnels))
    at = np.array([1150.0, 1450.0, 1650.0, 1850.0, 2001.0])
    met_c = line.drag.on(line.drag.piece_at(at), at)
    assert met_c == pytest.approx([8 + 2.5, 8 + 5, 8 + (50 * 12 + 250 * 5) / 300, 8 + (100 * 12 + 50 * 5) / 300, 8.0])
    assert (cells_of(trip_on(STRIP, tunnels=tunnels)).air == 8.0).all()


def test_a_tunnel_of_unknown_cross_section():
    trip = trip_on(replace(STRIP, tunnels=True), tunnels=((1000, 600, 41.0),))
    with pytest.raises(InputError, match=r"not known for 41 m².*known cross sections in m²: 24, 40"):
        fastest_run(trip)


def test_a_rise_of_the_limit_waits_for_the_tail():
    limits = ((0, 30), (1000, 15), (1100, 20), (1200, 25), (3000, 10), (3050, 40))
    tail = trip_on(speed_limits=limits)
    line = resolve(tail)
    # The stretch of 20 m/s has been left by the head before the tail has left the one of 15 m/s.
    assert dict(zip(line.break_m.tolist(), line.limit_mps.tolist(), strict=False)) == {
        0: 30.0, 1000: 15.0, 1400: 20.0, 1500: 25.0, 3000: 10.0, 3350: 40.0,
    } | {x: 15.0 for x in line.break_m.tolist() if 1000 < x < 1400}  # fmt: skip
    shifted = ((0, 30), (1000, 15), (1400, 20), (1500, 25), (3000, 10), (3350, 40))
    head = trip_on(replace(STRIP, limits="head"), speed_limits=shifted)
    assert fastest_run(tail).duration_s == pytest.approx(fastest_run(head).duration_s, rel=1e-12)


def test_current_by_cell():
    cells = cells_of(trip_on(neutral_sections=((1000, 50, False), (2000, 100, True))))
    assert cells.station_m.tolist() == [0, 1000, 1050, 2000, 2100, 5000]
    assert cells.supply.tolist() == [POWERED, NEUTRAL, POWERED, LOWERED, POWERED]


def test_halved_cells_are_the_cells_of_the_line_with_more_stations():
    trip = trip_on(neutral_sections=((1000, 50, False), (2000, 100, True)), gradients=((0, 3.0), (1700, -4.0)))
    cells = cells_of(trip)
    which = np.arange(len(cells.length_m)) % 3 != 1
    middle_m = cells.station_m[:-1] + 0.5 * cells.length_m
    for ours, theirs in zip(cut(cells, 1 + which), cells_of(trip, middle_m[which]), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_gravity_comes_from_the_convention():
    trip = trip_on(CONVENTIONS["trainruns"], gradients=((0, 10.0),))
    assert cells_of(trip).grade_n == pytest.approx(TRAIN.mass_kg * 9.80665 / 100.0)


def test_presets_and_switches():
    assert convention_of("osrd") == CONVENTIONS["osrd"]
    changed = convention_of("osrd", mass_model="point", limits="head", curves="none", tunnels=True)
    assert (changed.mass_model, changed.limits, changed.curves, changed.tunnels) == ("point", "head", "none", True)
    with pytest.raises(InputError, match="one of ttobench, osrd, trainruns, got 'oops'"):
        convention_of("oops")


@pytest.mark.parametrize("length_m", [0.0, 40.0, 300.0, 9000.0])
@pytest.mark.parametrize("curves", ["none", "800/R", "roeckl"])
def test_the_referee_sees_the_same_line(length_m, curves):
    """Two ways of adding up one line, that share nothing."""
    trip = trip_on(
        Convention(name="test", mass_model="strip", curves=curves, tunnels=True),
        train=replace(TRAIN, length_m=length_m),
        origin_m=700.0,
        gradients=((0, 4.0), (900, -12.0), (1000, 3.0), (4000, 0.0)),
        curves=((0, math.inf, math.inf), (800, math.inf, 250.0), (1200, 250.0, -600.0), (2000, math.inf, math.inf)),
        tunnels=((1500, 500, 24.0), (4900, 100, 40.0)),
    )
    line, seen = resolve(trip), see_line(trip)
    x = np.linspace(0.7, trip.distance_m - 0.7, 4001)
    force = line.force.on(line.force.piece_at(x), x)
    drag = line.drag.on(line.drag.piece_at(x), x)
    at_m = trip.origin_m + x
    theirs = np.array([met(seen, parts_at(seen, at), at) for at in at_m])
    assert force == pytest.approx(theirs[:, 0], abs=(1e-4 if curves == "roeckl" else 1e-9) * WEIGHT)
    assert drag == pytest.approx(theirs[:, 1], abs=1e-9)
    from_start = np.array([met(seen, parts_at(seen, trip.origin_m), at) for at in at_m])
    assert np.array_equal(from_start, theirs)


@pytest.mark.parametrize(
    ("track", "train", "destination_m"),
    [("CH_StGallen_Wil", "CH_Stadler_KISS_SBB", 29556.1), ("CN_Songjiazhuang_Yizhuang", "CN_Beijing_Subway", 2631.0)],
)
@pytest.mark.parametrize("mass_model", ["point", "strip"])
def test_steps_have_converged(shared, monkeypatch, track, train, destination_m, mass_model):
    the_train = load_train(shared / "ttobench" / "trains" / f"{train}.json")
    trip = Trip(
        train=replace(the_train, length_m=150.0),
        track=load_track(shared / "ttobench" / "tracks" / f"{track}.json"),
        origin_m=0.0,
        destination_m=destination_m,
        convention=Convention(name="test", mass_model=mass_model, curves="roeckl", limits="tail"),
    )
    forget_lines()
    usual, cells = fastest_run(trip), len(cells_of(trip).length_m)
    assert replay(trip, usual).ok
    monkeypatch.setattr(resolved, "_STEP_SHARE", resolved._STEP_SHARE / 8.0)
    monkeypatch.setattr(resolved, "_MOST_STEPS", resolved._MOST_STEPS * 8)
    monkeypatch.setattr(resolved, "_WORK_SHARE", resolved._WORK_SHARE / 32.0)
    forget_lines()
    fine = fastest_run(trip)
    assert len(cells_of(trip).length_m) > 2 * cells or (track.startswith("CN") and mass_model == "point")
    forget_lines()
    assert usual.duration_s == pytest.approx(fine.duration_s, rel=3e-5)
    assert usual.total_energy_j == pytest.approx(fine.total_energy_j, rel=1e-4)


def test_a_short_train_does_not_need_more_steps():
    """Each change of gradient had a hundred steps of 30 cm: that of a second of running is next to nothing."""
    changes = tuple((200.0 * k, 20.0 * (-1.0) ** k) for k in range(25))
    trips = [trip_on(train=replace(TRAIN, length_m=length_m), gradients=changes) for length_m in (200.0, 30.0)]
    assert len(cells_of(trips[1]).length_m) < 25 * len(changes)
    assert len(cells_of(trips[1]).length_m) < len(cells_of(trips[0]).length_m)


@pytest.mark.parametrize("mass_model", ["point", "strip"])
@pytest.mark.parametrize(
    "figures",
    [
        {"mass_kg": 3e5},
        {"rotating_mass_factor": 1.2},
        {"traction": EffortCurve.from_caps(1e5, 5e6)},
        {"length_m": 120.0},
        {"davis_a_n": 40e3},
        {"davis_b_n_per_mps": 2e3},
        {"davis_c_n_per_mps2": 20.0},
        {"tunnel_drag": ((24.0, 30.0), (40.0, 5.0))},
        {"max_speed_mps": 20.0},
    ],
    ids=lambda figures: next(iter(figures)),
)
def test_a_train_with_another_figure_does_not_get_the_line_of_the_one_before_it(mass_model, figures):
    """Lines are shared by trips that agree in all they depend on."""
    convention = Convention(name="test", mass_model=mass_model, limits="tail", tunnels=True)
    line = {
        "gradients": ((0, 0), (800, 14), (2100, -21), (3300, 5)),
        "speed_limits": ((0, 30), (1500, 18), (3000, 30)),
        "tunnels": ((1000.0, 700.0, 24.0),),
    }
    forget_lines()
    resolve(trip_on(convention, **line))
    other = trip_on(convention, replace(TRAIN, **figures), **line)
    shared = resolve(other)
    forget_lines()
    alone = resolve(other)
    for mine, own in zip(shared, alone, strict=True):
        np.testing.assert_equal(mine, own)


def test_trips_that_differ_in_the_wind_share_their_line():
    forget_lines()
    trips = [trip_on(CONVENTIONS["ttobench"], replace(TRAIN, davis_a_n=newtons)) for newtons in (4e3, 5e3)]
    assert resolve(trips[0]) is resolve(trips[1])
