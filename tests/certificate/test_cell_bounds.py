"""The kernels of the certificate against brute force: no sampled value may lie below a bound, and bounds are tight."""

import math

import numpy as np
import pytest

from tgvdp import EffortCurve, Train
from tgvdp.certificate.cell_bounds import WHOLE, cell_kernel, standstill_cell, standstill_terms
from tgvdp.certificate.costates_at_bound import FullEffort, tangent_and_excess
from tgvdp.certificate.efforts import Load, largest_effort, load_at, merge_tables, piece_at, piece_value
from tgvdp.certificate.hamiltonian import Hamiltonian, least_hamiltonian
from tgvdp.physics.forces import kernel_train
from tgvdp.physics.minimum import least_on_piece

pytestmark = pytest.mark.nojit


def _brute_least(coefficients, lo, hi):
    a, b0, b1, b2, b3 = coefficients
    v = np.linspace(max(lo, 1e-3 * hi), hi, 4001)
    return (a / v + b0 + b1 * v + b2 * v**2 + b3 * v**3).min()


@pytest.mark.parametrize("seed", range(40))
def test_least_value_of_a_piece_is_below_every_sample_and_tight(seed):
    rng = np.random.default_rng(seed)
    lo, hi = sorted(rng.uniform(0.05, 30.0, 2))
    if seed % 4 == 0:
        lo = 0.0
    a, b0, b1, b2, b3 = rng.normal(size=5) * np.array([100.0, 1.0, 1.0, 0.1, 0.01]) * rng.choice([0.0, 1.0], 5)
    a = abs(a) + 0.1 if lo == 0.0 else a
    found, at = least_on_piece(a, b0, b1, b2, b3, lo, hi, math.inf, hi)
    brute = _brute_least((a, b0, b1, b2, b3), lo, hi)
    scale = abs(a) / hi + abs(b0) + abs(b1) * hi + abs(b2) * hi**2 + abs(b3) * hi**3
    assert found <= brute + 1e-12 * scale
    assert found >= brute - 1e-3 * scale
    assert lo <= at <= hi


TRAINS = {
    "caps": Train(
        mass_kg=1000.0, traction=EffortCurve.from_caps(2000.0, 20e3), braking=EffortCurve.from_caps(1500.0, 25e3),
        friction_brake_n=500.0, davis_a_n=20.0, davis_b_n_per_mps=1.0, davis_c_n_per_mps2=0.1,
    ),
    "comfort": Train(
        mass_kg=1000.0, traction=EffortCurve.from_caps(2000.0, 20e3), friction_brake_n=2000.0, davis_a_n=20.0,
        davis_c_n_per_mps2=0.1, max_acceleration_mps2=1.2, max_deceleration_mps2=0.9, rotating_mass_factor=1.05,
    ),
    "table": Train(
        mass_kg=1000.0, traction=EffortCurve.from_points([(0, 2000), (5, 2000), (12, 1100), (12, 900), (40, 200)]),
        braking=EffortCurve.from_points([(0, 500), (10, 1500), (40, 700)]), davis_a_n=20.0, davis_b_n_per_mps=2.0,
        max_acceleration_mps2=1.0,
    ),
}  # fmt: skip


def _hamiltonian(train, load, top_v, traction=1.0, regeneration=0.0, multiplier=2.0):
    pieces = np.empty((3, 12, 6))
    counts = merge_tables(train, load, top_v, pieces)
    return Hamiltonian(pieces, *counts, traction, regeneration, load, abs(load.r0), multiplier)


def _level(train):
    return Load(train.davis_a_n / train.inertia_kg, train.davis_b / train.inertia_kg, 1e-4)


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("permil", [-160.0, -25.0, 0.0, 30.0, 160.0])
@pytest.mark.parametrize(("traction", "regeneration"), [(1.0, 0.0), (1.25, 0.7)])
def test_least_hamiltonian_is_below_every_sampled_speed_and_effort(name, permil, traction, regeneration):
    train = kernel_train(TRAINS[name])
    curves = TRAINS[name]
    mass = train.inertia_kg
    grade = curves.mass_kg * 9.81e-3 * permil
    resistance = Load((train.davis_a_n + grade) / mass, train.davis_b / mass, curves.davis_c_n_per_mps2 / mass)
    top_v, multiplier = 30.0, 2.0
    h = _hamiltonian(train, resistance, top_v, traction, regeneration, multiplier)
    v = np.linspace(0.02, top_v, 1500)
    load = resistance.r0 + resistance.r1 * v + resistance.r2 * v**2
    dynamic = np.array([curves.braking.effort_n(x) for x in v]) / mass
    # A comfort limit cuts efforts, to none where the load alone does more.
    most = np.maximum(train.max_acceleration + load, 0.0)
    strongest = np.minimum([curves.traction.effort_n(x) / mass for x in v], most)
    hardest = np.maximum(-dynamic - curves.friction_brake_n / mass, np.minimum(load - train.max_deceleration, 0.0))
    costates = [(-3.0, 0.05), (-0.7, 0.002), (-0.5, 0.0), (-0.45, 0.001), (-0.2, 0.001), (0.0, 0.001), (0.4, 0.003)]
    for p, p_s in [*costates, (2.0, 0.01)]:
        found, _, _ = least_hamiltonian(h, p, p_s, 0.0, top_v)
        best = math.inf
        for f in (*(hardest + share * (strongest - hardest) for share in np.linspace(0.0, 1.0, 11)), -dynamic, 0.0):
            f = np.clip(f, hardest, strongest)
            energy = traction * np.maximum(f, 0.0) - regeneration * np.minimum(np.maximum(-f, 0.0), dynamic)
            best = min(best, (energy + multiplier / v + p_s * v**2 + 2.0 * p * (f - load)).min())
        assert found <= best + 1e-9
        assert found >= best - 2e-2 * abs(best) - 2e-2  # as fine as the sampling


def test_largest_effort_bounds_a_table():
    table = TRAINS["table"].traction.table
    for v in (0.0, 3.0, 8.0, 12.0, 35.0):
        samples = [TRAINS["table"].traction.effort_n(x) for x in np.linspace(0.0, v, 500)]
        assert largest_effort(table, len(table), 0.0, v) >= max(samples)


def _standstill(pieces, start, length, multiplier, slope, end_w, per_joule):
    terms = standstill_terms(pieces, 1, Load(0.0, 0.0, 0.0), start, length, multiplier, end_w, 1e6, per_joule)
    return standstill_cell(*terms, start, slope, per_joule)


def test_standstill_cell_is_exact_for_constant_effort():
    # M = 2, no load: w = 4d after d metres, time √(2d/2), work ½w; the other end costs slope·w.
    pieces = np.array([[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]])
    d, multiplier, slope = 3.0, 5.0, -0.8
    bound = _standstill(pieces, True, d, multiplier, slope, 0.0, 1.0)
    assert bound == pytest.approx(multiplier * math.sqrt(d) + (0.5 + slope) * 4.0 * d, rel=1e-12)
    # From w = 1 on: w = 1 + 4d, time 2d/(1 + √13), work ½(w − 1).
    bound = _standstill(pieces, True, d, multiplier, slope, 1.0, 1.0)
    assert bound == pytest.approx(
        multiplier * 2.0 * d / (1.0 + math.sqrt(13.0)) + (0.5 + slope) * 13.0 - 0.5, rel=1e-12
    )
    bound = _standstill(pieces, False, d, multiplier, -0.3, 0.0, 0.0)
    assert bound == pytest.approx(multiplier * math.sqrt(d) - 0.3 * 12.0, rel=1e-12)


def _stepped():
    """Brakes without load that keep 0.5 m/s² above 15 m/s, 0.9 below, all by the dynamic brake below 10 m/s."""
    pieces = np.zeros((3, 3, 6))
    pieces[:, 1:, 0] = 10.0, 15.0
    pieces[0, 0, 2] = 1.0
    pieces[1, :, 2] = 0.9, 0.9, 0.5
    pieces[2, :, 2] = 0.9, 0.4, 0.3
    return Hamiltonian(pieces, 1, 3, 3, 1.25, 0.6, Load(0.0, 0.0, 0.0), 0.0, 2.0)


@pytest.mark.parametrize("p", [-0.2, 0.0, 0.05, 0.8])
@pytest.mark.parametrize("v", [3.0, 12.0, 15.2, 18.0, 30.0])
def test_least_chord_of_brakes_keeps_the_least_hamiltonian_at_the_run(p, v):
    h = _stepped()
    tangent, excess = tangent_and_excess(FullEffort(False, h), p, v)
    assert (excess > 0.0) == (v > 10.0)
    brake, dynamic = (piece_value(h.pieces[i], piece_at(h.pieces[i], 3, v), v) for i in (1, 2))
    spent = -(0.6 + 2.0 * p) * dynamic if p <= 0.0 else -0.6 * dynamic - 2.0 * p * brake
    here = spent + h.multiplier / v + (tangent - excess) * v**2
    least, _, _ = least_hamiltonian(h, p, tangent - excess, 0.0, v)
    assert here - 2e-3 * abs(here) <= least <= here + 1e-12 * abs(here)


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("p", [-0.55, -0.8, -2.0])
def test_least_chord_keeps_the_least_hamiltonian_at_the_run(name, p):
    train = kernel_train(TRAINS[name])
    h = _hamiltonian(train, _level(train), 40.0)
    for v in (3.0, 8.0, 12.5, 15.0, 30.0):
        tangent, excess = tangent_and_excess(FullEffort(True, h), p, v)
        assert excess >= 0.0

        def least(slope, v=v):
            return least_hamiltonian(h, p, slope, 0.0, v)

        i = piece_at(h.pieces[0], h.pulls, v)
        bare = (1.0 + 2.0 * p) * piece_value(h.pieces[0], i, v) + h.multiplier / v - 2.0 * p * load_at(h.load, v)
        here = bare + (tangent - excess) * v**2
        assert here - 2e-3 * abs(here) <= least(tangent - excess)[0] <= here + 1e-12 * abs(bare)
        if name == "table" and v == 12.5:  # behind the drop the costate equation alone would lose the run
            below, _, at = least(tangent)
            assert below < bare + tangent * v**2 - 0.01 and at <= 12.0


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("p", [-2.0, -0.4, 0.7])
def test_ranges_of_speed_together_hold_the_least_hamiltonian(name, p):
    train = kernel_train(TRAINS[name])
    h = _hamiltonian(train, _level(train), 40.0)
    for p_s in (-0.01, 0.0, 0.02):

        def least(low_v, top_v, p_s=p_s):
            return least_hamiltonian(h, p, p_s, low_v, top_v)

        whole, _, at = least(0.0, 30.0)
        for split in (0.5, 5.0, 12.0, 20.0, 30.0):
            (slow, _, slow_at), (fast, _, fast_at) = least(0.0, split), least(split, 30.0)
            assert min(slow, fast) == pytest.approx(whole, rel=1e-9)
            assert slow_at <= split <= fast_at <= 30.0
        assert least(at * (1.0 - 1e-12), at)[0] == pytest.approx(whole, rel=1e-9)


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize(("start_v", "end_v"), [(8.0, 9.0), (11.9, 12.3), (12.1, 12.4), (20.0, 19.0)])
def test_cell_below_a_rising_bound_is_below_every_sample_and_tighter_than_a_flat_one(name, start_v, end_v):
    train = kernel_train(TRAINS[name])
    h = _hamiltonian(train, _level(train), 40.0)
    length = 5.0
    top_v = max(start_v, end_v)
    gained = 0.0
    for p0, p1 in ((-3.0, -2.9), (-3.0, -3.0), (-3.0, -3.2), (-0.8, -0.78), (-0.3, -0.35), (0.4, 0.5)):
        args = h, WHOLE, p0, p1, 0.0, 0.0, length, top_v
        found = 0.5 * sum(cell_kernel(*args, start_v**2, end_v**2)[:2])
        flat = 0.5 * sum(cell_kernel(*args, top_v**2, top_v**2)[:2])
        samples = []
        for share in np.linspace(0.0, 1.0, 41):
            bound_v = math.sqrt(start_v**2 + share * (end_v**2 - start_v**2))
            p = p0 + share * (p1 - p0)
            least, *_ = least_hamiltonian(h, p, (p1 - p0) / length, 0.0, bound_v)
            samples.append(least)
        exact = float(np.trapezoid(samples, dx=1.0 / 40.0))
        assert flat - 1e-12 * abs(flat) <= found <= exact + 1e-3 * abs(exact - flat) + 1e-9 * abs(exact)
        gained = max(gained, (found - flat) / (exact - flat) if exact - flat > 1e-9 * abs(exact) else 0.0)
    assert gained > 0.9  # most of what a bound at the cell's largest speed gives away
