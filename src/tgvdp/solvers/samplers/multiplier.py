"""The unary encoding without its square: annealing at one Lagrange multiplier after the other, and a repair.

The square of the distance couples all bits. A term μ·Σt in its place leaves a strip of few couplers, but its minimum
has the right distance only where D is a corner of the lower convex hull of the least objective over the distance:
between two corners no μ makes the optimum the minimum (a duality gap), and at the μ of the hull's edge plans of the
distances at both ends of it have the least energy. So an outer loop bisects μ until the distances of what comes out lie
on both sides of D, and a repair moves single levels, each time the one that costs least, until the distance is right.

How far the repair alone comes, from a standing train, is told beside: what it solves, the annealer did not.
"""

import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.binary import features_of_speeds, in_model_units, schedule_of_speeds
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.qubo.unary import encode_unary
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra
from tgvdp.solvers.greedy import (
    repaired,
    require_distance,
    require_unit_steps,
    solve_greedy,
    unit_distances,
    unit_limits,
)
from tgvdp.solvers.samplers.bqm import bqm_of
from tgvdp.solvers.samplers.sampling import qubo_report, samples_of

Ints = NDArray[np.int64]

#: Bisections of the multiplier.
ROUNDS = 12
#: Weight of the order of the registers, over the largest change of the objective and of μ by one bit.
_ORDER = 2.0


class _Tried(NamedTuple):
    """What an attempt came to: objective of its best feasible schedule, before and after repairs; infinite if none."""

    raw: NDArray[np.float64]
    repaired: NDArray[np.float64]


def solve_multiplier(instance: BinaryInstance, allowance: Allowance) -> Solution:
    """Anneal the unary form with a multiplier; uses ``reads``, ``sweeps``, ``beta`` and ``seed``.

    An attempt is `ROUNDS` reads, one at each multiplier; which way μ moves, the median of all attempts tells.

    Raises
    ------
    InputError
        When the steps are not equal.
    InfeasibleError
        When no distance lies within the tolerance.
    """
    require_unit_steps(instance, "multiplier")
    require_distance(instance)
    sampler = extra("dwave.samplers", "solver multiplier").SimulatedAnnealingSampler()
    start = time.perf_counter()
    limits = unit_limits(instance)
    scale = _largest_change(instance, limits)
    low, high = -2.0 * scale, 2.0 * scale  # of μ: so rewarded, or charged, no bit stays where it was
    tried = _Tried(*(np.full(allowance.reads, np.inf) for _ in range(2)))
    best: Schedule | None = None
    target = unit_distances(instance)
    multiplier, qubo = 0.0, None
    for round_ in range(ROUNDS):
        multiplier = 0.5 * (low + high)
        encoded = encode_unary(instance, _ORDER * (scale + abs(multiplier)), multiplier=multiplier)
        qubo = encoded.qubo
        sampled = sampler.sample(
            bqm_of(qubo), num_reads=allowance.reads, num_sweeps=allowance.sweeps, beta_range=allowance.beta,
            seed=allowance.seed + round_,
        ) if qubo.n else None  # fmt: skip
        distances = []
        bits = samples_of(sampled, qubo).bits
        for attempt in range(allowance.reads):
            heights = _heights(encoded.decode(bits[min(attempt, len(bits) - 1)]), instance)
            distances.append(int(heights.sum()))
            best = _keep(instance, heights, tried.raw, attempt, best)
            best = _keep(instance, repaired(instance, _allowed(heights, limits), limits), tried.repaired, attempt, best)
        middle = float(np.median(distances))
        low, high = (
            (low, multiplier) if middle < target[0] else (multiplier, high) if middle > target[1] else (low, high)
        )
    elapsed_s = time.perf_counter() - start
    return _solution(instance, allowance, tried, best, qubo, multiplier, elapsed_s)


def _solution(
    instance: BinaryInstance,
    allowance: Allowance,
    tried: _Tried,
    best: Schedule | None,
    qubo: Any,
    multiplier: float,
    elapsed_s: float,
) -> Solution:
    lowest = float(tried.repaired.min())
    alone = solve_greedy(instance, allowance)
    shown = best or schedule_of_speeds(instance, np.zeros(instance.steps + 1, dtype=np.int64))
    return Solution(
        solver="multiplier",
        schedule=shown,
        optimal=False,
        n_optimal=None,
        replay=replay(instance, shown),
        elapsed_s=elapsed_s,
        qubo=qubo_report(qubo, None),
        details={
            "reads": allowance.reads,
            "feasible_reads": int(np.isfinite(tried.repaired).sum()),
            "best_reads": int((tried.repaired == lowest).sum()) if np.isfinite(lowest) else 0,
            "best_reads_unrepaired": int((tried.raw == lowest).sum()) if np.isfinite(lowest) else 0,
            "repair_alone": alone.objective if alone.feasible else None,
            "sweeps": allowance.sweeps * ROUNDS,
            "beta": allowance.beta and str(allowance.beta),
            "multiplier": multiplier,
            "seed": allowance.seed,
        },
    )


def _largest_change(instance: BinaryInstance, limits: Ints) -> float:
    """Largest change of the objective by one bit: of the highest level, in the middle of a plan."""
    top = int(limits.max(initial=1))
    bits = [
        features_of_speeds(instance, instance.acc_units * np.array(v)).exact() for v in ((0, top, 0), (0, top - 1, 0))
    ]
    return abs(in_model_units(instance, bits[0] - bits[1])) or 1.0


def _heights(schedule: Schedule, instance: BinaryInstance) -> Ints:
    return np.array(schedule.speeds, dtype=np.int64) // instance.acc_units


def _allowed(heights: Ints, limits: Ints) -> Ints:
    """The highest plan of unit steps below some heights."""
    v = np.minimum(heights, limits)
    for k in range(1, v.size):
        v[k] = min(v[k], v[k - 1] + 1)
    for k in range(v.size - 2, -1, -1):
        v[k] = min(v[k], v[k + 1] + 1)
    return v


def _keep(
    instance: BinaryInstance, heights: Ints, objectives: NDArray[np.float64], attempt: int, best: Schedule | None
) -> Schedule | None:
    """Note a plan if it is feasible and the best of its attempt; returns the best of all."""
    low, high = unit_distances(instance)
    if not low <= int(heights.sum()) <= high:
        return best
    schedule = schedule_of_speeds(instance, instance.acc_units * heights)
    if not schedule.feasible:
        return best
    objectives[attempt] = min(objectives[attempt], schedule.objective)
    return schedule if best is None or schedule.objective < best.objective else best
