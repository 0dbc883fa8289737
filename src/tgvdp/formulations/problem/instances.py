"""Instances: what one problem of the formulations consists of (`tgvdp.formulations.problem.reading` reads them)."""

from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, floor
from typing import Literal, NamedTuple, TypeAlias

Model: TypeAlias = Literal["constant", "kinetic", "efficiency"]
#: Objective models of the binary formulation.
MODELS: tuple[Model, ...] = ("constant", "kinetic", "efficiency")

#: Kinds of instances.
KINDS = ("binary", "demand", "substation")

#: Where the force curves and the cost map of the demand model end (`tgvdp.formulations.problem.alstom`).
CURVES_END_KMH = 220.0
#: A curve of radius ρ resists like a gradient of 800/ρ ‰, as the demand formulation prints it.
CURVE_M = 800.0
#: More steps than any solver here can use; a guard against files that would only exhaust the memory.
MOST_STEPS = 100_000


def decimal(value: float) -> Fraction:
    """The number that a decimal in a file means: 0.1 is 1/10 here, not the nearest binary fraction."""
    return Fraction(repr(value))


@dataclass(frozen=True, kw_only=True)
class BinaryInstance:
    """The binary model: in each of N equal time steps accelerate by one step, hold, or brake by one step.

    Speeds are counted in units of Δv, distances in units of Δv·Δt by the trapezoid rule, which equals the true
    distance of piecewise constant acceleration. The train starts and ends at standstill.

    Attributes
    ----------
    id : str
    model : str
        Objective: ``constant``, ``kinetic`` or ``efficiency`` (docs/formulations.md).
    steps : int
        N, number of controls.
    dt_s, dv_mps : float
        Δt in s and Δv in m/s.
    acc_units, dec_units : int
        Change of speed of one step of acceleration and of braking, in Δv.
    cap_units : tuple of int
        Largest speed h_k after step k = 1..N, in Δv. A fractional cap of a file is rounded down: speeds are whole.
    distance_units, tol_units : float
        D and its tolerance, in Δv·Δt.
    alpha : float
        Part of the braking energy that is regenerated; the efficiency model has none and does not use it.
    eta0, deta : float
        η0 and Δη of the efficiency model, η = η0 − Δη·v with v in Δv; 0 for the other models, which do not use them.
    lambda_uniform : float or None
        The weight of all penalties that the instance asks for, in the objective's unit per squared unit of violation.
    notes : tuple of str
        For people: what the instance leaves out, say.
    """

    id: str
    model: Model
    steps: int
    dt_s: float
    dv_mps: float
    acc_units: int
    dec_units: int
    cap_units: tuple[int, ...]
    distance_units: float
    tol_units: float = 0.0
    alpha: float = 0.0
    eta0: float = 0.0
    deta: float = 0.0
    lambda_uniform: float | None = None
    notes: tuple[str, ...] = field(default=(), compare=False)

    @property
    def objective_unit(self) -> str:
        """J/kg where the objective is an energy, that of the kinetic model; (m/s)² where it only ranks plans."""
        return "J/kg" if self.model == "kinetic" else "(m/s)²"

    @property
    def distance_range(self) -> tuple[int, int]:
        """Smallest and largest distance within the tolerance, in Δv·Δt; the first exceeds the second where none is.

        From stop to stop all three distance rules give Σ v_k, a whole number.
        """
        distance, tolerance = decimal(self.distance_units), decimal(self.tol_units)
        return max(0, ceil(distance - tolerance)), floor(distance + tolerance)


class Slope(NamedTuple):
    """A stretch of the line on which gradient and curve together resist like one gradient, from a position on.

    Attributes
    ----------
    from_m : float
    permil : float
        i + 800/ρ, gradient in ‰ and radius in m: the resistance is M·g/1000 times that.
    """

    from_m: float
    permil: float


@dataclass(frozen=True, kw_only=True)
class DemandInstance:
    """The demand model: in each step a fraction d of the available traction (d > 0) or braking force (d < 0).

    Attributes
    ----------
    id : str
    steps : int
        N, number of controls.
    dt_s : float
        Δt in s.
    levels : tuple of float, or None
        Allowed demands in increasing order, 0 among them; None for continuous demand in [−1, 1].
    mass_kg, rotating_factor : float
        M and k: the train's inertia is k·M.
    davis : tuple of three floats
        A (N), B (N/(m/s)), C (N/(m/s)²) of the running resistance.
    vmax_mps : float
        Speed limit, a constraint on v_1..v_N.
    distance_m, tol_m : float
        D and its tolerance.
    end_speed_max_mps : float
        Largest speed after the last step.
    p_max_w : float
        P_max, scale of the cost map.
    cost_ref_mps : float
        V_ref of the cost map, in m/s.
    alpha : float
        Part of the braking cost map that is given back.
    slopes : tuple of Slope
        Gradients and curves, from 0 m on; empty where the line is level and straight.
    notes : tuple of str
        For people: what the instance leaves out, say.
    """

    id: str
    steps: int
    dt_s: float
    levels: tuple[float, ...] | None
    mass_kg: float
    rotating_factor: float
    davis: tuple[float, float, float]
    vmax_mps: float
    distance_m: float
    tol_m: float
    end_speed_max_mps: float
    p_max_w: float
    cost_ref_mps: float
    alpha: float = 0.0
    slopes: tuple[Slope, ...] = ()
    notes: tuple[str, ...] = field(default=(), compare=False)

    @property
    def objective_unit(self) -> str:
        """J, by the cost map."""
        return "J"


@dataclass(frozen=True, kw_only=True)
class SharedTrip:
    """One train at a substation.

    Attributes
    ----------
    start : int
        Step at which its first control stands.
    mass_units : int
        Its mass, over that of a train of mass 1.
    trip : BinaryInstance
        Kinetic, with steps of one Δv and an exact distance; what braking gives back is the substation's matter.
    """

    start: int
    mass_units: int
    trip: BinaryInstance


@dataclass(frozen=True, kw_only=True)
class SubstationInstance:
    """Trains of the binary model that share a substation: its power is limited, and braking feeds who draws then.

    Attributes
    ----------
    id : str
    dt_s, dv_mps : float
        Δt in s and Δv in m/s, of all trains.
    power_units : int
        Largest energy of one step at the substation, in ½·Δv² per kg of a train of mass 1.
    alpha : float
        Part of the braking energy of a step that reaches trains which draw in the same step; the rest is lost.
    trains : tuple of SharedTrip
    """

    id: str
    dt_s: float
    dv_mps: float
    power_units: int
    alpha: float
    trains: tuple[SharedTrip, ...]

    @property
    def steps(self) -> int:
        """Number of steps until the last train stands."""
        return max(train.start + train.trip.steps for train in self.trains)

    @property
    def objective_unit(self) -> str:
        """J per kg of a train of mass 1."""
        return "J/kg"


Instance: TypeAlias = BinaryInstance | DemandInstance | SubstationInstance


def kind_of(instance: Instance) -> str:
    """One of `KINDS`."""
    if isinstance(instance, SubstationInstance):
        return "substation"
    return "binary" if isinstance(instance, BinaryInstance) else "demand"
