"""From samples of a QUBO to one solution: decode all, keep the best, replay it, and say how often it came."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.qubo import Qubo

#: Two energies count as equal when they differ by less than this part of the largest coefficient.
_SAME_ENERGY = 1e-9
_TINY = float(np.finfo(np.float64).tiny)


class Samples(NamedTuple):
    """Bit strings that a sampler returned.

    Attributes
    ----------
    bits : (k, n) int8
    counts : (k,) int64
        How often each was drawn.
    """

    bits: NDArray[np.int8]
    counts: NDArray[np.int64]

    @property
    def total(self) -> int:
        """Number of reads."""
        return int(self.counts.sum())


class Best(NamedTuple):
    """The best of some samples, and how the others did.

    Attributes
    ----------
    schedule : Schedule
        Feasible and of the lowest objective, or, where no sample is feasible, that of the lowest energy.
    lowest_energy : float
        Of all samples, feasible or not.
    reads, feasible_reads, best_reads : int
        All reads, those that decode to a feasible schedule, and those among them that reach its objective.
    different : int
        Different schedules of the last: slack bits write one by several strings.
    """

    schedule: Schedule
    lowest_energy: float
    reads: int
    feasible_reads: int
    best_reads: int
    different: int


def samples_of(sampleset: Any, qubo: Qubo) -> Samples:
    """Bits of a ``dimod.SampleSet`` in the order of the QUBO's labels.

    Of a QUBO without bits there is one string, the empty one, which samplers do not return.
    """
    if not qubo.n:
        return Samples(np.zeros((1, 0), dtype=np.int8), np.ones(1, dtype=np.int64))
    column = {label: i for i, label in enumerate(sampleset.variables)}
    order = [column[label] for label in qubo.labels]
    record = sampleset.record
    return Samples(record.sample[:, order].astype(np.int8), record.num_occurrences.astype(np.int64))


def best_of(encoded: Encoded, samples: Samples) -> Best:
    """Decode every different sample once; ties go to the one that came first."""
    bits, first, inverse = np.unique(samples.bits, axis=0, return_index=True, return_inverse=True)
    counts = np.bincount(inverse.reshape(-1), samples.counts, minlength=len(bits)).astype(np.int64)
    order = np.argsort(first)
    bits, counts = bits[order], counts[order]
    energies = encoded.qubo.energy(bits)
    schedules = [encoded.decode(string) for string in bits]
    feasible = [i for i, schedule in enumerate(schedules) if schedule.feasible]
    lowest = int(np.argmin(energies))
    best = min(feasible, key=lambda i: schedules[i].objective, default=lowest)
    equal = [i for i in feasible if schedules[i].objective == schedules[best].objective]
    return Best(
        schedules[best],
        float(energies[lowest]),
        samples.total,
        int(counts[feasible].sum()),
        int(counts[equal].sum()),
        len({schedules[i].controls for i in equal}),
    )


def qubo_report(qubo: Qubo, minimum: float | None) -> dict[str, Any]:
    """What `Solution.qubo` holds."""
    stats = qubo.stats
    return {
        "variables": stats.variables,
        "couplers": stats.couplers,
        "coefficient_range": list(stats.coefficient_range),
        "minimum": minimum,
    }


def sampled_solution(
    solver: str, encoded: Encoded, samples: Samples, elapsed_s: float, details: Mapping[str, Any]
) -> Solution:
    """Solution of a heuristic: nothing is proved."""
    best = best_of(encoded, samples)
    return Solution(
        solver=solver,
        schedule=best.schedule,
        optimal=False,
        n_optimal=None,
        replay=replay(encoded.instance, best.schedule),
        elapsed_s=elapsed_s,
        qubo=qubo_report(encoded.qubo, best.lowest_energy),
        details={
            **_common(encoded),
            "reads": best.reads,
            "feasible_reads": best.feasible_reads,
            "best_reads": best.best_reads,
            **details,
        },
    )


def ground_state_solution(
    solver: str,
    encoded: Encoded,
    ground_states: NDArray[np.int8],
    elapsed_s: float,
    details: Mapping[str, Any],
    *,
    counted: bool,
) -> Solution:
    """Solution of a solver that proves the QUBO's minimum.

    In a complete encoding every feasible schedule has a string whose energy is its objective. So a ground state whose
    energy is the objective of a feasible schedule is an optimum of the constrained problem, whatever the penalty; any
    other proves only that the penalty is too small, or that nothing is feasible. All ground states together hold every
    optimal schedule, and may hold strings besides that break what the encoding leaves out.

    Parameters
    ----------
    ground_states : (k, n) int8
        Strings of the lowest energy; all of them where ``counted``.
    """
    best = best_of(encoded, Samples(ground_states, np.ones(len(ground_states), dtype=np.int64)))
    largest = encoded.qubo.stats.coefficient_range[1]
    reached = abs(best.schedule.objective - best.lowest_energy) <= _SAME_ENERGY * max(largest, _TINY)
    proved = encoded.complete and best.schedule.feasible and reached
    return Solution(
        solver=solver,
        schedule=best.schedule,
        optimal=proved,
        n_optimal=best.different if counted and proved else None,
        replay=replay(encoded.instance, best.schedule),
        elapsed_s=elapsed_s,
        qubo=qubo_report(encoded.qubo, best.lowest_energy),
        details={**_common(encoded), "ground_states": len(ground_states) if counted else None, **details},
    )


def lowest(energies: NDArray[np.float64], qubo: Qubo) -> NDArray[np.int64]:
    """Indices of the energies that equal the lowest one, up to rounding."""
    close = energies - energies.min() <= _SAME_ENERGY * max(qubo.stats.coefficient_range[1], _TINY)
    return np.flatnonzero(close).astype(np.int64)


def _common(encoded: Encoded) -> dict[str, Any]:
    weights = {} if min(encoded.weights) == max(encoded.weights) else {"weights": encoded.weights._asdict()}
    return {"encoding": encoded.encoding, "penalty": encoded.penalty, **weights}
