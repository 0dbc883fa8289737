"""The demand model as a quadratic mixed-integer program, approximated: what CQM samplers and SCIP take.

After the Alstom formulation. Speeds v_1..v_N are variables; one equation per step ties them by
the approximated forces; all products are of two variables.

- ``split``: demand d = p − q with p ≤ δ, q ≤ 1 − δ, so that δ says whether the train pulls, and no product with δ is
  left.
- ``joint``: one demand d with the joint polynomials, and the big-M constraints ε − (1 + ε)·(1 − δ) ≤ d ≤ δ, which make
  δ = 1 equivalent to d ≥ ε. (The printed M = 1 in the first one forbids d = −1.)

A bit w_i lets the train stand: then v_{i+1} = 0, and what would push it below zero is held. A solution is worth what
its replay on the true curves says.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.program.approximations import JointFits, SplitFits, joint_fits, split_fits
from tgvdp.formulations.program.binary import Program, ProgramBuilder

DemandForm: TypeAlias = Literal["split", "joint"]

#: Smallest demand that counts as traction in the big-M constraint.
EPSILON = 1e-4
#: Largest change of speed by which a standing train is held, m/s per second of the step.
_HOLD_MPS2 = 5.0


@dataclass(frozen=True)
class DemandProgram:
    """A program and how to read demands from its values.

    Attributes
    ----------
    program : Program
        In joules.
    pulls, brakes : tuple of int
        Variables p_i and q_i (``split``), or d_i and none (``joint``), in units of one notch.
    notch : float
        Demand of one notch; 1 for continuous demand.
    """

    program: Program
    pulls: tuple[int, ...]
    brakes: tuple[int, ...]
    notch: float

    def demands(self, values: Sequence[float] | NDArray[np.float64]) -> tuple[float, ...]:
        """Demands d_i of the values of the program's variables; whole notches are rounded."""
        whole = self.program.variables[self.pulls[0]].integer
        signed = [values[i] for i in self.pulls]
        if self.brakes:
            signed = [pull - values[i] for pull, i in zip(signed, self.brakes, strict=True)]
        return tuple(float(self.notch * (round(d) if whole else d)) for d in signed)


def demand_program(instance: DemandInstance, form: DemandForm = "split") -> DemandProgram:
    """Write the approximated demand model as a program.

    Raises
    ------
    InputError
        When the allowed demands are not evenly spaced from −1 to 1.
    """
    builder = ProgramBuilder()
    fits = split_fits(instance) if form == "split" else joint_fits(instance)
    notches = _notches(instance)
    most = float(notches or 1)
    whole = notches is not None
    low = 0.0 if form == "split" else -most
    pulls = [builder.add_variable(f"p_{i}", most, low, integer=whole) for i in range(instance.steps)]
    brakes = (
        [builder.add_variable(f"q_{i}", most, integer=whole) for i in range(instance.steps)] if form == "split" else []
    )
    delta = [builder.add_variable(f"delta_{i}", 1.0, integer=True) for i in range(instance.steps)]
    v = [-1, *(builder.add_variable(f"v_{k}", instance.vmax_mps) for k in range(1, instance.steps + 1))]
    for i in range(instance.steps):
        if form == "split":
            builder.add_row(f"pulls_{i}", {pulls[i]: 1.0, delta[i]: -most}, upper=0.0)
            builder.add_row(f"brakes_{i}", {brakes[i]: 1.0, delta[i]: most}, upper=most)
        else:
            builder.add_row(f"positive_{i}", {pulls[i]: 1.0, delta[i]: -most}, upper=0.0)
            builder.add_row(f"negative_{i}", {pulls[i]: 1.0, delta[i]: -most * (1.0 + EPSILON)}, lower=-most)
        _add_motion(builder, instance, i, v, _forces(fits, i, v[i], pulls, brakes, 1.0 / most))
    half = {v[k]: instance.dt_s * (0.5 if k == instance.steps else 1.0) for k in range(1, instance.steps + 1)}
    builder.add_row("distance", half, instance.distance_m - instance.tol_m, instance.distance_m + instance.tol_m)
    builder.add_row("end", {v[-1]: 1.0}, upper=instance.end_speed_max_mps)
    linear, products = _cost(instance, fits, pulls, brakes, v, 1.0 / most)
    program = Program(instance.id, tuple(builder.variables), linear, products, 1.0, tuple(builder.rows))
    return DemandProgram(program, tuple(pulls), tuple(brakes), 1.0 / most)


def _notches(instance: DemandInstance) -> int | None:
    if instance.levels is None:
        return None
    n, remainder = divmod(len(instance.levels) - 1, 2)
    if remainder or not np.allclose(instance.levels, np.arange(-n, n + 1) / max(1, n)):
        raise InputError(f"{instance.id}: a program needs notches that are evenly spaced from -1 to 1")
    return n


@dataclass
class _Terms:
    """A force or a power: per variable, and per product of two."""

    linear: dict[int, float]
    products: dict[tuple[int, int], float]

    def add(self, weight: float, first: int, second: int | None = None) -> None:
        if first < 0 or (second is not None and second < 0):
            return  # v_0 = 0
        if second is None:
            self.linear[first] = self.linear.get(first, 0.0) + weight
        else:
            pair = (min(first, second), max(first, second))
            self.products[pair] = self.products.get(pair, 0.0) + weight


def _forces(fits: SplitFits | JointFits, i: int, v_i: int, pulls: list[int], brakes: list[int], notch: float) -> _Terms:
    """Force at the wheel in step i, N."""
    terms = _Terms({}, {})
    if isinstance(fits, SplitFits):
        for variable, fit, sign in ((pulls[i], fits.traction, 1.0), (brakes[i], fits.braking, -1.0)):
            terms.add(sign * notch * fit.coefficients[0], variable)
            terms.add(sign * notch * fit.coefficients[1], variable, v_i)
    else:
        per_v, per_d, per_vd = fits.force.coefficients
        terms.add(per_v, v_i)
        terms.add(notch * per_d, pulls[i])
        terms.add(notch * per_vd, pulls[i], v_i)
    return terms


def _add_motion(builder: ProgramBuilder, instance: DemandInstance, i: int, v: list[int], force: _Terms) -> None:
    """v_{i+1} = v_i + Δt·(force − A − B·v_i − C·v_i²)/(k·M) + held."""
    a, b, c = instance.davis
    per_newton = instance.dt_s / (instance.rotating_factor * instance.mass_kg)
    held_most = _HOLD_MPS2 * instance.dt_s
    held = builder.add_variable(f"held_{i}", held_most)
    stands = builder.add_variable(f"stands_{i}", 1.0, integer=True)
    motion = _Terms({v[i + 1]: 1.0, held: -1.0}, {})
    motion.add(per_newton * b - 1.0, v[i])
    motion.add(per_newton * c, v[i], v[i])
    for variable, weight in force.linear.items():
        motion.add(-per_newton * weight, variable)
    for (first, second), weight in force.products.items():
        motion.add(-per_newton * weight, first, second)
    builder.add_row(f"motion_{i}", motion.linear, -per_newton * a, -per_newton * a, motion.products)
    builder.add_row(f"held_{i}", {held: 1.0, stands: -held_most}, upper=0.0)
    builder.add_row(f"stands_{i}", {v[i + 1]: 1.0, stands: instance.vmax_mps}, upper=instance.vmax_mps)


def _cost(
    instance: DemandInstance,
    fits: SplitFits | JointFits,
    pulls: list[int],
    brakes: list[int],
    v: list[int],
    notch: float,
) -> tuple[dict[int, float], dict[tuple[int, int], float]]:
    """Approximated cost in J: the map is at the mean speed of the step, so v_i and v_{i+1} count by half."""
    terms = _Terms({}, {})
    dt = instance.dt_s
    for i in range(instance.steps):
        if isinstance(fits, SplitFits):
            per_vp, per_p = fits.cost.coefficients
            for variable, sign in ((pulls[i], 1.0), (brakes[i], -instance.alpha)):
                terms.add(sign * dt * notch * per_p, variable)
                for speed in (v[i], v[i + 1]):
                    terms.add(0.5 * sign * dt * notch * per_vp, variable, speed)
        else:
            per_v, per_d, per_vd = fits.cost.coefficients
            terms.add(dt * notch * per_d, pulls[i])
            for speed in (v[i], v[i + 1]):
                terms.add(0.5 * dt * per_v, speed)
                terms.add(0.5 * dt * notch * per_vd, pulls[i], speed)
    return terms.linear, terms.products
