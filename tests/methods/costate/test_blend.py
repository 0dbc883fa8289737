"""Policies between two extremals, and what these foretell of the runs between them."""

import math

import numpy as np
import pytest

from tests.helpers.fronts import check_front, counters, feasible_trip
from tests.helpers.trips import commuter, trip_on
from tgvdp.line.cells import cells_of
from tgvdp.methods.costate.blend import Blend, fill_blend
from tgvdp.methods.costate.extremal import Extremal, between, foretells
from tgvdp.methods.costate.forward import drive_blend
from tgvdp.methods.costate.forward_brakes import coast_through
from tgvdp.methods.costate.forward_lines import Lines
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.physics.cell import Cell, room_for_marches, room_for_rows
from tgvdp.physics.forces import kernel_train
from tgvdp.runs.fastest import fastest_run

TRAIN = commuter()


def blend_of(known, second, top_w, cells=None):
    """Blend of the policies of one of some extremals and the one before it; on even ground if nothing is said."""
    policies = np.array([one.switch for one in known])
    blend = Blend(*np.empty((4, *policies[0].shape)))
    if cells is None:
        cells = cells_of(trip_on([(0, 22)]), np.linspace(0.0, 10e3, len(top_w)))
    fill_blend(kernel_train(TRAIN), cells, np.array([one.outcome for one in known]), policies, second, top_w, blend)
    return blend


@pytest.fixture(scope="module")
def mesh():
    trip = trip_on([(0, 22)], [(0, 0), (900, 4), (2500, -3)], length_m=6000.0, train=TRAIN)
    return Mesh.of(trip, fastest_run(trip), 4.0)


@pytest.mark.parametrize("level", [0.5, 1.0, 2.0])
def test_a_blend_of_four_extremals_is_far_nearer_to_the_one_between_than_a_straight_one(mesh, level):
    known = [mesh.extremal(level * ratio * mesh.usual_multiplier, counters()) for ratio in (1.5, 1.2, 0.96, 0.77)]
    first, second = known[1:3]
    middle = mesh.extremal(math.sqrt(first.multiplier * second.multiplier), counters())
    bent = blend_of(known, 2, mesh.fast, mesh.cells)
    straight = Blend(first.switch, second.switch, *np.zeros((2, *first.switch.shape)))
    lost_j = []
    for blend in (bent, straight):
        run = mesh.drive(blend.at(0.5), counters())
        lost_j.append(run.energy_j + middle.multiplier * run.time_s - middle.cost_j(middle.multiplier))
    assert abs(lost_j[0]) <= 3e-5 * middle.energy_j
    assert abs(lost_j[0]) <= 0.3 * lost_j[1]


def test_a_blend_stays_between_its_two_policies_but_beyond_the_envelope():
    top_w = np.array([100.0, 100.0])
    speeds = [(100.0, 100.0), (100.0, 96.0), (90.0, 70.0), (70.0, 69.0)]
    known = [
        Extremal(math.exp(-k), np.repeat(np.array(w)[:, None], 4, axis=1), float(k), 0.0) for k, w in enumerate(speeds)
    ]
    blend = blend_of(known, 2, top_w)
    assert blend.first[0, 0] == pytest.approx(110.0)  # 70, 90, and so on
    assert blend.first[1, 0] == 96.0
    for share in (0.1, 0.5, 0.9):
        assert 70.0 <= blend.at(share)[1, 0] <= 96.0
    assert (blend.at(1.0) == known[2].switch).all()


def test_where_two_straight_lines_meet_a_blend_has_a_corner():
    """The lines themselves, not a parabola between them, which is off by a fourth of what they part; on both sides."""
    top_w = np.array([500.0, 500.0])
    for rising in (False, True):
        lines = [450.0, 450.0, 450.0, 420.0, 380.0, 340.0]  # 450 up to a quarter of the way, 40 less a step from there
        known = [
            Extremal(math.exp(-k), np.full((2, 4), 900.0 - w if rising else w), float(k), 0.0)
            for k, w in enumerate(lines)
        ]
        blend = blend_of(known, 3, top_w)
        for share in (0.0, 0.1, 0.25, 0.5, 0.75, 1.0):
            expected = min(450.0, 420.0 + 40.0 * (1.0 - share))
            assert blend.at(share)[1, 0] == pytest.approx(900.0 - expected if rising else expected, abs=1e-9)


def test_a_corner_beside_two_extremals_bends_nothing_between_them():
    known = [
        Extremal(math.exp(-k), np.full((2, 4), w), float(k), 0.0) for k, w in enumerate([450.0, 448.0, 408.0, 368.0])
    ]
    blend = blend_of(known, 2, np.array([500.0, 500.0]))
    assert blend.at(0.5)[1, 0] == pytest.approx(428.0, abs=1e-9)


def test_a_blend_is_right_where_a_limit_ahead_begins_to_bind():
    """For many multipliers a train coasts over a crest so that it comes to its limit just at the foot: 0.008 % of E."""
    trip = trip_on([(0, 22.2)], [(0, 3), (2000, -16), (2265, 3)], length_m=5000.0, train=TRAIN)
    mesh = Mesh.of(trip, fastest_run(trip), 0.125)
    levels = np.array([1.6, 1.43, 1.26, 1.09, 0.92, 0.75])
    known = [mesh.extremal(level * mesh.usual_multiplier, counters()) for level in np.exp(levels)]
    blend = blend_of(known, 3, mesh.fast, mesh.cells)
    for share in (0.25, 0.5, 0.75):
        run = mesh.drive(blend.at(share), counters())
        between_them = levels[2] + share * (levels[3] - levels[2])
        best = mesh.extremal(math.exp(between_them) * mesh.usual_multiplier, counters())
        lost_j = run.energy_j + best.multiplier * run.time_s - best.cost_j(best.multiplier)
        assert lost_j <= 2e-6 * best.energy_j


def test_how_far_a_line_lies_beyond_the_envelope_tells_the_run_that_coasts_from_there():
    """Not the policies of slower runs, which may have another shape: the start of coasting jumped within its cell."""
    top_w, cells = np.array([400.0, 400.0]), cells_of(trip_on([(0, 22)], length_m=500.0))
    coasted_w = 396.0
    falls = [385.0, 386.0, 400.0, 400.0], [375.0, 380.0, 400.0, 400.0]
    rows = [([400.0] * 4, [390.0, coasted_w, 400.0, 400.0]), falls]
    known = [Extremal(math.exp(-k), np.array(rows[min(k, 1)]), float(k), 0.0) for k in range(3)]
    begun_w = blend_of(known, 1, top_w, cells).first[0, 0]
    drag_n = TRAIN.davis_a_n + TRAIN.davis_b_n_per_mps * 20.0 + TRAIN.davis_c_n_per_mps2 * 400.0
    assert begun_w == pytest.approx(coasted_w + 2.0 * 500.0 * drag_n / TRAIN.inertia_kg, rel=1e-3)


def time_of(mesh, blend, share):
    """Running time of a blend itself, not of a policy that is as it."""
    mesh.share()
    room = mesh.room
    room.rows.x[0], room.rows.w[0] = 0.0, mesh.trip.start_speed_mps**2
    return drive_blend(
        mesh.train, mesh.tables, mesh.course, blend, share, room.march, room.passed, room.rows,
    )[1]  # fmt: skip


@pytest.mark.parametrize("ratios", [(4.0, 3.0, 2.2), (1.4, 1.2, 1.0), (0.9, 0.7, 0.55), (0.5, 0.4, 0.3)])
def test_a_blend_is_at_its_ends_the_extremals_that_it_is_of(ratios):
    """Where one holds a limit, or a speed, from which lines fall to a lower one: 0.4 % of E was between the two."""
    trip = trip_on([(0, 39), (25e3, 28), (26e3, 39)], length_m=48e3, train=TRAIN)
    mesh = Mesh.of(trip, fastest_run(trip), 0.125)
    known = [mesh.extremal(ratio * mesh.usual_multiplier, counters()) for ratio in ratios]
    for second in (1, 2):
        blend = blend_of(known, second, mesh.fast, mesh.cells)
        span_s = known[second].time_s - known[second - 1].time_s
        for share, extremal in enumerate(known[second - 1 : second + 1]):
            ends_s, almost_s = (time_of(mesh, blend, at) for at in (float(share), abs(share - 1e-6)))
            assert ends_s == pytest.approx(extremal.time_s, abs=5e-4 * span_s)
            assert almost_s == pytest.approx(ends_s, abs=2e-3 * span_s)


def relative_steps(mesh, ratios):
    """Steps of the running times of blends of neighbouring extremals, over their median, (m − 1, 400)."""
    known = [mesh.extremal(ratio * mesh.usual_multiplier, counters()) for ratio in ratios]
    steps = []
    for second in range(1, len(known)):
        blend = blend_of(known, second, mesh.fast, mesh.cells)
        steps.append(np.diff([time_of(mesh, blend, share) for share in np.linspace(0.0, 1.0, 401)]))
    return np.abs(steps) / np.median(steps, axis=1)[:, np.newaxis]


def test_running_times_of_blends_do_not_jump_where_coasting_starts_on_a_limit(mesh):
    assert relative_steps(mesh, (4.0, 3.0, 2.2, 1.6)).max() <= 3.0


@pytest.mark.parametrize("length_m", [1000.0, 1275.0, 1500.0])
def test_running_times_of_blends_do_not_jump_where_traction_ends_next_to_a_station(length_m):
    """It ended there up to 0.1 % of v² too early: three steps of time at once, for which runs were bridged."""
    trip = trip_on([(0, 22)], length_m=length_m, train=TRAIN)
    mesh = Mesh.of(trip, fastest_run(trip), 0.25)
    assert relative_steps(mesh, (4.0, 3.0, 2.2, 1.6, 1.2, 0.9)).max() <= 1.6


@pytest.mark.parametrize(("permil", "length_m"), [(4.0, 4000.0), (4.0, 6000.0), (20.0, 4000.0)])
def test_running_times_of_blends_do_not_jump_where_a_line_of_switching_meets_the_envelope(permil, length_m):
    """Just below, it began where the blend said, and just above where the run at its end had begun to coast."""
    trip = trip_on([(0, 22)], [(0, 0), (0.4 * length_m, permil), (0.6 * length_m, 0)], length_m=length_m, train=TRAIN)
    mesh = Mesh.of(trip, fastest_run(trip), 0.125)
    assert relative_steps(mesh, (4.0, 2.5, 1.6)).max() <= 1.8


def test_coasting_up_to_a_limit_takes_no_longer_when_it_reaches_it():
    """It braked a little all the way where it came to the limit in the last metres of a cell: 0.8 ms of 108 s."""
    train = kernel_train(commuter(davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0))
    fall_n, length_m, limit_w = 3e4, 65.0, 434.0
    gain = 2.0 * fall_n * length_m / train.inertia_kg
    for beyond in (-2e-4, 5e-5, 2e-4, 9e-4, 2e-3):
        start_w = limit_w * (1.0 + beyond) - gain
        cell = Cell(0.0, length_m, length_m, -fall_n, 0.0, limit_w)
        rows, march = room_for_rows(100, "test"), room_for_marches(100, "test: march")
        rows.x[0], rows.w[0] = 0.0, start_w
        lines = Lines(
            300.0, limit_w, limit_w, 0.0, 0.0, limit_w, 300.0, 300.0, limit_w, limit_w, 0.0, 0.0, limit_w, math.inf
        )
        n = coast_through(train, False, cell, start_w, start_w + gain, lines, march, rows, 1)
        speed = np.sqrt(rows.w[:n])
        time_s = (2.0 * np.diff(rows.x[:n]) / (speed[1:] + speed[:-1])).sum()
        met_m = min((limit_w - start_w) / gain, 1.0) * length_m
        end_w = min(limit_w, start_w + gain)
        least_s = 2.0 * met_m / (math.sqrt(start_w) + math.sqrt(end_w)) + (length_m - met_m) / math.sqrt(end_w)
        assert least_s * (1.0 - 1e-9) <= time_s <= least_s * (1.0 + 3e-5)


def test_what_is_off_the_envelope_by_rounding_is_on_it():
    """Neighbouring cells must not be blended in two ways: runs sawed from one to the other."""
    exact, rounded = 100.0, 100.0 - 1e-8
    known = [
        Extremal(math.exp(-k), np.repeat(np.array(w)[:, None], 4, axis=1), float(k), 0.0)
        for k, w in enumerate(
            [(exact, rounded, exact), (exact, exact, rounded), (70.0, 70.0, 70.0), (69.0, 69.0, 69.0)]
        )
    ]
    for share in (0.2, 0.5, 0.8):
        blended = blend_of(known, 2, np.full(3, exact)).at(share)
        assert blended == pytest.approx(np.full((3, 4), blended[0, 0]), abs=1e-6)


def test_next_to_the_fastest_run_energy_is_foretold_where_it_falls_with_the_root_of_time():
    def optimum(multiplier):
        late_s = (0.5 / multiplier) ** 2  # E = 10 − √(T − 100)
        return Extremal(multiplier, np.empty((0, 4)), 100.0 + late_s, 10.0 - math.sqrt(late_s))

    first, second = optimum(1.0), optimum(0.6)
    for share in (0.0, 0.3, 0.7, 1.0):
        here = optimum(0.6**share)
        foretold = between(first, second, here.time_s)
        assert foretold.energy_j == pytest.approx(here.energy_j, rel=1e-5)
        assert foretold.multiplier == pytest.approx(here.multiplier, rel=5e-3)
        assert foretold.share == pytest.approx(share, abs=1e-2)


def test_coasting_downhill_ends_at_the_envelope():
    """A blend aimed above a limit that coasting passes within a cell: by 0.06 m/s, then braked in one row."""
    check_front(feasible_trip(109739), 0.001, 2)


@pytest.mark.parametrize("ratio", [0.99, 0.6, 0.05])
@pytest.mark.parametrize(("bend", "rises"), [(0.0, True), (0.95, True), (-0.95, True), (1.05, False), (-1.05, False)])
def test_running_times_that_would_fall_on_the_way_are_told_from_the_energy(ratio, bend, rises):
    """Against the sum of λ over a time that is quadratic in ln λ, and falls somewhere if it bends by more than 1."""
    share = np.linspace(0.0, 1.0, 20_001)
    time_s = 600.0 + 40.0 * (share + bend * share * (1.0 - share))
    saved_j = np.trapezoid(1e6 * ratio**share, time_s)
    first = Extremal(1e6, np.empty(0), 600.0, 3e8)
    assert foretells(first, Extremal(ratio * 1e6, np.empty(0), 640.0, 3e8 - saved_j)) == rises
