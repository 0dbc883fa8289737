"""Maps that are not convex: the hull, runs that switch between efforts, and no grid program that does better."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.trips import EFFICIENT, EFFICIENT_HILLS, HILLS
from tests.helpers.twins.running import arc as twin_arc
from tests.helpers.twins.running import mean_over_distance
from tgvdp.line.cells import cells_of
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.refine.convex_map import relaxed_tables
from tgvdp.methods.refine.front import refine_front
from tgvdp.methods.refine.guide import Guide, fitted_tables
from tgvdp.model.energy import EnergyMap, EnergyModel
from tgvdp.physics.energy import energy_tables
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

SEED_MAP = tgvdp.load_energy_map("alstom-map")


def with_map(trip, energy_map):
    return replace(trip, energy=EnergyModel("map", energy_map))


def hull_by_lines(x, y):
    """Lower hull at x as the largest line below all points: slow, and nothing like the kernel's."""
    values = []
    for i in range(len(x)):
        chords = [y[i]]
        for a in range(i):
            for b in range(i + 1, len(x)):
                chords.append(y[a] + (y[b] - y[a]) * (x[i] - x[a]) / (x[b] - x[a]))
        values.append(min(chords))
    return np.array(values)


@pytest.mark.parametrize("row", [0, 1, 5, 12, 22])
def test_the_hull_is_taken_over_the_effort(row):
    train = EFFICIENT_HILLS.train
    tables = energy_tables(train, EnergyModel("map", SEED_MAP))
    relaxed = relaxed_tables(train, tables)
    v = float(tables.speed_mps[row])
    effort = [d * (train.traction if d >= 0.0 else train.braking).effort_n(v) for d in tables.demand.tolist()]
    assert relaxed.power_w[row] == pytest.approx(hull_by_lines(effort, tables.power_w[row]), rel=1e-9, abs=1e-3)
    assert (relaxed.power_w[row] <= tables.power_w[row] + 1e-6).all()


def test_a_convex_map_stays_as_it_is():
    rows = tuple((0.0, 1e4 * v, 5e4 * v) for v in (0.0, 10.0, 40.0))
    tables = energy_tables(
        HILLS.train, EnergyModel("map", EnergyMap(speed_mps=(0.0, 10.0, 40.0), demand=(0.0, 0.5, 1.0), power_w=rows))
    )
    assert relaxed_tables(HILLS.train, tables) is tables
    wheel = energy_tables(HILLS.train, HILLS.energy)
    assert relaxed_tables(HILLS.train, wheel) is wheel


def test_runs_switch_and_meet_their_times():
    trip = with_map(EFFICIENT_HILLS, SEED_MAP)
    fastest = fastest_run(trip)
    wanted = fastest.duration_s * np.linspace(1.0, 1.25, 30)
    found = refine_front(trip, fastest, wanted, SearchBudget())
    assert len(found.duration_s) == 30
    assert np.abs(found.duration_s - wanted)[:-1].max() <= 0.03 * (wanted[1] - wanted[0]) * (1.0 + 1e-9)
    assert (np.diff(found.energy_j) < 0.0).all()
    partial = 0
    for index in range(1, 30):
        profile = profile_of(trip, *found.rows(index))
        verdict = replay(trip, profile)
        # A cell in which the power limit bends has one acceleration: on a short hilly trip that is all of the error.
        assert abs(verdict.energy_error_pct) <= 0.1
        assert verdict.effort_excess_pct <= 0.1
        assert verdict.overspeed_mps == 0.0
        assert profile.total_energy_j == pytest.approx(found.energy_j[index], rel=1e-6)
        v = profile.speed_mps[:-1]
        limit = np.array([trip.train.traction.effort_n(speed) for speed in v.tolist()])
        share = profile.force_n[:-1] / limit
        partial += int(((share > 0.03) & (share < 0.9)).sum())
    assert partial <= 60  # of about 10 000 rows: where effort switches it is none or nearly all


def run_at_the_limit(train):
    """The run that keeps to 14 m/s on level track for all of 3 km, and what the hull of the map draws for it, J."""
    track = tgvdp.Track(length_m=3000.0, speed_limits=((0.0, 14.0),))
    found = tgvdp.search(
        train, track, energy="map", start_speed_mps=14.0, end_speed_mps=14.0, points=2, max_margin=1e-3
    )
    tables = energy_tables(train, EnergyModel("map", SEED_MAP))
    row = np.array([np.interp(14.0, tables.speed_mps, column) for column in tables.power_w.T])
    effort_n = tables.demand * train.traction.effort_n(14.0)
    pulls = tables.demand >= 0.0
    hull_w = hull_by_lines(effort_n[pulls], row[pulls])
    hull_j = 3000.0 / 14.0 * (np.interp(train.resistance_n(14.0), effort_n[pulls], hull_w) + tables.auxiliary_w)
    return found, hull_j


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"max_acceleration_mps2": 0.6},
        {"braking": tgvdp.EffortCurve.from_caps(0.0), "friction_brake_n": 3e5},
    ],
    ids=["strong", "comfort", "friction"],
)
def test_who_may_not_use_all_effort_switches_too(change):
    """Full effort passed what comfort allows, so that holding took partial effort, 60 % dearer; without a dynamic brake
    there was no hull at all."""
    train = replace(tgvdp.load_train("alstom-emu"), **change)
    found, hull_j = run_at_the_limit(train)
    slower_j = found.front.energy_j[-1]
    assert slower_j == pytest.approx(hull_j, rel=0.03)
    assert all(verdict.ok for verdict in found.verify())


def grid_cost(trip, fastest, multiplier, stations, levels):
    """Least E + λT on a plain grid, the map looked up at the mean speed and the mean demand of an arc."""
    x = np.union1d(np.linspace(0.0, trip.distance_m, stations + 1), cells_of(trip).station_m)
    cells = cells_of(trip, x)
    top = np.interp(cells.station_m, fastest.position_m - trip.origin_m, fastest.speed_mps) * (1.0 - 1e-9)
    speeds = top[:, None] * np.linspace(0.0, 1.0, levels)
    the_map = trip.energy.map
    to_go = np.array([0.0] + [math.inf] * (levels - 1))
    for k in range(len(cells.length_m) - 1, -1, -1):
        best = np.full(levels, math.inf)
        for i, v0 in enumerate(speeds[k].tolist()):
            for j, v1 in enumerate(speeds[k + 1].tolist()):
                if to_go[j] == math.inf or v0 + v1 == 0.0:
                    continue
                slope = cells.grade_n[k] / (trip.train.mass_kg * 9.81) * 1000.0
                seconds, work = twin_arc(trip.train, float(cells.length_m[k]), slope, v0, v1)[:2]
                curve = trip.train.traction if work >= 0.0 else trip.train.braking
                limit = mean_over_distance(curve.effort_n, v0, v1) * cells.length_m[k]
                spare = trip.train.friction_brake_n * cells.length_m[k] if work < 0.0 else 0.0
                if abs(work) > (limit + spare) * (1.0 + 1e-9):
                    continue
                power = looked_up(the_map, 0.5 * (v0 + v1), max(work / limit, -1.0) if limit > 0.0 else 0.0)
                best[i] = min(best[i], seconds * (power + multiplier) + to_go[j])
        to_go = best
    return float(to_go[0])


def looked_up(the_map, v, demand):
    rows = [np.interp(demand, the_map.demand, row) for row in the_map.power_w]
    return float(np.interp(v, the_map.speed_mps, rows))


@pytest.mark.slow
def test_no_plain_grid_is_better():
    """A grid program of its own, which may switch from cell to cell as it likes."""
    trip = with_map(replace(HILLS, destination_m=2500.0), SEED_MAP)
    fastest = fastest_run(trip)
    found = refine_front(trip, fastest, fastest.duration_s * np.linspace(1.0, 1.5, 40), SearchBudget())
    for factor in (1.0, 0.3):
        multiplier = factor * found.energy_j[0] / found.duration_s[0]
        ours = float((found.energy_j + multiplier * found.duration_s).min())
        assert ours <= grid_cost(trip, fastest, multiplier, 25, 24) * 1.002


def test_the_map_of_constant_efficiencies_gives_the_pantograph_front():
    """Sweeps over a table, and the costate program with its factors."""
    trips = [(EFFICIENT, HILLS.track), ("alstom-emu", "flat-100km"), ("tgv", "lgv-100km")]
    for name, track in trips:
        train = replace(name if name is EFFICIENT else tgvdp.load_train(name), auxiliary_power_w=0.0)
        wanted = {"at_margin": (0.02, 0.05, 0.1, 0.2)}
        by_factors = tgvdp.search(train, track, energy="pantograph", **wanted)
        by_table = tgvdp.search(train, track, energy=constant_efficiencies(train), **wanted)
        price_j_per_s = by_factors.price_kwh_per_min * 6e4
        late_j = price_j_per_s * (by_table.front.time_s - by_factors.front.time_s)
        assert by_table.front.energy_j + late_j == pytest.approx(by_factors.front.energy_j, rel=2e-4)


@pytest.mark.parametrize("seed", [1955036, 1955110])
def test_the_map_of_constant_efficiencies_on_random_trips(seed):
    """Steps between speeds that ended at 10⁻⁵ of v² cost 0.11 % on the short cells of these."""
    trip = proof_trip(seed)
    train = replace(trip.train, auxiliary_power_w=0.0)
    by_factors = tgvdp.search(train, trip.track, points=8, energy="pantograph")
    wanted = tuple(by_factors.front.time_s[1:].tolist())
    by_table = tgvdp.search(train, trip.track, at_s=wanted, energy=constant_efficiencies(train))
    late_s = by_table.front.time_s - by_factors.front.time_s[1:]
    late_j = by_factors.price_kwh_per_min[1:] * 6e4 * late_s
    assert by_table.front.energy_j + late_j == pytest.approx(by_factors.front.energy_j[1:], rel=6e-4)


def constant_efficiencies(train):
    """Map of a train's two efficiencies."""
    breaks_mps = [piece.from_mps for curve in (train.traction, train.braking) for piece in curve.pieces]
    speeds = np.union1d(np.linspace(0.0, 1.02 * train.max_speed_mps, 401), breaks_mps)
    pull_w = np.array([v * train.traction.effort_n(v) for v in speeds]) / train.traction_efficiency
    returned_w = np.array([v * train.braking.effort_n(v) for v in speeds]) * train.regeneration_efficiency
    rows = tuple(zip((-returned_w).tolist(), np.zeros_like(speeds).tolist(), pull_w.tolist(), strict=True))
    return EnergyMap(speed_mps=tuple(speeds.tolist()), demand=(-1.0, 0.0, 1.0), power_w=rows)


def test_a_map_is_fitted_by_what_it_draws_at_full_effort():
    """The factors of constant efficiencies come back; what idles counts as auxiliaries; absurd maps guide nobody."""
    train = tgvdp.load_train("alstom-emu")
    energy = EnergyModel("map", constant_efficiencies(train))
    fitted = fitted_tables(train, energy_tables(train, energy), 40.0)
    assert fitted.traction == pytest.approx(1.0 / train.traction_efficiency, rel=1e-12)
    assert fitted.regeneration == pytest.approx(train.regeneration_efficiency, rel=1e-12)
    assert fitted.auxiliary_w == train.auxiliary_power_w
    nodes = {"speed_mps": (0.0, 80.0), "demand": (-1.0, 0.0, 1.0)}
    idle = EnergyModel("map", EnergyMap(**nodes, power_w=((5e4, 5e4, 1e6), (5e4, 5e4, 1e6))))
    assert fitted_tables(train, energy_tables(train, idle), 40.0)[1:3] == (0.0, train.auxiliary_power_w + 5e4)
    absurd = EnergyModel("map", EnergyMap(**nodes, power_w=((0.0, 0.0, -1e6), (0.0, 0.0, -1e6))))
    trip = replace(HILLS, energy=absurd)
    guide = Guide(trip, fastest_run(trip), energy_tables(trip.train, absurd))
    assert guide.run(1e5) is None


@pytest.mark.parametrize("seed", [8, 20, 33, 40])
def test_short_hilly_trips_replay_by_the_map(seed):
    """Below 20 km/h the dynamic brake fades with the speed: within a row friction takes over what it no longer does."""
    rng = np.random.default_rng(seed)
    length_m = rng.uniform(800, 4000)
    places_m = np.sort(rng.uniform(0, length_m, 6)).tolist()
    gradients = [(x, rng.uniform(-25, 25)) for x in [0.0, *places_m]]
    limits = [(0.0, rng.uniform(12, 33)), (length_m * rng.uniform(0.3, 0.7), rng.uniform(10, 33))]
    track = tgvdp.Track(length_m=length_m, speed_limits=tuple(limits), gradients=tuple(gradients))
    result = tgvdp.search(tgvdp.load_train("alstom-emu"), track, energy="map", points=8)
    assert all(verdict.ok for verdict in result.verify())


def kinked(train):
    """Map that loses least at nine tenths of full effort, as the hull over the effort has a sharp kink there."""
    speeds = np.linspace(0.0, 1.05 * train.max_speed_mps, 61)
    demand, loss = (-1.0, -0.9, 0.0, 0.9, 1.0), (0.3, 0.02, 0.0, 0.02, 0.3)
    rows = []
    for v in speeds.tolist():
        most_w = v * train.traction.effort_n(v), v * train.braking.effort_n(v)
        rows.append(tuple(d * most_w[d < 0.0] + one * most_w[d < 0.0] for d, one in zip(demand, loss, strict=True)))
    return EnergyMap(speed_mps=tuple(speeds.tolist()), demand=demand, power_w=tuple(rows))


def test_a_demand_at_a_kink_of_the_map_is_held_along_a_row():
    """A constant effort passes the kink within each row, where the limit falls with speed: 0.2 % were off."""
    train = replace(tgvdp.load_train("alstom-emu"), auxiliary_power_w=0.0)
    track = tgvdp.Track(length_m=3000.0, speed_limits=((0.0, 30.0),))
    found = tgvdp.search(train, track, energy=kinked(train), points=4)
    verdicts = found.verify()
    assert all(verdict.ok for verdict in verdicts)
    assert max(abs(verdict.energy_error_pct) for verdict in verdicts) < 0.02
