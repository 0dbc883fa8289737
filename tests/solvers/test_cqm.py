"""Constrained quadratic models: enumerated, sampled by a stand-in for the hybrid service, and of the demand model."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance, random_instance
from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.demand import drive
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.program.approximations import split_fits
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve

dimod = pytest.importorskip("dimod")

from tgvdp.solvers.programs.cqm import SPEED_STEP_MPS, cqm_of, hybrid_solution  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

DEMAND = DemandInstance(
    id="d", steps=5, dt_s=15.0, levels=(-1.0, -0.5, 0.0, 0.5, 1.0), mass_kg=3e5, rotating_factor=1.08,
    davis=(1770.0, 35.4, 6.6), vmax_mps=160 / 3.6, distance_m=600.0, tol_m=60.0, end_speed_max_mps=1.5, p_max_w=9.8e6,
    cost_ref_mps=220 / 3.6, alpha=0.3,
)  # fmt: skip


def outcome(instance, solver):
    """Objective and number of optima; None where it is proved that nothing is feasible."""
    try:
        solution = solve(instance, solver)
    except InfeasibleError:
        return None
    assert solution.optimal and solution.feasible and solution.replay["feasible"]
    return solution.objective, solution.n_optimal


@pytest.mark.parametrize("seed", range(4))
def test_enumerated_cqm_equals_the_dynamic_program(seed):
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(15):
        instance = random_instance(rng, most_steps=6)
        expected = outcome(instance, "dp")
        assert outcome(instance, "cqm") == expected, instance
        found += expected is not None
    assert 2 <= found <= 14


def test_long_instances_are_not_enumerated():
    with pytest.raises(InputError, match="18 bits are too many"):
        solve(binary_instance(9), "cqm")


def test_a_fractional_distance_is_infeasible():
    with pytest.raises(InfeasibleError, match="no whole distance"):
        cqm_of(binary_instance(4, distance_units=2.5))


class Service:
    """Stands in for the hybrid service: dimod's enumeration, or given samples."""

    def __init__(self, samples=None):
        self.samples = samples
        self.limits = []

    def sample_cqm(self, cqm, **limit):
        self.limits.append(limit)
        if self.samples is None:
            return dimod.ExactCQMSolver().sample_cqm(cqm).truncate(200)
        blank = dict.fromkeys(cqm.variables, 0)
        sampleset = dimod.SampleSet.from_samples_cqm([blank | sample for sample in self.samples], cqm)
        sampleset.info["qpu_access_time"] = 32_000
        return sampleset


def test_the_hybrid_service_returns_the_best_feasible_sample():
    instance, service = binary_instance(5, distance_units=4.0), Service()
    found = hybrid_solution(service, instance, Allowance(time_limit_s=7.0))
    assert service.limits == [{"time_limit": 7.0}]
    assert found.solver == "leap"
    assert not found.optimal
    assert found.feasible and found.replay["feasible"]
    assert found.details["reads"] == 200
    assert found.details["qpu_s"] is None
    assert 0 < found.details["best_reads"] <= found.details["feasible_reads"] < 200
    everything = dimod.ExactCQMSolver().sample_cqm(cqm_of(instance).cqm)
    assert found.details["variables"] == len(everything.variables) == 10


def test_demands_of_the_service_are_driven_on_the_true_curves():
    reachable = replace(DEMAND, distance_m=float(drive(DEMAND, (1.0, 0.0, 0.0, -1.0, -1.0)).distance_m))
    pulls, holds = {"p_0": 2, "q_3": 2, "q_4": 2}, {}
    found = hybrid_solution(Service([holds, pulls]), reachable, Allowance())
    assert found.schedule.controls == (1.0, 0.0, 0.0, -1.0, -1.0)
    assert found.objective == found.replay["objective"] > 0.0
    assert found.details["reads"] == 2
    assert found.details["qpu_s"] == pytest.approx(0.032)


def test_a_service_that_refuses_or_returns_nothing_is_one_line():
    class Refuses:
        def sample_cqm(self, cqm):
            raise ValueError("too many constraints")

    with pytest.raises(InputError, match="refuses the problem: too many constraints"):
        hybrid_solution(Refuses(), binary_instance(4), Allowance())
    with pytest.raises(InputError, match="returned no sample"):
        hybrid_solution(Service([]), binary_instance(4), Allowance())


def test_without_an_account_one_line_says_so(monkeypatch, tmp_path):
    pytest.importorskip("dwave.system")
    for name in ("DWAVE_API_TOKEN", "DWAVE_CONFIG_FILE", "DWAVE_PROFILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(InputError, match="dwave config create"):
        solve(binary_instance(4), "leap")


def test_the_cqm_of_demand_holds_its_own_motion_to_the_step_of_speed():
    """Drive demands by the fitted forces, speeds rounded to the CQM's step: motion holds, cost is the fitted one."""
    written = cqm_of(DEMAND)
    sample = dict.fromkeys(written.cqm.variables, 0.0)
    (a0, a1), (b0, b1), (c1, c2) = (fit.coefficients for fit in split_fits(DEMAND))
    a, b, c = DEMAND.davis
    v, cost = 0.0, 0.0
    for i, d in enumerate((1.0, 0.5, 0.0, -0.5, -1.0)):
        p, q = max(d, 0.0), max(-d, 0.0)
        force = p * (a0 + a1 * v) - q * (b0 + b1 * v) - a - b * v - c * v * v
        free = v + DEMAND.dt_s * force / (1.08 * 3e5)
        after = max(0.0, round(free / SPEED_STEP_MPS) * SPEED_STEP_MPS)
        cost += DEMAND.dt_s * (p - 0.3 * q) * (c1 * 0.5 * (v + after) + c2)
        sample |= {
            f"p_{i}": 2 * p, f"q_{i}": 2 * q, f"delta_{i}": float(d > 0.0), f"held_{i}": max(0.0, -free),
            f"stands_{i}": float(after == 0.0), f"v_{i + 1}": round(after / SPEED_STEP_MPS),
        }  # fmt: skip
        v = after
    broken = {label: size for label, size in written.cqm.violations(sample).items() if size > 1e-6}
    assert set(broken) <= {"distance_least", "distance_most", "end"}
    assert written.cqm.objective.energy(sample) == pytest.approx(cost, rel=1e-9)
    shifted = sample | {"v_2": sample["v_2"] + 2}
    assert max(written.cqm.violations(shifted).values()) > 0.5 * SPEED_STEP_MPS
    assert written.schedule(np.array([sample[name] for name in written.names])).controls[0] == 1.0
