"""The certificate: below every run that any method finds, close to the optimum, and only ever loosened by errors."""

import numpy as np
import pytest
from scipy.integrate import quad

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.clocks import expire_after_lines
from tests.helpers.trips import commuter, trip_on
from tgvdp import EffortCurve, Track, Train, Trip
from tgvdp.certificate.line import BoundingProblem
from tgvdp.errors import BudgetExceededError
from tgvdp.physics.arc import arc
from tgvdp.physics.codes import HOLDING, TRACTION

METRO = Train(
    name="metro", mass_kg=200e3, rotating_mass_factor=1.06, traction=EffortCurve.from_caps(300e3, 2.5e6),
    braking=EffortCurve.from_caps(200e3, 4e6), friction_brake_n=60e3, davis_a_n=4000.0, davis_b_n_per_mps=60.0,
    davis_c_n_per_mps2=9.0, max_acceleration_mps2=1.2,
)  # fmt: skip
HILLS = Track(
    length_m=3000.0,
    speed_limits=((0.0, 16.0), (600.0, 22.0), (2200.0, 18.0)),
    gradients=((0.0, 3.0), (700.0, -18.0), (1500.0, 0.0), (1900.0, 12.0), (2500.0, -4.0)),
)
TOY = Train(
    name="toy", mass_kg=1.0, traction=EffortCurve.from_caps(1.0, 0.8), friction_brake_n=1.0, davis_a_n=0.02,
    davis_b_n_per_mps=0.01, davis_c_n_per_mps2=0.02,
)  # fmt: skip
TOY_LINE = Track(length_m=2.0, speed_limits=((0.0, 5.0),), gradients=((0.0, 0.0), (1.0, -20.0)))


@pytest.fixture(scope="module")
def hills():
    return tgvdp.search(METRO, HILLS, points=30)


@pytest.fixture(scope="module")
def hills_certificate(hills):
    return hills.certify()


def test_gaps_are_small_and_never_negative(hills, hills_certificate):
    certificate = hills_certificate
    assert certificate.gap_pct.shape == certificate.lower_bound_j.shape == hills.front.time_s.shape
    assert certificate.gap_pct.min() > -0.01
    assert np.median(certificate.gap_pct) < 0.1
    assert certificate.gap_pct[1:].max() < 0.5
    np.testing.assert_allclose(
        certificate.lower_bound_j, hills.front.energy_j * (1.0 - certificate.gap_pct / 100.0), rtol=1e-12
    )
    assert certificate.at(float(hills.front.time_s[7])) == pytest.approx(certificate.lower_bound_j[7], rel=1e-12)


@pytest.mark.parametrize("refused", ["a speed bound", "a bound on", "the ascent of a bound"])
def test_memory_is_asked_for_and_where_it_ends_what_is_there_holds(monkeypatch, hills, refused):
    def ask(size_b, what):
        if what.startswith(refused):
            raise BudgetExceededError(what)

    for module in ("line", "prepared", "rows"):
        monkeypatch.setattr(f"tgvdp.certificate.{module}.ask_for", ask)
    monkeypatch.setattr("tgvdp.certificate.lines._GOAL", 1e-6)  # lines that ask for an ascent
    certificate = hills.certify()
    assert not certificate.complete
    known = np.isfinite(certificate.lower_bound_j)
    assert known.any() == (refused != "a speed bound")
    assert (certificate.lower_bound_j[known] <= hills.front.energy_j[known] * (1.0 + 1e-4)).all()


@pytest.mark.parametrize("options", [{"method": "exact"}, {"method": "best-first", "paths": 40}])
def test_no_run_of_any_method_lies_below_the_bound(hills_certificate, options):
    result = tgvdp.search(METRO, HILLS, segment_m=250.0, speeds=14, **options)
    for time_s, energy_j in zip(result.path_time_s, result.path_energy_j, strict=True):
        assert energy_j >= hills_certificate.at(time_s) * (1.0 - 3e-4)
    own = result.certify()
    assert (own.gap_pct > -0.03).all()
    problem = BoundingProblem(result.trip)
    for index in range(0, len(result.front), 7):  # their own rows suggest costates, too
        profile = result.profile(index)
        line_j = problem.line(profile.position_m, profile.speed_mps**2, 5e4, gain_j=1e3)
        assert result.front.energy_j[index] >= line_j - 5e4 * result.front.time_s[index]


def _ledger(result, index):
    multiplier_j_per_s = float(result.price_kwh_per_min[index]) * 3.6e6 / 60.0
    problem = BoundingProblem(result.trip)
    profile = result.profile(index)
    rows = profile.position_m - result.trip.origin_m, profile.speed_mps**2
    return problem, problem.ledger(*rows, multiplier_j_per_s), multiplier_j_per_s


def test_losses_of_the_cells_sum_to_the_gap_and_none_is_negative(hills):
    problem, ledger, multiplier_j_per_s = _ledger(hills, 12)
    train = problem.train
    inertia = train.inertia_kg
    w, cells = ledger.w, ledger.cells
    cost = []
    for k, d in enumerate(cells.length_m):
        _, time_s, work_j = arc(train, d, cells.grade_n[k], cells.air[k], w[k], w[k + 1])
        # A row that coasts has no work; its cells have a little of either sign.
        cost.append(
            ((max(work_j, 0.0) if ledger.label[k] in (TRACTION, HOLDING) else 0.0) + multiplier_j_per_s * time_s)
            / inertia
        )
    # Δ(p·w), with the jump at the start of a cell; the ends of the trip, where w = 0, have no such term.
    before = np.concatenate(([0.0], ledger.right[:-1] * w[1:-1]))
    loss = np.array(cost) + ledger.right * w[1:] - before - ledger.bound
    gap = hills.profile(12).total_energy_j + multiplier_j_per_s * hills.profile(12).duration_s - inertia * ledger.total
    assert inertia * loss.sum() == pytest.approx(gap, abs=1e-4 * hills.front.energy_j[12])
    assert loss.min() > -2e-5 * sum(cost)
    assert ledger.error < 1e-9 * ledger.total


def test_a_wrong_costate_or_price_only_loosens(hills, hills_certificate):
    problem, ledger, multiplier_j_per_s = _ledger(hills, 12)
    multiplier = multiplier_j_per_s / problem.train.inertia_kg
    rng = np.random.default_rng(1)
    x = ledger.cells.station_m / ledger.cells.station_m[-1]
    for size in (0.01, 0.03, 0.1, 0.5):
        for _ in range(5):
            wave = size * np.sin(2.0 * np.pi * (rng.integers(1, 6) * x + rng.random()))
            wrong = problem.evaluate(ledger, multiplier, ledger.left + wave[:-1], ledger.right + wave[1:])
            assert wrong.total < ledger.total
    jumps = rng.normal(size=len(ledger.left)) * 0.1
    broken = problem.evaluate(ledger, multiplier, ledger.left + jumps, ledger.right)
    assert broken.total < ledger.total
    time_s, profile = float(hills.front.time_s[12]), hills.profile(12)
    for factor in (0.3, 0.7, 1.5, 4.0):
        line_j = problem.line(profile.position_m, profile.speed_mps**2, factor * multiplier_j_per_s)
        assert line_j - factor * multiplier_j_per_s * time_s < hills_certificate.at(time_s) * (1.0 + 1e-4)


@pytest.mark.parametrize(
    ("train", "track", "start_mps", "end_mps"),
    [
        (TOY, TOY_LINE, 0.0, 0.0),
        (TOY, TOY_LINE, 0.3, 0.2),
        (TOY, TOY_LINE, 1e-4, 0.0),
        (METRO, HILLS, 8.0, 10.0),
        (METRO, HILLS, 0.0, 15.0),
        (METRO, HILLS, 0.05, 0.0),
    ],
)
def test_toy_scale_and_speeds_at_the_ends(train, track, start_mps, end_mps):
    result = tgvdp.search(train, track, points=12, start_speed_mps=start_mps, end_speed_mps=end_mps)
    certificate = result.certify()
    assert certificate.gap_pct.min() > -0.03
    assert np.median(certificate.gap_pct) < 0.15


def test_a_scaled_problem_has_the_same_gaps():
    # Ten times the mass, hundred times the length, ten times the speed: the same dimensionless problem.
    large = Train(
        mass_kg=10.0, traction=EffortCurve.from_caps(10.0, 80.0), friction_brake_n=10.0, davis_a_n=0.2,
        davis_b_n_per_mps=0.01, davis_c_n_per_mps2=0.002,
    )  # fmt: skip
    line = Track(length_m=200.0, speed_limits=((0.0, 50.0),), gradients=((0.0, 0.0), (100.0, -20.0)))
    small = tgvdp.search(TOY, TOY_LINE, points=8)
    certificate, scaled = small.certify(), tgvdp.search(large, line, points=8).certify()
    np.testing.assert_allclose(scaled.gap_pct, certificate.gap_pct, atol=0.02)


def test_a_line_without_real_limits_and_a_run_that_needs_no_energy():
    free = Track(length_m=2.0, speed_limits=((0.0, 1e6),))
    assert tgvdp.search(TOY, free, points=6).certify().gap_pct[1:].max() < 1.0
    downhill = Track(length_m=100.0, speed_limits=((0.0, 4.0),), gradients=((0.0, -60.0),))
    certificate = tgvdp.search(TOY, downhill, points=6).certify()
    assert (certificate.lower_bound_j >= 0.0).all()
    assert np.isfinite(certificate.gap_pct).all()


LEVEL = Train(
    name="level", mass_kg=100e3, rotating_mass_factor=1.1, traction=EffortCurve.from_caps(120e3),
    friction_brake_n=110e3, davis_a_n=2500.0, davis_b_n_per_mps=40.0, davis_c_n_per_mps2=8.0,
)  # fmt: skip


def _closed_form(train, length_m, multiplier):
    """Least E + λT on a long level line: full traction, holding where v²·R'(v) = λ, coasting, braking.

    While coasting and braking the Hamiltonian keeps its value of holding, so that braking begins at the speed v_b with
    λ/v_b = λ/v_h + R(v_h).
    """
    mass, a, b, c = train.inertia_kg, train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2
    pull, brake = train.traction.effort_n(0.0), train.friction_brake_n

    def resistance(v):
        return a + b * v + c * v * v

    roots = np.roots([2.0 * c, b, 0.0, -multiplier])
    hold = float(roots[np.abs(roots.imag) < 1e-9].real.max())
    slow = multiplier / (multiplier / hold + resistance(hold))
    parts = [
        (0.0, hold, lambda v: pull - resistance(v)),
        (slow, hold, resistance),
        (0.0, slow, lambda v: brake + resistance(v)),
    ]
    metres = [quad(lambda v, net=net: mass * v / net(v), lo, hi, epsrel=1e-12)[0] for lo, hi, net in parts]
    seconds = [quad(lambda v, net=net: mass / net(v), lo, hi, epsrel=1e-12)[0] for lo, hi, net in parts]
    held_m = length_m - sum(metres)
    assert held_m > 0.0
    energy_j = pull * metres[0] + resistance(hold) * held_m
    return energy_j, sum(seconds) + held_m / hold


@pytest.mark.parametrize("multiplier", [2e5, 5e5, 1.5e6])
def test_level_track_against_its_closed_form(multiplier):
    track = Track(length_m=40e3, speed_limits=((0.0, 100.0),))
    energy_j, time_s = _closed_form(LEVEL, 40e3, multiplier)
    trip = Trip(train=LEVEL, track=track, origin_m=0.0, destination_m=40e3)
    fastest = tgvdp.search(LEVEL, track, points=2, max_margin=0.01).fastest
    margin = time_s / fastest.time_s - 1.0
    result = tgvdp.search(LEVEL, track, points=12, max_margin=1.2 * margin)
    lower_j = result.certify().at(time_s)
    assert lower_j <= energy_j * (1.0 + 1e-9)
    assert lower_j >= energy_j * (1.0 - 3e-3)
    # The exact multiplier with the run of the nearest point: the line itself is second order in the error of the run.
    nearest = int(np.argmin(np.abs(result.front.time_s - time_s)))
    profile = result.profile(nearest)
    line_j = BoundingProblem(trip).line(profile.position_m, profile.speed_mps**2, multiplier)
    assert line_j <= (energy_j + multiplier * time_s) * (1.0 + 1e-9)


def test_bound_holds_for_random_rows(hills):
    # Any rows at all may suggest the costate: nonsense gives a loose bound, never a wrong one.
    rng = np.random.default_rng(3)
    problem = BoundingProblem(hills.trip)
    best_j = hills.front.energy_j + 2e5 * hills.front.time_s
    for _ in range(20):
        x_m = np.concatenate(([0.0], np.sort(rng.uniform(0.0, 3000.0, 30)), [3000.0]))
        w = np.concatenate(([0.0], rng.uniform(0.0, 300.0, 30) * rng.choice([0.0, 1.0], 30, p=[0.1, 0.9]), [0.0]))
        assert problem.line(x_m, w, 2e5) <= best_j.min()


def test_catalogue_trains_and_brakes_that_fade_towards_the_stop():
    # The electric brake of the EMU has almost no effort at standstill: its run creeps to the stop in tiny rows.
    track = Track(
        length_m=30e3, speed_limits=((0.0, 45.0), (20e3, 30.0)), gradients=((0.0, 0.0), (8e3, 6.0), (9e3, -5.0))
    )
    for name in ("alstom-emu", "tgv"):
        certificate = tgvdp.search(tgvdp.load_train(name), track, points=10).certify()
        assert np.isfinite(certificate.gap_pct).all()
        assert -0.01 < certificate.gap_pct.min() and np.median(certificate.gap_pct) < 0.15


def test_a_time_limit_ends_the_certificate_and_marks_what_it_did_not_reach(hills, hills_certificate):
    nothing = hills.certify(time_limit_s=1e-9)
    assert not nothing.complete
    assert np.isnan(nothing.gap_pct[1:]).all() and np.isnan(nothing.lower_bound_j[1:]).all()  # all but the fastest run
    assert nothing.at(float(hills.front.time_s[3])) == 0.0
    assert hills_certificate.complete


def test_points_beyond_the_last_line_have_no_bound(hills, monkeypatch):
    expire_after_lines(monkeypatch, 5)  # the fastest points come first, and only they have bounds
    part = hills.certify()
    assert not part.complete and len(part.line_j) == 6  # with the line that no duration can change
    reached = np.isfinite(part.gap_pct)
    assert reached[:2].any() and not reached[8:].any()
    assert (part.gap_pct[reached] > -0.01).all()


def test_the_fastest_run_itself_is_certified(hills, hills_certificate):
    # Whoever is as fast is nowhere slower: there is no other run of its time.
    assert hills_certificate.gap_pct[0] == 0.0
    assert hills_certificate.at(hills.fastest.time_s) == hills.front.energy_j[0]
    assert hills_certificate.at(hills.fastest.time_s * 1.001) < hills.front.energy_j[0]


def test_a_train_held_by_the_end_of_its_effort_curve():
    cutoff = EffortCurve.from_points([(0.0, 300e3), (12.0, 200e3), (18.0, 140e3), (18.0, 0.0)])
    train = Train(mass_kg=200e3, traction=cutoff, friction_brake_n=200e3, davis_a_n=4000.0, davis_c_n_per_mps2=9.0)
    track = Track(length_m=12e3, speed_limits=((0.0, 30.0),), gradients=((0.0, 2.0), (5e3, -1.0)))
    certificate = tgvdp.search(train, track, points=10).certify()
    assert certificate.gap_pct.min() > -0.01
    assert np.median(certificate.gap_pct) < 0.3


@pytest.mark.parametrize("friction_n", [0.0, 60e3])
def test_bound_at_the_pantograph_is_below_every_run(friction_n):
    train = Train(
        mass_kg=200e3, rotating_mass_factor=1.06, traction=EffortCurve.from_caps(300e3, 2.5e6),
        braking=EffortCurve.from_caps(200e3, 4e6), friction_brake_n=friction_n, davis_a_n=4000.0,
        davis_b_n_per_mps=60.0, davis_c_n_per_mps2=9.0, traction_efficiency=0.85, regeneration_efficiency=0.7,
        auxiliary_power_w=80e3,
    )  # fmt: skip
    result = tgvdp.search(train, HILLS, points=12, energy="pantograph")
    certificate = result.certify()
    assert (certificate.gap_pct > -0.02).all()
    problem = BoundingProblem(result.trip)
    for index in range(2, 12, 3):
        multiplier_j_per_s = float(result.price_kwh_per_min[index]) * 3.6e6 / 60.0
        profile = result.profile(index)
        rows = profile.position_m - result.trip.origin_m, profile.speed_mps**2
        for factor in (0.5, 1.0, 2.0):  # a wrong multiplier only loosens
            line_j = problem.line(*rows, factor * multiplier_j_per_s)
            assert (
                line_j <= (result.front.energy_j + factor * multiplier_j_per_s * result.front.time_s) * 1.0002
            ).all()
        own_j = problem.line(*rows, multiplier_j_per_s) - multiplier_j_per_s * profile.duration_s
        assert own_j > 0.9 * result.front.energy_j[index]


def test_costates_that_overflow_are_none():
    """Drag makes a costate that is a hair off grow e-fold every hundred metres: over 105 km beyond all numbers."""
    trip = proof_trip(20017)
    result = tgvdp.search(trip.train, trip.track, points=3, **trip.options)
    assert result.certify().gap_pct.max() < 0.1


def test_gaps_are_shares_of_what_is_drawn():
    """Braking returns nearly all of it on this descent: what is left says nothing of the size of a gap."""
    train = commuter(traction_efficiency=0.9, regeneration_efficiency=0.9, braking=EffortCurve.from_caps(3e5))
    track = trip_on([(0, 30)], [(0, 6), (4000, -9)], length_m=10e3).track
    result = tgvdp.search(train, track, points=10, energy="pantograph")
    certificate = result.certify()
    drawn_j = []
    for index in range(len(result.front)):
        balance = result.profile(index).balance
        drawn_j.append(balance.pantograph_j + balance.regenerated_j)
    size_j = np.maximum(drawn_j, 0.1 * drawn_j[0])
    above_j = result.front.energy_j - certificate.lower_bound_j
    np.testing.assert_allclose(certificate.gap_pct, 100.0 * above_j / size_j, rtol=1e-12)
    assert (size_j[1:] > 1.5 * np.abs(result.front.energy_j[1:])).all()
