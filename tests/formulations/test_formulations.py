"""The formulations against enumeration, closed forms and simulation."""

import json
import random
from dataclasses import replace

import numpy as np
import pytest

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.binary import (
    FormulationWarning,
    half_distance,
    in_model_units,
    schedule_of,
    schedule_of_controls,
    speeds,
)
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.three_phase import three_phase_run
from tgvdp.formulations.qubo.bits import encode_bits
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.hobo import cubic_efficiency
from tgvdp.formulations.qubo.names import BitsForm
from tgvdp.formulations.qubo.parts import joined, register_coefficients
from tgvdp.formulations.qubo.penalties import critical_penalty, sufficient_penalty
from tgvdp.formulations.qubo.qubo import bits_of
from tgvdp.formulations.qubo.unary import encode_unary
from tgvdp.solvers.exact.brute_force import best_plans


def instance(**changes):
    base = dict(
        id="t", model="constant", steps=6, dt_s=10.0, dv_mps=0.5, acc_units=1, dec_units=1, cap_units=(3,) * 6,
        distance_units=5.0,
    )  # fmt: skip
    base |= changes
    if "steps" in changes and "cap_units" not in changes:
        base["cap_units"] = (3,) * changes["steps"]
    return BinaryInstance(**base)


def random_instance(draw, most_steps=5, most_speed=3):
    steps, a = draw.randint(2, most_steps), draw.choice((1, 1, 2))
    b = draw.choice((a, a, 1))
    caps = (
        [draw.randint(0, most_speed)] * steps if draw.random() < 0.5 else draw.choices(range(most_speed + 1), k=steps)
    )
    return instance(
        model=draw.choice(("constant", "kinetic", "efficiency")), steps=steps, acc_units=a, dec_units=b, dv_mps=0.7,
        cap_units=tuple(caps), distance_units=float(draw.randint(1, 6)), tol_units=draw.choice((0.0, 0.0, 1.0)),
        alpha=draw.choice((0.0, 0.3, 1.0)), eta0=0.9, deta=0.05,
    )  # fmt: skip


def optimum(one):
    try:
        return in_model_units(one, best_plans(one)[1])
    except InfeasibleError:
        return None


def all_bits(encoded):
    return bits_of(np.arange(2**encoded.qubo.n), encoded.qubo.n)


def test_three_phases_are_as_documented():
    run = three_phase_run(10_000.0, 400.0, acceleration_mps2=0.5, deceleration_mps2=0.8)
    assert round(run.cruising_speed_mps, 2) == 28.24
    assert (round(run.end_of_traction_s, 2), round(run.start_of_braking_s, 2)) == (56.48, 364.70)
    assert run.speed_mps([30.0, 200.0, 390.0]).round(2).tolist() == [15.0, 28.24, 8.0]
    assert round(run.energy_j(mass_kg=300e3, efficiency=0.85) / 3.6e6, 2) == 39.09


def test_three_phase_covers_the_distance_in_the_time():
    run = three_phase_run(100e3, 1800.0, 0.3, 0.5)
    time_s = np.linspace(0.0, 1800.0, 400_001)
    assert run.distance_m == pytest.approx(100e3, rel=1e-12)
    assert np.trapezoid(run.speed_mps(time_s), time_s) == pytest.approx(100e3, rel=1e-8)
    c = 0.5 * (1 / 0.3 + 1 / 0.5)
    assert run.cruising_speed_mps == pytest.approx((1800.0 - (1800.0**2 - 4 * c * 100e3) ** 0.5) / (2 * c), rel=1e-12)
    assert run.end_of_traction_s < run.start_of_braking_s
    assert run.energy_j(1000.0, 0.5) == pytest.approx(2.0 * 500.0 * run.cruising_speed_mps**2)


def test_three_phase_without_time_or_speed_is_infeasible():
    with pytest.raises(InfeasibleError, match="at least"):
        three_phase_run(100e3, 500.0, 0.3, 0.5)
    with pytest.raises(InfeasibleError, match="largest speed"):
        three_phase_run(100e3, 1800.0, 0.3, 0.5, max_speed_mps=60.0)


@pytest.mark.parametrize("rule", ["left", "trapezoid", "right"])
def test_distance_formula_equals_simulation_of_every_string(rule):
    one = instance(steps=5, acc_units=2, dec_units=3)
    bits = bits_of(np.arange(1 << 10), 10)
    x, y = bits[:, :5], bits[:, 5:]
    v = speeds(one, x, y)
    moved = {"left": 2 * v[:, :-1], "right": 2 * v[:, 1:], "trapezoid": v[:, :-1] + v[:, 1:]}[rule]
    assert np.array_equal(half_distance(one, x, y, rule), moved.sum(axis=1))


def test_a_register_holds_every_value_and_no_other():
    for largest in range(40):
        c = np.array(register_coefficients(largest), dtype=np.int64)
        values = bits_of(np.arange(1 << c.size), c.size) @ c
        assert set(values.tolist()) == set(range(largest + 1))


def test_encodings_agree_with_enumeration_on_random_instances():
    draw, checked = random.Random(7), 0
    for _ in range(60):
        one = random_instance(draw)
        best = optimum(one)
        candidates = [encode_bits(one, 1000.0, BitsForm(limits="slack"))]
        if one.acc_units == one.dec_units:
            candidates.append(encode_unary(one, 1000.0))
        for encoded in (each for each in candidates if each.qubo.n <= 16):
            bits = all_bits(encoded)
            energy, broken = encoded.qubo.energy(bits), encoded.violation.energy(bits)
            whole = broken < 1e-9
            assert np.all(whole | (broken > 1.0 - 1e-9))
            for index in np.flatnonzero(whole)[:50]:
                schedule = encoded.decode(bits[index])
                assert schedule.feasible
                assert schedule.objective == pytest.approx(energy[index], abs=1e-9)
                assert replay(one, schedule)["feasible"]
                assert replay(one, schedule)["objective"] == pytest.approx(schedule.objective, abs=1e-9)
            assert (best is None) == (not whole.any())
            if best is not None:
                assert energy.min() == pytest.approx(best, abs=1e-9)
                checked += 1
    assert checked > 25


def test_mccormick_form_has_the_same_minimum():
    one = instance(steps=4, distance_units=3.0)
    plain, with_z = encode_bits(one, 50.0), encode_bits(one, 50.0, BitsForm(mccormick=True))
    assert with_z.qubo.n == plain.qubo.n + 4
    assert with_z.qubo.all_energies().min() == plain.qubo.all_energies().min()


def test_limits_on_the_total_count_accelerations():
    one = instance(steps=5, distance_units=3.0, cap_units=(1,) * 5)
    minimum = {
        limits: encode_bits(one, 50.0, BitsForm(limits=limits)).qubo.all_energies().min()
        for limits in ("total", "total-equality", "slack")
    }
    assert minimum["total"] == minimum["total-equality"] == minimum["slack"] == pytest.approx(0.25)
    twice = instance(steps=4, distance_units=2.0, cap_units=(1, 0, 1, 0))
    assert encode_bits(twice, 50.0, BitsForm(limits="slack")).qubo.all_energies().min() == pytest.approx(0.5)
    assert encode_bits(twice, 50.0, BitsForm(limits="total")).violation.all_energies().min() >= 1.0


def test_cubic_efficiency_survives_its_reduction():
    one = instance(steps=3, model="efficiency", eta0=0.9, deta=0.07, distance_units=2.0)
    encoded = encode_bits(one, 1.0, BitsForm(cubic=True))
    least = encoded.objective.all_energies().reshape(-1, 1 << 6).min(axis=0)  # over the auxiliary bits
    polynomial = cubic_efficiency(one, [0, 1, 2], [3, 4, 5])
    bits = bits_of(np.arange(1 << 6), 6)
    for index, string in enumerate(bits):
        worth = sum(float(weight) for key, weight in polynomial.items() if all(string[bit] for bit in key))
        assert least[index] == pytest.approx(worth, abs=1e-12)
        if not (string[:3] & string[3:]).any():
            v = 0.5 * speeds(one, string[:3], string[3:])
            drawn = sum(0.5 * string[i] * (v[i] + 0.25) * (0.9 - 0.07 * v[i + 1] / 0.5) for i in range(3))
            assert worth == pytest.approx(drawn, abs=1e-12)


@pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")
def test_penalties_above_the_bound_keep_the_optimum_and_below_the_critical_one_lose_it():
    draw, lost = random.Random(3), 0
    for _ in range(40):
        one = random_instance(draw, most_steps=4, most_speed=2)
        best = optimum(one)
        encoding = "unary" if one.acc_units == one.dec_units else "bits+slack"
        if best is None:
            continue
        encoded = encode(one, encoding)
        if encoded.qubo.n > 16:
            continue
        critical = critical_penalty(encoded.objective, encoded.violation)
        assert critical < sufficient_penalty(one, encoding)
        assert encoded.qubo.all_energies().min() == pytest.approx(best, abs=1e-9)
        above = joined(encoded.objective, encoded.violation, 1.01 * critical + 1e-9).all_energies()
        assert above.min() == pytest.approx(best, abs=1e-9)
        if critical > 1e-9:
            assert joined(encoded.objective, encoded.violation, 0.9 * critical).all_energies().min() < best - 1e-12
            lost += 1
    assert lost >= 3


def test_the_rule_of_thumb_at_a_small_step_picks_a_wrong_minimum_and_warns():
    one = instance(steps=4, distance_units=4.0, dv_mps=0.1, cap_units=(2,) * 4)
    with pytest.warns(FormulationWarning, match="too small"):
        encoded = encode(one, "bits", "tenfold")
    string = bits_of(int(np.argmin(encoded.qubo.all_energies())), encoded.qubo.n)
    assert not encoded.decode(string).feasible
    right = encode(one, "bits")
    assert right.decode(bits_of(int(np.argmin(right.qubo.all_energies())), right.qubo.n)).feasible


def test_a_multiplier_in_place_of_the_square_gives_a_lower_bound():
    one = instance(steps=6, model="kinetic", distance_units=7.0)
    best = optimum(one)
    bounds = [encode_unary(one, 50.0, multiplier=mu).qubo.all_energies().min() for mu in (0.0, -0.1, -0.2, -0.3)]
    assert max(bounds) <= best + 1e-9
    assert max(bounds) > 0.0


def test_an_infeasible_string_says_what_it_breaks():
    one = instance()
    broken = {check.name: check.violation for check in schedule_of(one, [1, 1, 1, 1, 0, 0], [0, 0, 0, 1, 0, 0]).checks}
    assert broken["one action per step"] == 1.0
    assert broken["stop at the end"] == 3.0
    assert broken["speed limit"] == 0.0
    under = schedule_of_controls(one, [-1, 0, 0, 0, 0, 1])
    assert {check.name: check.violation for check in under.checks}["speed not negative"] == 1.0
    assert not replay(one, under)["feasible"]


def test_constant_model_that_earns_by_braking_warns():
    with pytest.warns(FormulationWarning, match="kinetic"):
        encode(instance(acc_units=1, dec_units=3, alpha=0.9), "bits")


GOOD = {
    "id": "a",
    "params": {
        "kind": "binary", "model": "constant", "N": 8, "dt_s": 10, "dv_mps": 0.5, "acc_units": 1, "dec_units": 1,
        "cap_units": 3, "D_units": 12,
    },
}  # fmt: skip
DEMAND = {
    "id": "d",
    "params": {
        "kind": "demand", "N": 8, "dt_s": 15, "notches": 2, "mass_kg": 300000, "rot": 1.08,
        "davis_SI": [1770, 35.4, 6.6], "vmax_kmh": 160, "D_m": 1500, "tol_m": 30, "v_end_max_mps": 1.5,
        "P_max_W": 9.8e6, "cost_ref_kmh": 220,
    },
}  # fmt: skip


def test_instances_are_read(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(GOOD))
    one = read_instance(path)
    assert isinstance(one, BinaryInstance)
    assert (one.alpha, one.tol_units, one.cap_units) == (0.0, 0.0, (3,) * 8)
    path.write_text(json.dumps(DEMAND))
    other = read_instance(path)
    assert isinstance(other, DemandInstance)
    assert other.levels == (-1.0, -0.5, 0.0, 0.5, 1.0)
    assert other.alpha == 0.0


@pytest.mark.parametrize("good", [GOOD, DEMAND])
def test_any_broken_instance_is_one_line_that_names_the_file(tmp_path, good):
    path = tmp_path / "broken.json"
    texts = [
        json.dumps(good).replace(": 8", f": {value}") for value in ("NaN", "1e999", "-1", "true", '"8"', "null", "[]")
    ]
    texts += ["", "[]", "[" * 100_000, '{"id": "a", "id": "b"}', "\x00", '{"id": ["a"], "params": 3}']
    for field in good["params"]:
        for value in ([], {}, "x", None, -1e300, [[]]):
            texts.append(json.dumps(good | {"params": good["params"] | {field: value}}))
        if field != "kind":
            texts.append(json.dumps(good | {"params": {k: v for k, v in good["params"].items() if k != field}}))
    texts += [json.dumps(good | {"more": 1}), json.dumps(good | {"params": good["params"] | {"more": 1}})]
    accepted = 0
    for text in texts:
        path.write_text(text)
        try:
            read_instance(path)
            accepted += 1  # a continuous demand (notches null) is right
        except InputError as error:
            assert str(error).startswith(str(path)), text[:200]
            assert "\n" not in str(error)
    assert accepted <= 1


@pytest.mark.parametrize(("encoding", "steps"), [("unary", 200), ("bits", 5000), ("bits+slack", 5000)])
def test_a_qubo_that_would_not_fit_the_memory_is_refused(encoding, steps):
    one = replace(instance(), steps=steps, cap_units=(steps,) * steps)
    with pytest.raises(InputError, match="bits with each other"):
        encode(one, encoding)


def test_demand_beyond_the_curves_is_refused(tmp_path):
    path = tmp_path / "fast.json"
    path.write_text(json.dumps(DEMAND | {"params": DEMAND["params"] | {"vmax_kmh": 220}}))
    assert read_instance(path).vmax_mps == pytest.approx(220 / 3.6)
    path.write_text(json.dumps(DEMAND | {"params": DEMAND["params"] | {"vmax_kmh": 220.5}}))
    with pytest.raises(InputError, match=r"vmax_kmh: the force curves end at 220 km/h, got 220.5 km/h"):
        read_instance(path)


def test_penalty_of_the_instance_is_the_default():
    assert encode(replace(instance(), lambda_uniform=77.0), "bits").penalty == 77.0
