"""Short phases: left out of runs at their running time and next to no cost, in whatever trains and lines ask for."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.phases_case import CASES, POINTS, phases_s
from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.drivable import drivable
from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.mesh import Run as Searched
from tgvdp.methods.phases.plan import AT, PLAN_COLUMNS, REGIME, leave_out, plan_of
from tgvdp.methods.phases.prune import prune
from tgvdp.methods.phases.regimes import tell_regimes, without_touches
from tgvdp.methods.phases.track import track
from tgvdp.methods.phases.way import Room, measure, way_of
from tgvdp.methods.phases.way import Run as Rows
from tgvdp.methods.phases.widen import widen
from tgvdp.model.trip import Trip
from tgvdp.physics import cell
from tgvdp.physics.codes import COASTING, HOLDING, TRACTION
from tgvdp.physics.march import march
from tgvdp.runs.batch import Batch
from tgvdp.runs.fastest import fastest_run


def short(result, least_s=1.0):
    """Short phases of each point but the fastest."""
    return np.array([(phases_s(result.profile(i))[:-1] < least_s).sum() for i in range(1, len(result.front))])


@pytest.fixture(scope="module", params=CASES)
def pair(request):
    train, track, trip = CASES[request.param]
    return [tgvdp.search(train, track, points=POINTS, min_phase_s=least_s, **trip) for least_s in (0.0, 1.0)]


def test_short_phases_go_and_what_stays_is_counted(pair):
    before, after = pair
    assert short(after).sum() <= short(before).sum() and short(after).mean() <= 0.3
    assert short(after, 3.0).sum() <= 0.6 * short(before, 3.0).sum()
    assert len(after.front) == len(before.front)
    forced = 2 * len(after.trip.track.neutral_sections) * len(after.front)  # no choice: they are not counted
    assert short(after).sum() <= after.counters["short"] + forced


def test_running_times_are_met_and_energy_is_no_more(pair):
    before, after = pair
    wanted_s = before.fastest.time_s * np.linspace(1.0, 1.25, POINTS)[: len(before.front)]
    step_s = wanted_s[1] - wanted_s[0]
    assert (after.front.time_s <= wanted_s * (1.0 + 1e-9)).all()
    complete = len(before.front) == POINTS
    assert not complete or (after.front.time_s >= wanted_s - 0.05 * step_s * (1.0 + 1e-6)).all()
    later_s = after.front.time_s - before.front.time_s
    dearer_j = (
        after.front.energy_j
        - before.front.energy_j
        + np.nan_to_num(before._found.multiplier_j_per_s[before.front.source], posinf=0.0) * later_s
    )
    base_j = np.maximum(np.abs(before.front.energy_j), 0.1 * abs(before.front.energy_j[0]))
    assert (dearer_j <= 5.1e-5 * base_j).all()


def test_the_referee_confirms_the_runs(pair):
    assert all(verdict.ok for verdict in pair[1].verify())


def test_many_points_are_met_to_a_tighter_tolerance():
    train, track, _ = CASES["wheel"]
    result = tgvdp.search(train, track, at_s=tuple(result_s(train, track)))
    missing_s = np.array(list(result_s(train, track))) - result.front.time_s
    assert ((missing_s >= 0.0) & (missing_s <= 0.05)).all()
    assert short(result).mean() <= 2.0


def result_s(train, track):
    fastest_s = fastest_run(Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m)).duration_s
    return (fastest_s * np.array([1.05, 1.1, 1.15, 1.2])).tolist()


def test_longer_phases_go_when_that_is_asked_for():
    train, track, _ = CASES["drops of effort"]
    few, fewer = (tgvdp.search(train, track, points=POINTS, min_phase_s=least_s) for least_s in (1.0, 5.0))
    assert short(fewer, 5.0).sum() < short(few, 5.0).sum()


def test_a_hilly_main_line_has_phases_that_one_can_drive(shared):
    """Unpruned 1.8 are under a second and 4.7 under three; to leave out a brake of 2 s for a limit costs 1e-4."""
    folder = shared / "ttobench"
    result = tgvdp.search(folder / "trains/CH_Stadler_KISS_SBB.json", folder / "tracks/CH_StGallen_Wil.json")
    assert short(result).mean() <= 0.3
    assert short(result, 3.0).mean() <= 1.2


# A run that is made by hand: traction, coasting, a dab of traction in it, coasting.


@pytest.fixture(scope="module")
def made():
    trip = trip_on([(0.0, 40.0)])
    mesh = Mesh.of(trip, fastest_run(trip))
    way = way_of(mesh.train, mesh.cells, cell.Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    rows = cell.room_for_rows(20_000, "test")
    rows.x[0] = rows.w[0] = 0.0
    n, w = 1, 0.0
    for regime, until_m in ((TRACTION, 900.0), (COASTING, 4000.0), (TRACTION, 4008.0), (COASTING, 8200.0)):
        for k in range(len(mesh.cells.length_m)):
            start_m = max(rows.x[n - 1], mesh.cells.station_m[k])
            end_m = min(until_m, mesh.cells.station_m[k + 1])
            if end_m > start_m + 1e-9:
                here = cell.Cell(start_m, end_m, end_m - start_m, mesh.cells.grade_n[k], mesh.cells.air[k], math.inf)
                target = math.inf if regime == TRACTION else 0.0
                first = n
                _, w, n = march(way.train, regime, 1.0, here, here.length_m, w, target, rows, n)
                rows.x[first:n] += start_m
                rows.x[n - 1] = end_m
    # From there on the fastest run, which is faster by then, is braked for: the run meets its braking curve.
    fast_x, fast_w = mesh.envelope.x_m, mesh.envelope.w
    later = fast_x > 8200.0
    x_m = np.concatenate((rows.x[:n], fast_x[later]))
    return mesh, way, x_m, np.concatenate((rows.w[:n], np.minimum(fast_w[later], w)))


def regimes(way, x_m, w):
    run = Rows.of(np.empty((5, len(x_m))))
    run.x[:], run.w[:] = x_m, w
    tell_regimes(way, run, 0, 0, len(x_m) - 1)
    plan = np.empty((100, PLAN_COLUMNS))
    return run, plan, plan_of(way, run, len(x_m), plan)


def test_regimes_are_told_from_what_rows_do(made):
    _, way, x_m, w = made
    _, plan, count = regimes(way, x_m, w)
    assert plan[:4, REGIME].tolist() == [TRACTION, COASTING, TRACTION, COASTING]
    assert plan[4, REGIME] == HOLDING and count >= 5
    assert plan[1:4, AT] == pytest.approx([900.0, 4000.0, 4008.0])


def test_a_plan_leaves_short_phases_out(made):
    _, way, x_m, w = made
    _, plan, count = regimes(way, x_m, w)
    assert leave_out(way, plan, count, 1.0) == count - 2
    assert plan[:3, REGIME].tolist() == [TRACTION, COASTING, HOLDING]


@pytest.mark.parametrize("slack_s", [1e6, 1e-4])
def test_a_dab_of_traction_goes_and_the_time_stays(made, slack_s):
    _, way, x_m, w = made
    pruned = prune(way, Batch.of([(x_m, w)]), np.array([1e5]), 1.0, np.array([1e9]), np.zeros(1), slack_s)
    assert pruned.short == 0
    assert abs(pruned.time_s[0]) <= slack_s
    changes = np.flatnonzero(np.diff(pruned.regime[:-1]))
    assert pruned.regime[changes[:2]].tolist() == [TRACTION, COASTING]
    assert pruned.runs.x_m[changes[1] + 1] > 8000.0  # one coasting to the hold
    speed = np.sqrt(pruned.runs.w)
    own_s = float((2.0 * np.diff(pruned.runs.x_m) / (speed[1:] + speed[:-1])).sum())
    was_s = float((2.0 * np.diff(x_m) / (np.sqrt(w[1:]) + np.sqrt(w[:-1]))).sum())
    assert own_s - was_s == pytest.approx(pruned.time_s[0], abs=1e-9)


def widened(made, most_j):
    _, way, x_m, w = made
    run, plan, count = regimes(way, x_m, w)
    size = 3 * len(x_m)
    out = Rows.of(np.empty((5, size)))
    n, left = widen(way, run, len(x_m), plan, count, 1e5, 1.0, Room(most_j, -math.inf, math.inf, 0.0, 0.0), out)
    return out.x[:n], out.w[:n], out.regime[: n - 1], most_j - left.most_j


def test_a_dab_that_stays_lasts_longer_at_a_partial_effort(made):
    x_m, w, regime, cost_j = widened(made, 1e9)
    assert (np.diff(x_m) > 0.0).all()
    speed = np.sqrt(w)
    gentle = (regime == HOLDING) & (x_m[1:] > 3800.0) & (x_m[1:] < 4200.0)
    assert float((2.0 * np.diff(x_m) / (speed[1:] + speed[:-1]))[gentle].sum()) >= 1.0
    assert not ((regime == TRACTION) & (x_m[1:] > 3800.0) & (x_m[1:] < 4200.0)).any()
    assert cost_j <= 1e5


def test_a_dab_is_not_widened_where_that_costs_too_much(made):
    x_m, w, _, cost_j = widened(made, -1e9)
    np.testing.assert_array_equal(x_m, made[2])
    np.testing.assert_array_equal(w, made[3])
    assert cost_j == 0.0


def test_what_costs_too_much_stays(made):
    mesh, way, x_m, w = made
    runs = Batch.of([(x_m, w)])
    pruned = prune(way, runs, np.array([1e5]), 1.0, np.array([-1e9]), np.zeros(1), 1e6)
    assert pruned.short == 1
    assert pruned.time_s == pruned.energy_j == 0.0
    np.testing.assert_array_equal(pruned.runs.x_m, x_m)
    counters = {"short": 0}
    kept = drivable(mesh, Found.of([found_run(x_m, w)]), np.array([50.0]), 1e-9, 1e-3, counters, SearchBudget().start())
    assert kept.outcome[0, 0] == 50.0 and counters["short"] == 0


def found_run(x_m, w, number=0):
    """A run of a search, so short that its rows are not cut; of several, each takes a second longer."""
    return Searched(50.0 + number, 1e8 - 1e6 * number, 1e5, x_m, w)


@pytest.mark.parametrize("why", ["no time", "too many rows"])
def test_runs_stay_as_they_are_where_there_is_no_time_for_them(made, monkeypatch, why):
    """A run of a train of a few grams has a hundred thousand rows: to prune sixty of them took nine seconds."""
    mesh, _, x_m, w = made
    if why == "too many rows":
        monkeypatch.setattr("tgvdp.methods.costate.drivable._ROWS_AT_ONCE", len(x_m) - 1)
    clock = SearchBudget(time_limit_s=1e-9 if why == "no time" else 60.0).start()
    kept = drivable(mesh, Found.of([found_run(x_m, w)]), np.array([50.0]), 1e-9, 1.0, {"short": 0}, clock)
    assert kept.outcome.tolist() == [[50.0, 1e8, 1e5]] and (kept.parts[0].regime == -1).all()
    np.testing.assert_array_equal(kept.parts[0].runs.w, w)
    assert kept.complete == (why != "no time")


@pytest.mark.parametrize("cores", [1, 2])
def test_runs_are_pruned_some_rows_at_a_time(made, monkeypatch, cores):
    mesh, _, x_m, w = made
    runs = [found_run(x_m, w, number) for number in range(5)]
    monkeypatch.setattr("tgvdp.cores.usable_cores", lambda: cores)
    monkeypatch.setattr("tgvdp.methods.costate.drivable._ROWS_OF_A_THREAD", len(x_m))

    def pruned():
        aims_s = np.array([run.time_s for run in runs])
        return drivable(mesh, Found.of(runs), aims_s, 1e-9, 1.0, {"short": 0}, SearchBudget().start())

    whole = pruned()
    monkeypatch.setattr("tgvdp.methods.costate.drivable._ROWS_AT_ONCE", 2 * len(x_m))
    some = pruned()
    assert some.complete
    np.testing.assert_array_equal(some.outcome, whole.outcome)
    assert len(some.parts) == 3

    def all_rows(kept):
        return (*Batch.joined([part.runs for part in kept.parts]), np.concatenate([part.regime for part in kept.parts]))

    for one, other in zip(all_rows(some), all_rows(whole), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_stretch_that_leaves_phases_shorter_is_refused(made):
    """A dab of traction of 8 m is not cut to one of 1 m."""
    _, way, x_m, w = made
    run, plan, count = regimes(way, x_m, w)
    plan[3, AT] = 4001.0
    out = Rows.of(np.empty((5, 30_000)))
    whatever = Room(math.inf, -math.inf, math.inf, 0.0, 0.0)
    for least_s, refused in ((0.0, 0), (1.0, 1)):
        assert track(way, run, len(x_m), plan, count, 1e5, least_s, whatever, out)[1] == refused


@pytest.mark.parametrize("by_s", [1e-6, math.inf])
def test_a_stretch_that_takes_too_long_is_refused(made, by_s):
    _, way, x_m, w = made
    run, plan, count = regimes(way, x_m, w)
    planned = leave_out(way, plan, count, 1.0)
    out = Rows.of(np.empty((5, 30_000)))
    n, refused, left = track(way, run, len(x_m), plan, planned, 1e5, 1.0, Room(math.inf, -by_s, by_s, 0.0, 0.0), out)
    assert refused == (by_s < math.inf)
    if refused:
        np.testing.assert_array_equal(out.x[:n], x_m)
        assert left.latest_s == by_s


def assert_measured(way, run, n):
    """Times and energies that rows carry along are theirs."""
    anew = Rows(*(column.copy() for column in run))
    measure(way, anew, 0, n - 1)
    np.testing.assert_array_equal(run.time[: n - 1], anew.time[: n - 1])
    np.testing.assert_array_equal(run.energy[: n - 1], anew.energy[: n - 1])
    v = np.sqrt(run.w[:n])
    np.testing.assert_allclose(run.time[: n - 1], 2.0 * np.diff(run.x[:n]) / (v[1:] + v[:-1]), rtol=1e-14)


def test_rows_carry_their_times_and_energies_along(made):
    """Whatever is cut, joined, spread or left as it was on the way."""
    _, way, x_m, w = made
    whatever = Room(math.inf, -math.inf, math.inf, 0.0, 0.0)
    run, plan, count = regimes(way, x_m, w)
    assert_measured(way, run, len(x_m))
    wide, tracked = Rows.of(np.empty((5, 30_000))), Rows.of(np.empty((5, 30_000)))
    n, _ = widen(way, run, len(x_m), plan, count, 1e5, 1.0, whatever, wide)
    assert n > len(x_m)
    assert_measured(way, wide, n)
    assert_measured(way, run, len(x_m))
    planned = leave_out(way, plan, plan_of(way, run, len(x_m), plan), 1.0)
    n, refused, _ = track(way, run, len(x_m), plan, planned, 1e5, 0.0, whatever, tracked)
    assert n > 0
    assert refused == 0
    assert_measured(way, tracked, n)
    assert_measured(way, run, len(x_m))
    n = without_touches(way, tracked, n)
    assert_measured(way, tracked, n)


def test_what_phases_may_cost_is_a_share_of_the_net_energy():
    """It was one of the energy without auxiliaries, or of all traction: a tenth of a small net energy was lost."""
    train = commuter(auxiliary_power_w=3e5, regeneration_efficiency=0.8, traction_efficiency=0.85)
    gradients = [(0, 0), (2000, -14), (6000, 6), (8000, -16), (14e3, 0), (17e3, -9)]
    limits = [(0, 33), (5000, 25), (7500, 33), (12e3, 22), (15e3, 33)]
    trip = trip_on(limits, gradients, 20e3, train)
    asked = {"energy": "pantograph", "points": 30}
    before, after = (tgvdp.search(trip.train, trip.track, min_phase_s=least_s, **asked) for least_s in (0.0, 1.0))
    kinetic_j = 0.5 * train.inertia_kg * before.fastest.profile.speed_mps.max() ** 2
    later_s = after.front.time_s - before.front.time_s
    price = np.nan_to_num(before._found.multiplier_j_per_s, posinf=0.0)
    dearer_j = after.front.energy_j - before.front.energy_j + price * later_s
    assert np.abs(after.front.energy_j).min() < 0.15 * kinetic_j
    assert short(after).sum() < short(before).sum()
    assert (dearer_j <= 6e-5 * np.maximum(np.abs(before.front.energy_j), 0.1 * kinetic_j)).all()
