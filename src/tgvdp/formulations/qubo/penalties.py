"""How much a violation must cost: a rule of thumb, a bound that suffices, and the exact critical value.

(Glover, Kochenberger and Du 2019 on penalties in general.) With f the objective and viol the squared violation, a whole
number ≥ 1 of every string that breaks anything, the minimum of f + λ·viol is the constrained optimum f* if and, for
some string, only if λ exceeds

    λ_c = max over strings z with viol(z) > 0 of (f* − f(z)) / viol(z).

That takes an enumeration; λ > f(feasible) − min f suffices, with the least objective over all strings, feasible or not.
The rule of thumb of the binary formulation, and of dimod's ``cqm_to_bqm``, is ten times the largest coefficient of the
objective. With violations in SI it may be far too small: at Δv = 0.1 m/s a missed unit of distance weighs 0.01.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.formulations.problem.instances import BinaryInstance, decimal
from tgvdp.formulations.qubo.names import Encoding
from tgvdp.formulations.qubo.qubo import Qubo

_TENFOLD = 10.0
#: The sufficient weight must exceed its bound.
_ABOVE = 1.05
#: Bits x, y of a step of a plan.
_ACTIONS = ((0, 0), (1, 0), (0, 1))
#: Of a multiplier, over the largest cost of a step.
_MULTIPLIER_DIGITS = 1e-6


def tenfold_penalty(objective: Qubo) -> float:
    """The rule of thumb: 10 · largest |coefficient| of the objective."""
    coefficients = np.concatenate((objective.linear, objective.values))
    return _TENFOLD * float(np.abs(coefficients).max(initial=0.0))


def sufficient_penalty(instance: BinaryInstance, encoding: Encoding, feasible: float | None = None) -> float:
    """A weight in (m/s)² that is large enough, whatever the instance.

    Parameters
    ----------
    instance : BinaryInstance
    encoding : str
    feasible : float, optional
        Objective of a feasible schedule in (m/s)², where one is known: the better it is, the smaller the weight. By
        default the largest objective of any plan from stop to stop within the speed limits.
    """
    square = float(decimal(instance.dv_mps) ** 2)
    least = square * (_least_unary(instance) if encoding == "unary" else _least_bits(instance))
    most = square * _most_from_stop_to_stop(instance) if feasible is None else feasible
    bound = max(0.0, most - least)
    return _ABOVE * bound if bound > 0.0 else square


def spread_penalty(objective: Qubo) -> float:
    """A weight that is large enough for any objective, and far larger than `sufficient_penalty`: Σ|coefficient|."""
    return _ABOVE * float(np.abs(objective.linear).sum() + np.abs(objective.values).sum())


def critical_penalty(objective: Qubo, violation: Qubo) -> float:
    """The exact critical weight λ_c, by enumeration of all bit strings.

    Above it every ground state of objective + λ·violation is an optimum of the constrained problem; below it some
    string that violates a constraint lies lower. Zero where the objective alone finds the optimum.

    Raises
    ------
    InputError
        When there are too many bits to enumerate.
    InfeasibleError
        When every string violates something.
    """
    f, broken = objective.all_energies(), violation.all_energies()
    feasible = broken < 0.5  # violations of 1 and more, and rounding
    if not feasible.any():
        raise InfeasibleError("penalty: every bit string violates a constraint")
    if feasible.all():
        return 0.0
    return max(0.0, float(((f[feasible].min() - f[~feasible]) / broken[~feasible]).max()))


def best_multiplier(instance: BinaryInstance) -> float:
    """Lagrange multiplier μ of the distance of unit steps whose lower bound is the best, in (m/s)² per step of Δv·Δt.

    The bound min over plans of f + μ·(Σv − D), a dynamic program over speeds, is concave in μ, so that thirds of a
    range find its top. With a tolerance D is the end that μ favours less.
    """
    least, most = (distance / instance.acc_units for distance in instance.distance_range)
    top = max(instance.cap_units[:-1], default=0)
    v = np.arange(top + 1, dtype=np.float64)
    largest = max(float(np.abs(_cost(instance, v, x, y)).max()) for x, y in _ACTIONS)

    def bound(multiplier: float) -> float:
        value = _stop_to_stop(instance, 1.0, multiplier / instance.acc_units)
        return value - multiplier * (most if multiplier > 0.0 else least)

    low, high = -2.0 * largest, 2.0 * largest
    while high - low > _MULTIPLIER_DIGITS * largest:
        third = (high - low) / 3.0
        if bound(low + third) < bound(high - third):
            low += third
        else:
            high -= third
    return 0.5 * (low + high) * float(decimal(instance.dv_mps) ** 2)


def _least_unary(instance: BinaryInstance) -> float:
    """Least objective of any unary string, in Δv²: each level is a chain that starts and ends at 0."""
    if instance.model != "efficiency":
        return 0.0  # no chain falls more often than it rises, and α ≤ 1
    unit = instance.acc_units
    per_level = [
        unit * instance.eta0 - unit * unit * instance.deta * (2 * j - 1) for j in range(1, instance.steps // 2 + 1)
    ]
    # Level j stands at most in steps j..N−j.
    return sum(min(0.0, cost) * (instance.steps + 1 - 2 * j) for j, cost in enumerate(per_level, start=1))


def _least_bits(instance: BinaryInstance) -> float:
    """Least objective of any string of bits x, y, in Δv²: all four actions in each step, at any speed."""
    a, b, steps = instance.acc_units, instance.dec_units, instance.steps
    return float(_extreme(instance, -b * steps, a * steps, ((0, 0), (1, 0), (0, 1), (1, 1)))[b * steps])


def _most_from_stop_to_stop(instance: BinaryInstance) -> float:
    """Largest objective of a plan from stop to stop within the speed limits, in Δv²: at any distance."""
    return -_stop_to_stop(instance, -1.0)


def _stop_to_stop(instance: BinaryInstance, sign: float, per_speed: float = 0.0) -> float:
    """Least sign · objective + per_speed · Σv of any plan from stop to stop within the speed limits, in Δv²."""
    top = min(max(instance.cap_units[:-1], default=0), instance.acc_units * instance.steps)
    caps = (*instance.cap_units[:-1], 0)
    return float(_extreme(instance, 0, top, _ACTIONS, caps, sign, per_speed)[0])


def _extreme(
    instance: BinaryInstance,
    bottom: int,
    top: int,
    actions: tuple[tuple[int, int], ...],
    caps: tuple[int, ...] | None = None,
    sign: float = 1.0,
    per_speed: float = 0.0,
) -> NDArray[np.float64]:
    """Least sign · objective + per_speed · Σv to go from each speed bottom..top, by dynamic programming over speeds."""
    v = np.arange(bottom, top + 1, dtype=np.float64)
    worth = np.zeros(v.size)
    if caps is not None:
        worth[v != 0.0] = np.inf
    for k in range(instance.steps - 1, -1, -1):
        best = np.full(v.size, np.inf)
        for x, y in actions:
            u = instance.acc_units * x - instance.dec_units * y
            to = np.arange(v.size) + u
            inside = (to >= 0) & (to < v.size)
            candidate = np.full(v.size, np.inf)
            candidate[inside] = worth[to[inside]] + sign * _cost(instance, v[inside], x, y) + per_speed * v[to[inside]]
            best = np.minimum(best, candidate)
        if caps is not None and k:
            best[v > caps[k - 1]] = np.inf
        worth = best
    return worth


def _cost(instance: BinaryInstance, v: NDArray[np.float64], x: int, y: int) -> NDArray[np.float64]:
    """Objective of one step from speed v, in Δv²."""
    a, b, alpha = instance.acc_units, instance.dec_units, instance.alpha
    if instance.model == "constant":
        return np.full(v.size, float(a * a * x - alpha * b * b * y))
    if instance.model == "kinetic":
        return x * a * (v + a / 2) - alpha * y * b * (v - b / 2)
    s = v + a * x - b * y
    return instance.eta0 * s - instance.deta * s * s
