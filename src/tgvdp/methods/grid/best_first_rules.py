"""What a best-first search is asked for, and the rules that its kernel follows; see `best_first`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import HEURISTICS
from tgvdp.errors import InputError
from tgvdp.methods.grid.best_first_kernel import BUCKETS, Rules
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.paths import too_slow
from tgvdp.methods.grid.to_go import ROUNDING, fastest_path, least_to_go
from tgvdp.model.checks import require_number


@dataclass(frozen=True, kw_only=True)
class Options:
    """Frozen options of the best-first search, checked when they are made.

    Parameters
    ----------
    heuristic : {"ratio", "time", "energy", "weighted"}
        Priority of a label.
    paths : int or None
        Stop after this many different paths; None or 0: all.
    dominance, bounds : bool
        Pruning rules.
    weight : float, optional
        λ of ``weighted``, the price of time, J/s; default: energy range over time range of the problem.
    reference_time_s, reference_energy_j : float, optional
        Reference run of ``ratio``, s and J; default: the fastest path of the graph.

    Raises
    ------
    InputError
        When an option is unknown, out of range, or without effect on the heuristic.
    """

    heuristic: str = "ratio"
    paths: int | None = None
    dominance: bool = True
    bounds: bool = True
    weight: float | None = None
    reference_time_s: float | None = None
    reference_energy_j: float | None = None

    def __post_init__(self) -> None:
        if self.heuristic not in HEURISTICS:
            raise InputError(f"best-first: heuristic must be one of {', '.join(HEURISTICS)}, got {self.heuristic!r}")
        paths = 0 if self.paths is None else self.paths
        if isinstance(paths, bool) or not isinstance(paths, int) or paths < 0:
            raise InputError(f"best-first: paths must be a whole number, at least 0, got {self.paths!r}")
        if self.weight is not None:
            require_number("best-first", "weight", self.weight, "J/s", at_least=0.0)
            if self.heuristic != "weighted":
                raise InputError(f"best-first: weight belongs to heuristic 'weighted', got {self.heuristic!r}")
        for name, unit in (("reference_time_s", "s"), ("reference_energy_j", "J")):
            value = getattr(self, name)
            if value is not None:
                require_number("best-first", name, value, unit, at_least=0.0)


def rules_of(graph: LayeredGraph, blocked: NDArray[np.int32], max_time_s: float, options: Options) -> Rules:
    """Work out bounds, reference and ranges."""
    time_s = least_to_go(graph, 1.0, 0.0)
    energy_j = least_to_go(graph, 0.0, 1.0)
    if not np.isfinite(time_s[0]) or time_s[0] * (1.0 - ROUNDING) > max_time_s:
        raise too_slow(float(time_s[0]), max_time_s)
    fastest_s, fastest_j = fastest_path(graph, time_s)
    range_s = max(0.0, max_time_s - float(fastest_s[-1]))
    range_j = max(0.0, float(fastest_j[-1] - energy_j[0]))
    none = np.zeros(graph.n_nodes)
    to_go_s, to_go_j = (time_s, energy_j) if options.bounds else (none, none)
    time_weight, energy_weight = 1.0, 1.0
    base_s, base_j = none, none
    if options.heuristic == "ratio":
        end_s = float(fastest_s[-1]) if options.reference_time_s is None else options.reference_time_s
        end_j = float(fastest_j[-1]) if options.reference_energy_j is None else options.reference_energy_j
        if options.bounds:
            base_s, base_j = end_s - time_s, end_j - energy_j
        else:
            base_s = _ending_at(fastest_s, end_s)[graph.layer]
            base_j = _ending_at(fastest_j, end_j)[graph.layer]
    else:
        if options.heuristic == "energy":
            time_weight = 0.0
        elif options.weight is not None:
            time_weight = options.weight
        elif options.heuristic == "weighted" and range_s > 0.0:
            time_weight = range_j / range_s
        energy_weight = 0.0 if options.heuristic == "time" else 1.0
        if options.bounds:
            base_s = least_to_go(graph, time_weight, energy_weight)
    most = options.paths or 0
    share = 0.5 / max(1, most)
    return Rules(
        options.heuristic == "ratio", time_weight, energy_weight, base_s, base_j, to_go_s, to_go_j, options.bounds,
        options.dominance, max_time_s, most, share * range_s, share * range_j, blocked,
        time_s, BUCKETS / range_s if range_s > 0.0 else 0.0,
    )  # fmt: skip


def _ending_at(course: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Stretch a course from 0 so that it ends at a value."""
    return course * (end / course[-1]) if course[-1] > 0.0 else course


def counted_j(grid: Grid, energy_j: float) -> float:
    """Energy of a real run as a grid counts it: above its least ones, which only its coarseness can lift over a run."""
    return max(energy_j - float(grid.floor_j.sum()), 0.0)
