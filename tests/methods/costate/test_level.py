"""The front method on level track, where quadrature gives the optimum: E and T for any multiplier."""

import math
from dataclasses import replace

import pytest

from tests.helpers.fronts import front_at, front_to
from tests.helpers.twins.level import optimal_run
from tests.helpers.twins.trips import level_trip
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import Train
from tgvdp.runs.fastest import fastest_run

FREIGHT = Train(
    mass_kg=4e5,
    traction=EffortCurve.from_caps(3e5, 5e6),
    friction_brake_n=3e5,
    rotating_mass_factor=1.06,
    davis_a_n=4e3,
    davis_b_n_per_mps=50.0,
    davis_c_n_per_mps2=8.0,
)
UNIT = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0)
#: Train, length in m, limit in m/s, multipliers in J/s.
LEVEL = {
    "unit mass, Davis": (
        replace(UNIT, traction=EffortCurve.from_caps(0.5), davis_a_n=0.01, davis_b_n_per_mps=5e-4,
                davis_c_n_per_mps2=2e-5),
        20e3, 200.0, (2.0, 0.5, 0.1),
    ),
    "unit mass, quadratic": (replace(UNIT, davis_a_n=0.05, davis_c_n_per_mps2=0.01), 500.0, 200.0, (20.0, 5.0, 1.0)),
    "constant resistance: no holding": (replace(UNIT, davis_a_n=0.05), 500.0, 200.0, (20.0, 5.0, 1.0)),
    "constant resistance, limit": (replace(UNIT, davis_a_n=0.05), 2000.0, 15.0, (5.0, 1.0, 0.3)),
    "power limit": (FREIGHT, 30e3, 200.0, (5e6, 1e6, 3e5)),
    "comfort limits": (
        replace(FREIGHT, max_acceleration_mps2=0.5, max_deceleration_mps2=0.5, max_speed_mps=40.0),
        30e3, 33.0, (5e6, 1e6, 3e5),
    ),
    "metro": (
        Train(mass_kg=2e5, traction=EffortCurve.from_caps(2e5, 3e6), friction_brake_n=2e5, davis_a_n=3e3,
              davis_c_n_per_mps2=6.0),
        1500.0, 22.0, (1e6, 3e5, 1e5),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LEVEL)
def test_level_track_has_a_closed_form(name):
    """E at the closed form's own running times; blends of two multipliers may cost 2e-4."""
    train, length_m, limit_mps, multipliers = LEVEL[name]
    trip = level_trip(train, length_m, limit_mps)
    fastest_s = fastest_run(trip).duration_s
    expected = [optimal_run(train, length_m, limit_mps, multiplier) for multiplier in multipliers]
    found = front_at(trip, [fastest_s, *(run.duration_s for run in expected)], tolerance_s=1e-6 * fastest_s)
    for run, multiplier, seconds, joules in zip(
        expected, multipliers, found.duration_s[1:], found.energy_j[1:], strict=True
    ):
        assert seconds == pytest.approx(run.duration_s, abs=1e-6 * fastest_s)
        energy = joules + multiplier * (seconds - run.duration_s)
        assert run.energy_j * (1.0 - 1e-5) <= energy <= run.energy_j * (1.0 + 2e-4)


@pytest.mark.parametrize("name", LEVEL)
def test_one_multiplier_solves_its_own_problem(name):
    """The cost E + λT of an extremal is stationary: it must be far better than the energy alone."""
    train, length_m, limit_mps, multipliers = LEVEL[name]
    trip = level_trip(train, length_m, limit_mps)
    mesh = Mesh.of(trip, fastest_run(trip))
    counters = {"extremals": 0, "runs": 0, "costates": 0}
    for multiplier in multipliers:
        run = optimal_run(train, length_m, limit_mps, multiplier)
        extremal = mesh.extremal(multiplier, counters)
        cost, best = extremal.energy_j + multiplier * extremal.time_s, run.energy_j + multiplier * run.duration_s
        assert cost == pytest.approx(best, rel=1e-5)


@pytest.mark.parametrize("name", LEVEL)
def test_a_finer_mesh_meets_the_closed_form(name):
    """What the usual mesh misses is its own size, not the method: 16 times finer cells agree to 2e-6."""
    train, length_m, limit_mps, multipliers = LEVEL[name]
    trip = level_trip(train, length_m, limit_mps)
    mesh = Mesh.of(trip, fastest_run(trip), 16.0)
    for multiplier in multipliers:
        run = optimal_run(train, length_m, limit_mps, multiplier)
        extremal = mesh.extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0})
        cost, best = extremal.energy_j + multiplier * extremal.time_s, run.energy_j + multiplier * run.duration_s
        assert cost == pytest.approx(best, rel=2e-6)


def test_closed_form_twin_knows_textbook_cases():
    """V²·R'(V) = λ, and coasting ends at U = λ/(R(V) + λ/V) (Howlett & Pudney)."""
    train, length_m, limit_mps, _ = LEVEL["unit mass, quadratic"]
    run = optimal_run(train, length_m, limit_mps, 5.0)
    assert run.top_mps == pytest.approx((5.0 / 0.02) ** (1.0 / 3.0))
    assert run.brake_from_mps == pytest.approx(5.0 / (0.05 + 0.01 * run.top_mps**2 + 5.0 / run.top_mps))
    # Constant forces: traction a = 1 − R, coasting R, braking b = 1 + R, all by hand.
    train, length_m, limit_mps, _ = LEVEL["constant resistance: no holding"]
    run = optimal_run(train, length_m, limit_mps, 1.0)
    top, low = run.top_mps, run.brake_from_mps
    assert run.duration_s == pytest.approx(top / 0.95 + (top - low) / 0.05 + low / 1.05, rel=1e-12)
    assert run.energy_j == pytest.approx(top**2 / 2 / 0.95, rel=1e-12)
    assert run.energy_j == pytest.approx(0.05 * length_m + low**2 / 2 / 1.05, rel=1e-9)  # resistance and brake


def test_without_resistance_it_is_bang_coast_brake():
    """v²/2 in, v²/2 out, and T = 2·v/a + (L − v²/a)/v for an acceleration a both ways."""
    trip = level_trip(UNIT, 1000.0)
    fastest, found = front_to(trip, 1.0, 20)
    assert fastest.duration_s == pytest.approx(2.0 * math.sqrt(1000.0))
    for seconds, joules in zip(found.duration_s, found.energy_j, strict=True):
        v = seconds / 2.0 - math.sqrt(seconds**2 / 4.0 - 1000.0) if seconds > fastest.duration_s else math.sqrt(1000.0)
        assert joules == pytest.approx(v * v / 2.0, rel=2e-3)
