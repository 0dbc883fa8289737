"""Potentials that are curved in the speed: never above a sampled value or a run, and tight on steep descents."""

import math

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.trips import trip_on
from tgvdp import EffortCurve, Train
from tgvdp.certificate.cell_bounds import WHOLE, cell_kernel
from tgvdp.certificate.curved import least_at
from tgvdp.certificate.efforts import Load, merge_tables
from tgvdp.certificate.hamiltonian import Hamiltonian
from tgvdp.certificate.line import BoundingProblem
from tgvdp.physics.forces import kernel_train

TRIP = trip_on(
    [(0, 30), (3000, 20)],
    [(0, 0), (2000, 8), (4000, -6)],
    length_m=6000.0,
    start_speed_mps=10.0,
    end_speed_mps=12.0,
)
MASS_KG, TOP_MPS = 1000.0, 30.0
#: Efforts of all kinds: constant, of a power, linear, cubic, with drops; dynamic brakes stronger than time is dear.
TRAINS = {
    "caps": Train(
        mass_kg=MASS_KG, traction=EffortCurve.from_caps(2000.0, 20e3), braking=EffortCurve.from_caps(1500.0, 12e3),
        friction_brake_n=500.0, davis_a_n=20.0, davis_b_n_per_mps=1.0, davis_c_n_per_mps2=0.1,
    ),
    "table": Train(
        mass_kg=MASS_KG, traction=EffortCurve.from_points([(0, 2000), (5, 2000), (12, 1100), (12, 900), (40, 200)]),
        braking=EffortCurve.from_points([(0, 500), (10, 1500), (10, 1200), (40, 300)]), davis_a_n=20.0,
        davis_b_n_per_mps=2.0, max_acceleration_mps2=1.0, max_deceleration_mps2=1.1,
    ),
}  # fmt: skip


def hamiltonian(rng, name):
    """A cell's Hamiltonian with a random gradient and price of time; some efforts get a term in v³."""
    train = kernel_train(TRAINS[name])
    mass = train.inertia_kg
    load = Load((train.davis_a_n + MASS_KG * 9.81e-3 * rng.choice([-60.0, -25.0, 0.0, 30.0])) / mass,
                train.davis_b / mass, TRAINS[name].davis_c_n_per_mps2 / mass)  # fmt: skip
    pieces = np.zeros((3, 12, 6))
    counts = merge_tables(train, load, TOP_MPS, pieces)
    if rng.random() < 0.3:
        pieces[:, :, 5] = 2e-6 * rng.random()
    traction, regeneration = rng.choice([(1.0, 0.0), (1.2, 0.8), (1.0, 1.0)])
    return Hamiltonian(pieces, *counts, traction, regeneration, load, abs(load.r0), rng.choice([0.5, 3.0, 12.0]))


def effort(pieces, n, v):
    """An effort at speeds, (m,), the larger one where it steps."""
    i = np.searchsorted(pieces[:n, 0], v, side="right") - 1
    value = lambda j: pieces[j, 1] / v + pieces[j, 2] + v * (pieces[j, 3] + v * (pieces[j, 4] + v * pieces[j, 5]))  # noqa: E731
    return np.where((i > 0) & (pieces[i, 0] == v), np.maximum(value(i), value(np.maximum(i - 1, 0))), value(i))


def least_sampled(h, p, p_s, r, r_s, v):
    """Least H over speeds and efforts between full traction and full braking."""
    pull, brake, dynamic = (effort(h.pieces[i], n, v) for i, n in enumerate((h.pulls, h.brakes, h.dynamics)))
    load = h.load.r0 + v * (h.load.r1 + v * h.load.r2)
    best = np.full_like(v, math.inf)
    for share in np.linspace(0.0, 1.0, 5):
        for f in (share * pull, -share * dynamic, -dynamic - share * (brake - dynamic)):
            energy = h.traction * np.maximum(f, 0.0) - h.regeneration * np.minimum(np.maximum(-f, 0.0), dynamic)
            flow = p_s * v**2 + r_s * (2.0 / 3.0) * v**3 + 2.0 * (p + r * v) * (f - load)
            best = np.minimum(best, energy + h.multiplier / v + flow)
    return best


def draw(rng):
    """p, p', r, r' of a cell."""
    r = rng.choice([0.0, 1.0, -1.0]) * 10 ** rng.uniform(-4.0, -1.0)
    r_s = rng.choice([0.0, 1.0, -1.0]) * 10 ** rng.uniform(-6.0, -3.0)
    return rng.uniform(-2.0, 1.0), rng.normal(0.0, 0.01), r, r_s


@pytest.mark.nojit
@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("seed", range(60))
def test_least_value_is_below_every_sampled_speed_and_effort_and_tight(name, seed):
    rng = np.random.default_rng(seed)
    h, potential = hamiltonian(rng, name), draw(rng)
    low_v, top_v = sorted(rng.uniform(0.0, TOP_MPS, 2)) if seed % 3 else (0.0, TOP_MPS)
    found, doubt, at = least_at(h, *potential, low_v, top_v)
    v = np.linspace(max(low_v, 0.02), top_v, 3001)
    sampled = least_sampled(h, *potential, v)
    best, size = sampled.min(), doubt / 200.0
    assert found <= best + 1e-12 * size
    assert found >= best - max(5e-3 * size, 2.0 * np.abs(np.diff(sampled)).max())
    assert low_v <= at <= top_v


@pytest.mark.nojit
@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("seed", range(20))
def test_bound_of_a_cell_is_below_its_mean_over_every_place(name, seed):
    """Whichever speeds and efforts a run has within the cell, below a speed bound that rises or falls."""
    rng = np.random.default_rng(seed)
    h, length = hamiltonian(rng, name), rng.uniform(5.0, 200.0)
    (p0, _, r0, _), (_, _, r1, _) = draw(rng), draw(rng)
    p1 = p0 + rng.normal(0.0, 0.05)
    start_v, end_v = rng.uniform(10.0, TOP_MPS, 2) if seed % 2 else (25.0, 25.0)
    top_v = max(start_v, end_v)
    least0, least1, *_ = cell_kernel(h, WHOLE, p0, p1, r0, r1, length, top_v, start_v**2, end_v**2)
    least = []
    for share in np.linspace(0.0, 1.0, 21):
        v = np.linspace(0.02, math.sqrt(start_v**2 + share * (end_v**2 - start_v**2)), 1500)
        p, r = p0 + share * (p1 - p0), r0 + share * (r1 - r0)
        least.append(least_sampled(h, p, (p1 - p0) / length, r, (r1 - r0) / length, v).min())
    scale = np.abs(least).max() + h.multiplier / top_v
    assert 0.5 * (least0 + least1) <= np.trapezoid(least, dx=0.05) + 2e-4 * scale


#: Steep descents on which the dynamic brake works at full power while a second is worth less than what that returns.
POWER = ((1797000253, 0.05),)


@pytest.mark.parametrize(("seed", "most_pct"), POWER)
def test_gaps_of_trips_that_brake_at_limited_power(seed, most_pct):
    trip = proof_trip(seed)
    gap_pct = tgvdp.search(trip.train, trip.track, points=12, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < most_pct


def test_gaps_of_a_train_that_creeps_in_after_coasting():
    """A second costs so little at long running times that the linear part of the resistance makes H concave."""
    trip = proof_trip(2600825)
    gap_pct = tgvdp.search(trip.train, trip.track, points=6, **trip.options).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[1:].max() < 0.2


def test_it_is_tried_only_where_a_train_that_coasts_gains_more_than_time_costs():
    train = Train(
        mass_kg=1e5, traction=EffortCurve.from_caps(1e5, 2e6), davis_a_n=1e3, davis_b_n_per_mps=300.0,
        friction_brake_n=1e5, traction_efficiency=0.8,
    )  # fmt: skip
    trips = [tgvdp.search(train, TRIP.track, points=3, energy=energy).trip for energy in ("pantograph", "wheel")]
    for trip, dearer in zip(trips, (1.25, 1.0), strict=True):
        problem = BoundingProblem(trip)
        price = dearer * 300.0 * problem.top_mps**2 / 3.0
        assert problem.may_curve(0.99 * price)
        assert not problem.may_curve(1.01 * price)


def test_it_is_tried_only_where_longer_braking_returns_more_than_time_costs():
    train = Train(
        mass_kg=1e5, traction=EffortCurve.from_caps(1e5, 2e6), braking=EffortCurve.from_caps(1e5, 1e6), davis_a_n=1e3,
        friction_brake_n=1e5, regeneration_efficiency=0.8,
    )  # fmt: skip
    trips = [tgvdp.search(train, TRIP.track, points=3, energy=energy).trip for energy in ("pantograph", "wheel")]
    assert BoundingProblem(trips[0]).may_curve(0.79e6)
    assert not BoundingProblem(trips[0]).may_curve(0.81e6)
    assert not BoundingProblem(trips[1]).may_curve(1.0)
