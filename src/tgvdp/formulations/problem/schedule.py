"""What every solver hands over: a schedule, decoded and checked, and a solution, replayed on the true physics."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Check:
    """One constraint and by how much a schedule violates it.

    Attributes
    ----------
    name : str
    violation : float
        0 where the constraint holds, in ``unit``.
    unit : str
    """

    name: str
    violation: float
    unit: str

    @property
    def satisfied(self) -> bool:
        """Whether the constraint holds."""
        return self.violation == 0.0


@dataclass(frozen=True)
class Schedule:
    """A decoded solution in the model's own terms.

    Attributes
    ----------
    speeds : tuple of float
        v_0..v_N, whole multiples of Δv for the binary model (units of Δv), m/s for the demand model.
    controls : tuple of float
        The N controls: change of speed u_i in Δv for the binary model, demand d_i for the demand model.
    distance : float
        In Δv·Δt (binary, trapezoid) or m (demand).
    objective : float
        In the unit that the instance's ``objective_unit`` names. Of the constant and the efficiency model it is no
        energy: what a schedule takes, its replay says.
    checks : tuple of Check
        Every constraint, satisfied or not.
    """

    speeds: tuple[float, ...]
    controls: tuple[float, ...]
    distance: float
    objective: float
    checks: tuple[Check, ...]

    @property
    def feasible(self) -> bool:
        """Whether all constraints hold."""
        return all(check.satisfied for check in self.checks)


@dataclass(frozen=True)
class Solution:
    """What a solver found.

    Attributes
    ----------
    solver : str
    schedule : Schedule
    optimal : bool
        Whether optimality is proved. A heuristic that happens to be right says False.
    n_optimal : int or None
        Exact number of optimal schedules; None where the solver does not count.
    replay : mapping
        As the replay on the true physics reports it (`tgvdp.formulations.problem.replay`).
    elapsed_s : float
        Duration of the solver alone, s.
    qubo : mapping or None
        ``variables``, ``couplers``, ``coefficient_range`` and ``minimum`` (lowest energy found) where a QUBO was used.
    details : mapping
        What else a solver wants to tell: bound, runs, sweeps, labels of what was proved.
    """

    solver: str
    schedule: Schedule
    optimal: bool
    n_optimal: int | None
    replay: Mapping[str, Any]
    elapsed_s: float
    qubo: Mapping[str, Any] | None = None
    details: Mapping[str, Any] = field(default_factory=dict)

    @property
    def objective(self) -> float:
        """Objective of the schedule, in the model's own unit."""
        return self.schedule.objective

    @property
    def feasible(self) -> bool:
        """Whether the schedule satisfies all constraints of the instance."""
        return self.schedule.feasible
