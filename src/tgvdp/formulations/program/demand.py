"""The demand model as a quadratic mixed-integer program, approximated: what CQM samplers and SCIP take.

After the Alstom formulation. Speeds v_1..v_N are variables; one equation per step ties them by
the approximated forces; all products are of two variables. Three forms (`DemandForm`):

- ``split``: demand d = p − q with p ≤ δ, q ≤ 1 − δ, so that δ says whether the train pulls, and no product with δ is
  left.
- ``delta``: as printed, one demand d that δ multiplies, with the same first-degree fits of F₊ and F₋: p = d·δ is an
  equation of its own, because products of three variables are none of a quadratic program.
- ``joint``: as printed for samplers, one demand d with one polynomial of speed and demand, and no difference between
  traction and braking.

``delta`` and ``joint`` have the big-M constraints ε − (1 + ε)·(1 − δ) ≤ d ≤ δ, which make δ = 1 equivalent to d ≥ ε.
(The printed M = 1 in the first one forbids d = −1.)

A bit w_i lets the train stand: then v_{i+1} = 0, and what would push it below zero is held. Where the line has slopes,
positions s_i are variables, and a bit per step and slope says on which one the step starts. A solution is worth what
its replay on the true curves says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.problem.demand import slope_force_n
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.program.approximations import SplitFits, joint_fits, split_fits
from tgvdp.formulations.program.binary import Program, ProgramBuilder, Terms

DemandForm: TypeAlias = Literal["split", "delta", "joint"]
DEMAND_FORMS: tuple[DemandForm, ...] = get_args(DemandForm)

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
    controls : tuple of mapping
        Demand of each step in notches, as a sum over variables.
    notch : float
        Demand of one notch; 1 for continuous demand.
    """

    program: Program
    controls: tuple[Terms, ...]
    notch: float

    def demands(self, values: Sequence[float] | NDArray[np.float64]) -> tuple[float, ...]:
        """Demands d_i of the values of the program's variables; whole notches are rounded."""
        variables = self.program.variables
        whole = all(variables[i].integer for terms in self.controls for i in terms)
        found = (sum(weight * values[i] for i, weight in terms.items()) for terms in self.controls)
        return tuple(float(self.notch * (round(d) if whole else d)) for d in found)


def demand_program(instance: DemandInstance, form: DemandForm = "split") -> DemandProgram:
    """Write the approximated demand model as a program.

    Raises
    ------
    InputError
        When the allowed demands are not evenly spaced from −1 to 1.
    """
    writer = _Writer(instance, form)
    controls = [writer.control(i) for i in range(instance.steps)]
    for i, control in enumerate(controls):
        writer.add_motion(i, control)
    writer.add_ends()
    cost = writer.cost(controls)
    builder = writer.builder
    program = Program(instance.id, tuple(builder.variables), cost.linear, cost.products, 1.0, tuple(builder.rows))
    return DemandProgram(program, tuple(control.signed for control in controls), 1.0 / writer.most)


class _Control(NamedTuple):
    """What the driver does in a step, in notches, as sums over variables; traction and braking are empty in `joint`."""

    signed: Terms
    pull: Terms
    brake: Terms


@dataclass
class _Quadratic:
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

    def add_sum(self, weight: float, terms: Mapping[int, float], second: int | None = None) -> None:
        for variable, part in terms.items():
            self.add(weight * part, variable, second)


class _Writer:
    """Writes one program, step by step."""

    def __init__(self, instance: DemandInstance, form: DemandForm) -> None:
        notches = _notches(instance)
        self.instance = instance
        self.form = form
        self.fits = joint_fits(instance) if form == "joint" else split_fits(instance)
        self.whole = notches is not None
        self.most = float(notches or 1)
        self.builder = ProgramBuilder()
        speeds = (self.builder.add_variable(f"v_{k}", instance.vmax_mps) for k in range(1, instance.steps + 1))
        self.v = [-1, *speeds]
        self.s = self._positions() if len(instance.slopes) > 1 else []

    def _positions(self) -> list[int]:
        """s_0 = 0 .. s_{N−1}, where the steps start: s_{i+1} = s_i + Δt·(v_i + v_{i+1})/2."""
        instance, builder = self.instance, self.builder
        farthest = instance.distance_m + instance.tol_m
        s = [-1, *(builder.add_variable(f"s_{i}", farthest) for i in range(1, instance.steps))]
        for i in range(1, instance.steps):
            way = _Quadratic({s[i]: 1.0}, {})
            way.add(-1.0, s[i - 1])
            for speed in (self.v[i - 1], self.v[i]):
                way.add(-0.5 * instance.dt_s, speed)
            builder.add_row(f"way_{i}", way.linear, 0.0, 0.0)
        return s

    def control(self, i: int) -> _Control:
        """Add the variables of the demand of a step."""
        builder, most = self.builder, self.most
        delta = builder.add_variable(f"delta_{i}", 1.0, integer=True)
        if self.form == "split":
            p, q = (builder.add_variable(f"{name}_{i}", most, integer=self.whole) for name in "pq")
            builder.add_row(f"pulls_{i}", {p: 1.0, delta: -most}, upper=0.0)
            builder.add_row(f"brakes_{i}", {q: 1.0, delta: most}, upper=most)
            return _Control({p: 1.0, q: -1.0}, {p: 1.0}, {q: 1.0})
        d = builder.add_variable(f"d_{i}", most, -most, integer=self.whole)
        builder.add_row(f"positive_{i}", {d: 1.0, delta: -most}, upper=0.0)
        builder.add_row(f"negative_{i}", {d: 1.0, delta: -most * (1.0 + EPSILON)}, lower=-most)
        if self.form == "joint":
            return _Control({d: 1.0}, {}, {})
        p = builder.add_variable(f"p_{i}", most, integer=self.whole)
        builder.add_row(f"pulls_{i}", {p: 1.0}, 0.0, 0.0, {(min(delta, d), max(delta, d)): -1.0})
        return _Control({d: 1.0}, {p: 1.0}, {p: 1.0, d: -1.0})

    def add_motion(self, i: int, control: _Control) -> None:
        """v_{i+1} = v_i + Δt·(force − A − B·v_i − C·v_i² − slope)/(k·M) + held."""
        instance, builder, v = self.instance, self.builder, self.v
        a, b, c = instance.davis
        per_newton = instance.dt_s / (instance.rotating_factor * instance.mass_kg)
        held_most = _HOLD_MPS2 * instance.dt_s
        held = builder.add_variable(f"held_{i}", held_most)
        stands = builder.add_variable(f"stands_{i}", 1.0, integer=True)
        motion = _Quadratic({v[i + 1]: 1.0, held: -1.0}, {})
        motion.add(per_newton * b - 1.0, v[i])
        motion.add(per_newton * c, v[i], v[i])
        motion.add_sum(per_newton, self._slope(i))
        force = self._force(v[i], control)
        motion.add_sum(-per_newton, force.linear)
        for pair, weight in force.products.items():
            motion.add(-per_newton * weight, *pair)
        constant = a if self.s or not instance.slopes else a + float(slope_force_n(instance, instance.slopes[0].permil))
        side = -per_newton * constant
        builder.add_row(f"motion_{i}", motion.linear, side, side, motion.products)
        builder.add_row(f"held_{i}", {held: 1.0, stands: -held_most}, upper=0.0)
        builder.add_row(f"stands_{i}", {v[i + 1]: 1.0, stands: instance.vmax_mps}, upper=instance.vmax_mps)

    def _slope(self, i: int) -> Terms:
        """Force of the slope on which step i starts, N: a bit for each, and s_i within that one."""
        if not self.s:
            return {}
        instance, builder = self.instance, self.builder
        starts = [slope.from_m for slope in instance.slopes]
        ends = [*starts[1:], max(starts[-1], instance.distance_m + instance.tol_m)]
        on = [builder.add_variable(f"on_{i}_{j}", 1.0, integer=True) for j in range(len(starts))]
        builder.add_row(f"on_{i}", dict.fromkeys(on, 1.0), 1.0, 1.0)
        place = _Quadratic({}, {})
        place.add(1.0, self.s[i])
        builder.add_row(f"after_{i}", place.linear | dict(zip(on, (-m for m in starts), strict=True)), lower=0.0)
        builder.add_row(f"before_{i}", place.linear | dict(zip(on, (-m for m in ends), strict=True)), upper=0.0)
        forces = slope_force_n(instance, [slope.permil for slope in instance.slopes])
        return dict(zip(on, forces.tolist(), strict=True))

    def _force(self, v_i: int, control: _Control) -> _Quadratic:
        """Force at the wheel at speed v_i, N."""
        force, notch = _Quadratic({}, {}), 1.0 / self.most
        if isinstance(self.fits, SplitFits):
            fits = self.fits
            for part, fit, sign in ((control.pull, fits.traction, notch), (control.brake, fits.braking, -notch)):
                force.add_sum(sign * fit.coefficients[0], part)
                force.add_sum(sign * fit.coefficients[1], part, v_i)
        else:
            per_v, per_d, per_vd = self.fits.force.coefficients
            force.add(per_v, v_i)
            force.add_sum(notch * per_d, control.signed)
            force.add_sum(notch * per_vd, control.signed, v_i)
        return force

    def add_ends(self) -> None:
        """Distance and speed at the end."""
        instance, v, last = self.instance, self.v, self.instance.steps
        half = {v[k]: instance.dt_s * (0.5 if k == last else 1.0) for k in range(1, last + 1)}
        near, far = instance.distance_m - instance.tol_m, instance.distance_m + instance.tol_m
        self.builder.add_row("distance", half, near, far)
        self.builder.add_row("end", {v[-1]: 1.0}, upper=instance.end_speed_max_mps)

    def cost(self, controls: Sequence[_Control]) -> _Quadratic:
        """Approximated cost in J: the map is at the mean speed of the step, so v_i and v_{i+1} count by half."""
        cost, dt, notch = _Quadratic({}, {}), self.instance.dt_s, 1.0 / self.most
        for i, control in enumerate(controls):
            speeds = (self.v[i], self.v[i + 1])
            if isinstance(self.fits, SplitFits):
                per_vp, per_p = self.fits.cost.coefficients
                for part, sign in ((control.pull, dt * notch), (control.brake, -self.instance.alpha * dt * notch)):
                    cost.add_sum(sign * per_p, part)
                    for speed in speeds:
                        cost.add_sum(0.5 * sign * per_vp, part, speed)
            else:
                per_v, per_d, per_vd = self.fits.cost.coefficients
                cost.add_sum(dt * notch * per_d, control.signed)
                for speed in speeds:
                    cost.add(0.5 * dt * per_v, speed)
                    cost.add_sum(0.5 * dt * notch * per_vd, control.signed, speed)
        return cost


def _notches(instance: DemandInstance) -> int | None:
    if instance.levels is None:
        return None
    n, remainder = divmod(len(instance.levels) - 1, 2)
    if remainder or not np.allclose(instance.levels, np.arange(-n, n + 1) / max(1, n)):
        raise InputError(f"{instance.id}: a program needs notches that are evenly spaced from -1 to 1")
    return n
