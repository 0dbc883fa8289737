"""The demand model: curves, cost map, motion, fits, bounds."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tgvdp.errors import InputError
from tgvdp.formulations.problem.alstom import braking_n, energy_faults, force_n, power_w, traction_n
from tgvdp.formulations.problem.demand import demand_schedule, drive, slope_permil, step
from tgvdp.formulations.problem.instances import DemandInstance, Slope
from tgvdp.formulations.problem.reading import parse_instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.program.approximations import joint_fits, phantom_drag_n, split_fits
from tgvdp.formulations.program.demand import DEMAND_FORMS, demand_program
from tgvdp.solvers.exact.demand_bounds import demand_bounds


def instance(notches=2, **changes):
    levels = None if notches is None else tuple(j / notches for j in range(-notches, notches + 1))
    base = dict(
        id="d", steps=8, dt_s=15.0, levels=levels, mass_kg=3e5, rotating_factor=1.08, davis=(1770.0, 35.4, 6.6),
        vmax_mps=160 / 3.6, distance_m=1500.0, tol_m=30.0, end_speed_max_mps=1.5, p_max_w=9.8e6,
        cost_ref_mps=220 / 3.6, alpha=0.3,
    )  # fmt: skip
    return DemandInstance(**base | changes)


@pytest.mark.parametrize(
    ("curve", "joint_kmh", "jump_n"), [(traction_n, 50, 40), (traction_n, 60, -4866), (braking_n, 100, -1710)]
)
def test_jumps_of_the_curves(curve, joint_kmh, jump_n):
    below, above = curve(joint_kmh / 3.6), curve((joint_kmh + 1e-7) / 3.6)
    assert above - below == pytest.approx(jump_n, abs=2.0)


def test_brake_at_standstill_is_next_to_nothing_and_braking_brakes():
    assert braking_n(0.0) == pytest.approx(1.243)
    assert force_n(20.0, -0.5) == -0.5 * braking_n(20.0)
    assert force_n(20.0, 0.5) == 0.5 * traction_n(20.0)


def test_cost_map_is_scaled_to_p_max_and_needs_9_8_mw():
    assert power_w(220 / 3.6, 1.0, 3.7e6, 220 / 3.6, 0.3) == pytest.approx(3.7e6)
    assert power_w(220 / 3.6, -1.0, 3.7e6, 220 / 3.6, 0.3) == pytest.approx(-0.3 * 3.7e6)
    faults = energy_faults(3.7e6, 220 / 3.6, 0.3)
    assert faults.least_p_max_w == pytest.approx(9.8e6, rel=0.01)
    assert faults.traction_part > 0.5
    assert energy_faults(9.8e6, 220 / 3.6, 0.0).traction_part == 0.0


def test_resistance_slows_also_when_braking_and_standing_stays():
    one = instance()
    without = instance(davis=(0.0, 0.0, 0.0))
    assert step(one, 20.0, -0.5).speed_mps < step(without, 20.0, -0.5).speed_mps
    assert step(one, 0.0, 0.0).speed_mps == 0.0


def test_schedule_reports_every_violation():
    schedule = demand_schedule(instance(), [1, 1, 1, 1, 1, 1, 1, 0.3])
    broken = {check.name: check.violation for check in schedule.checks}
    assert broken["demand allowed"] == 1.0
    assert broken["distance"] > 0.0
    assert broken["end speed"] > 0.0
    assert broken["speed limit"] > 0.0
    assert replay(instance(), schedule)["objective"] == pytest.approx(schedule.objective)


def test_fits_are_least_squares():
    fits = split_fits(instance(None))
    v = np.linspace(0.0, 160 / 3.6, 221)
    for fit, curve in ((fits.traction, traction_n), (fits.braking, braking_n)):
        slope, start = np.polyfit(v, curve(v), 1)
        assert fit.coefficients == pytest.approx((start, slope), rel=1e-9)
        error = start + slope * v - curve(v)
        assert fit.rms == pytest.approx(np.sqrt(np.mean(error**2)))
        assert fit.worst == pytest.approx(np.abs(error).max())
    assert 0.0 < fits.cost.rms < fits.cost.worst < fits.cost.scale


def test_the_joint_polynomial_drags():
    fits = joint_fits(instance(None, vmax_mps=220 / 3.6))
    assert phantom_drag_n(fits, 100 / 3.6) == pytest.approx(6.4e3, rel=0.02)


@pytest.mark.parametrize("form", DEMAND_FORMS)
@pytest.mark.parametrize("slopes", [(), (Slope(0.0, 4.0),), (Slope(0.0, 4.0), Slope(100.0, -6.0), Slope(300.0, 2.5))])
def test_program_is_satisfied_by_its_own_motion(form, slopes):
    """Simulate demands by the fitted forces: all rows of motion hold, and the objective is the fitted cost."""
    one = instance(2, steps=5, slopes=slopes)
    program = demand_program(one, form)
    demand = np.array([1.0, 0.5, 0.0, -0.5, 0.0])
    fits = joint_fits(one) if form == "joint" else split_fits(one)
    names = [variable.name for variable in program.program.variables]
    values = np.zeros(len(names))
    v, s, cost = 0.0, 0.0, 0.0
    for i, d in enumerate(demand):
        p, q = max(d, 0.0), max(-d, 0.0)
        if form == "joint":
            per_v, per_d, per_vd = fits.force.coefficients
            force = per_v * v + per_d * d + per_vd * v * d
        else:
            (a0, a1), (b0, b1) = fits.traction.coefficients, fits.braking.coefficients
            force = p * (a0 + a1 * v) - q * (b0 + b1 * v)
        a, b, c = one.davis
        on = sum(slope.from_m <= s for slope in slopes) - 1
        climb = 3e5 * 9.81 * slopes[on].permil / 1000.0 if slopes else 0.0
        after = v + one.dt_s * (force - climb - a - b * v - c * v * v) / (1.08 * 3e5)
        held = max(0.0, -after)
        after, mean = max(0.0, after), 0.5 * (v + max(0.0, after))
        if form == "joint":
            per_v, per_d, per_vd = fits.cost.coefficients
            cost += one.dt_s * (per_v * mean + per_d * d + per_vd * mean * d)
        else:
            per_vp, per_p = fits.cost.coefficients
            cost += one.dt_s * (p - 0.3 * q) * (per_vp * mean + per_p)
        chosen = {f"v_{i + 1}": after, f"held_{i}": held, f"stands_{i}": float(after == 0.0), f"delta_{i}": d > 0.0}
        chosen |= {"split": {f"p_{i}": 2 * p, f"q_{i}": 2 * q}, "delta": {f"d_{i}": 2 * d, f"p_{i}": 2 * p},
                   "joint": {f"d_{i}": 2 * d}}[form]  # fmt: skip
        if len(slopes) > 1:
            chosen |= {f"on_{i}_{on}": 1.0} | ({f"s_{i}": s} if i else {})
        v, s = after, s + mean * one.dt_s
        for name, value in chosen.items():
            values[names.index(name)] = value

    def worth(linear, products):
        total = sum(weight * values[j] for j, weight in linear.items())
        return total + sum(weight * values[j] * values[k] for (j, k), weight in products.items())

    for row in program.program.rows:
        if row.name not in ("distance", "end"):
            assert row.lower - 1e-6 <= worth(row.linear, row.products) <= row.upper + 1e-6, row.name
    assert worth(program.program.linear, program.program.products) == pytest.approx(cost, rel=1e-9)
    assert program.demands(values) == tuple(demand)
    if len(slopes) > 1:  # a bit of another slope does not fit the place
        values[names.index("on_4_0")], values[names.index(f"on_4_{on}")] = 1.0, 0.0
        assert any(worth(row.linear, row.products) > row.upper + 1.0 for row in program.program.rows)


def test_gradient_and_curve_slow_the_train_at_their_place():
    file = {"id": "hill", "params": {
        "kind": "demand", "N": 8, "dt_s": 15, "notches": 2, "mass_kg": 3e5, "rot": 1.08, "davis_SI": [1770, 35.4, 6.6],
        "vmax_kmh": 160, "D_m": 1500, "tol_m": 30, "v_end_max_mps": 1.5, "P_max_W": 9.8e6, "cost_ref_kmh": 220,
        "gradients_permil": [[0, 0], [500, 12]], "curves_m": [[0, None], [800, 400]],
    }}  # fmt: skip
    one = parse_instance(Path("hill.json"), file)
    assert one.slopes == (Slope(0.0, 0.0), Slope(500.0, 12.0), Slope(800.0, 14.0))
    assert slope_permil(one, [0.0, 499.0, 500.0, 900.0, 9e9]).tolist() == [0.0, 0.0, 12.0, 14.0, 14.0]
    lost = step(one, 20.0, 0.5, 0.0).speed_mps - step(one, 20.0, 0.5, 14.0).speed_mps
    assert lost == pytest.approx(15.0 * 9.81 * 0.014 / 1.08)
    plan = [1, 1, 0.5, 0, 0, 0, -1, -1]
    flat, hilly = (replay(one, demand_schedule(case, plan)) for case in (replace(one, slopes=()), one))
    assert hilly == flat  # replay trusts only the controls
    assert hilly["distance_m"] == pytest.approx(float(drive(one, plan).distance_m))
    assert hilly["distance_m"] < float(drive(replace(one, slopes=()), plan).distance_m)


@pytest.mark.parametrize(("field", "rows"), [("gradients_permil", [[5, 1]]), ("curves_m", [[0, 300], [0, 400]])])
def test_places_of_slopes_start_at_the_origin_and_increase(field, rows):
    file = {"id": "x", "params": {
        "kind": "demand", "N": 8, "dt_s": 15, "notches": 2, "mass_kg": 3e5, "rot": 1.08, "davis_SI": [1770, 35.4, 6.6],
        "vmax_kmh": 160, "D_m": 1500, "tol_m": 30, "v_end_max_mps": 1.5, "P_max_W": 9.8e6, "cost_ref_kmh": 220,
        field: rows,
    }}  # fmt: skip
    with pytest.raises(InputError, match=rf"x.json: params.{field}: positions must start at 0 m and increase"):
        parse_instance(Path("x.json"), file)


def test_cost_to_go_is_a_lower_bound_along_random_plans():
    rng = np.random.default_rng(5)
    checked = 0
    while checked < 25:
        notches = int(rng.integers(1, 4))
        levels = np.arange(-notches, notches + 1) / notches
        plan = rng.choice(levels, size=int(rng.integers(3, 20)), p=_leaning(levels))
        starts = np.sort(rng.uniform(0.0, 3000.0, int(rng.integers(0, 4))))
        slopes = tuple(Slope(float(at), float(rng.uniform(-10, 10))) for at in (0.0, *starts)) if starts.size else ()
        one = instance(
            notches, steps=plan.size, end_speed_max_mps=70.0, vmax_mps=float(rng.choice([30.0, 60.0])), slopes=slopes
        )
        motion = drive(one, plan)
        if motion.speed_mps.max() > one.vmax_mps or motion.distance_m < 1.0:
            continue
        one = instance(
            notches, steps=plan.size, vmax_mps=one.vmax_mps, slopes=slopes, distance_m=float(motion.distance_m),
            tol_m=0.1, end_speed_max_mps=float(motion.speed_mps[-1]) + 1e-6,
        )  # fmt: skip
        bounds = demand_bounds(one, levels)
        gone = np.zeros(plan.size + 1)
        costs = np.zeros(plan.size + 1)
        for k, d in enumerate(plan):
            done = step(one, motion.speed_mps[k], d, slope_permil(one, gone[k]))
            gone[k + 1], costs[k + 1] = gone[k] + done.distance_m, costs[k] + done.cost_j
        for k in range(plan.size + 1):
            bound = bounds.cost_to_go(one, k, motion.speed_mps[k : k + 1], gone[k : k + 1])[0]
            assert bound <= costs[-1] - costs[k] + 1e-6 * abs(costs).max()
        checked += 1


def _leaning(levels):
    weights = 1.0 + 2.0 * (levels >= 0.0)
    return weights / weights.sum()
