"""What a solver may spend, and where what it draws begins; every solver says in its details what it used."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

from tgvdp.errors import InputError

AngleChoice: TypeAlias = Literal["optimised", "ramp"]
MixerChoice: TypeAlias = Literal["x", "walls"]
FormChoice: TypeAlias = Literal["split", "delta", "joint"]
FORMS: tuple[FormChoice, ...] = get_args(FormChoice)


class BetaRange(NamedTuple):
    """Inverse temperatures from the hottest to the coldest, per unit of the objective."""

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:.12g}..{self.high:.12g}"


def beta_range(text: str) -> BetaRange:
    """Read ``LOW..HIGH``.

    Raises
    ------
    ValueError
        When it is not that.
    """
    low, dots, high = text.partition("..")
    if not dots:
        raise ValueError(f"{text!r} is not LOW..HIGH")
    return BetaRange(float(low), float(high))


class Item(NamedTuple):
    """Declaration of one field of `Allowance`, from which checks, the command line and the words of trials derive.

    Attributes
    ----------
    field, key : str
        Its name in Python and, without dashes in front, on the command line.
    read : callable
        From text: int, float (above 0), str or `beta_range`.
    help : str
        Without the default.
    least, most : float
        Range of an int; ``most`` also that of a float, where it is not 0.
    unit : str
        Of a float.
    choices : tuple of str
        The only values of a str; any where there are none.
    """

    field: str
    key: str
    read: Callable[[str], Any]
    help: str
    least: int = 0
    most: int = 0
    unit: str = ""
    choices: tuple[str, ...] = ()

    def check(self, value: Any) -> None:
        """Raise `InputError` when a value is out of range; None, where it is the default, is in range."""
        if value is None:
            return
        wrong = None
        if self.read is int and not self.least <= value <= self.most:
            wrong = f"{self.least} .. {self.most}"
        elif self.read is float and not (0.0 < value < math.inf and (not self.most or value <= self.most)):
            wrong = f"above 0{f' and at most {self.most}' if self.most else ''} {self.unit}".rstrip()
        elif self.read is beta_range and not 0.0 < value.low < value.high < math.inf:
            wrong = "LOW..HIGH with 0 < LOW < HIGH"
        elif self.choices and value not in self.choices:
            wrong = f"one of {', '.join(self.choices)}"
        if wrong is not None:
            raise InputError(f"solver: {self.key} must be {wrong}, got {value}")


ITEMS = (
    Item("seed", "seed", int, "Of what is drawn.", 0, 2**31 - 1),
    Item("reads", "reads", int, "Reads of a sampler, shots of qaoa.", 1, 1_000_000),
    Item("sweeps", "sweeps", int, "sa, pt, tabu: updates per bit.", 1, 100_000_000),
    Item("beta", "beta", beta_range, "sa, pt: inverse temperatures LOW..HIGH, per unit of the objective."),
    Item("replicas", "replicas", int, "pt: temperatures.", 2, 1000),
    Item("tenure", "tenure", float, "tabu: bits that may not flip back, as a part of all.", most=1),
    Item("layers", "layers", int, "qaoa: layers.", 1, 100),
    Item("mixer", "mixer", str, "qaoa: x turns bits, walls moves the steps of unary.", choices=get_args(MixerChoice)),
    Item("angles", "angles", str, "qaoa: how angles are found.", choices=get_args(AngleChoice)),
    Item("step", "step", float, "qaoa: angle of a whole layer of a ramp; the best of 16 where absent.", unit="rad"),
    Item("starts", "starts", int, "qaoa: random starts of the search for angles, per layer.", 0, 10_000),
    Item("backend", "backend", str, "qaoa, dwave: machine, such as fake_manila; without one qaoa is simulated."),
    Item("chain_strength", "chain-strength", float, "dwave: coupling of a chain over the largest coefficient."),
    Item("anneal_us", "anneal-time", float, "dwave: duration of an anneal.", unit="µs"),
    Item("form", "form", str, "scip, cqm, leap: approximation of a demand instance.", choices=FORMS),
    Item("time_limit_s", "time-limit", float, "greedy, milp, scip, cqm, leap: end then.", unit="s"),
)


@dataclass(frozen=True, kw_only=True)
class Allowance:
    """Budgets and settings of the solvers; each uses those that its docstring names.

    Attributes
    ----------
    seed : int
        Of everything that is drawn, 0 .. 2³¹ − 1.
    reads : int
        Independent runs of a sampler, shots of a circuit.
    sweeps : int
        Updates per bit and read (simulated annealing, parallel tempering, tabu).
    beta : BetaRange or None
        Inverse temperatures of annealing and tempering; by the size of the coefficients where absent.
    replicas : int
        Temperatures of parallel tempering.
    tenure : float
        Of tabu search, as a part of the number of bits.
    layers : int
        p of QAOA.
    mixer : {"x", "walls"}
        Of QAOA: of single bits, or of the walls of unary registers, which stay in order.
    angles : {"optimised", "ramp"}
        Of QAOA.
    step : float or None
        Angle of a whole layer of a ramp, rad; the best of several where absent.
    starts : int
        Random starting points of the optimisation of the angles, per number of layers.
    backend : str or None
        Machine: of dwave the name of a solver (any, where absent), of qaoa a fake backend (``fake_manila``, noise
        included) or a real one (``ibm_...``). QAOA is simulated without noise where absent.
    chain_strength : float or None
        Of dwave: coupling that holds a chain together, over the largest coefficient of the Ising form; by torque
        compensation, the rule of dwave-system, where absent.
    anneal_us : float or None
        Duration of an anneal, µs; the machine's own where absent.
    form : {"split", "delta", "joint"} or None
        Of the program that approximates a demand instance (`tgvdp.formulations.program.demand`); ``split`` where
        absent. Binary instances have none.
    time_limit_s : float or None
        For solvers that prove optimality (milp, scip, cqm) and for greedy; none by default.

    Raises
    ------
    InputError
        When a value is out of range, or one is given that another makes useless.
    """

    seed: int = 1
    reads: int = 100
    sweeps: int = 1000
    beta: BetaRange | None = None
    replicas: int = 8
    tenure: float = 0.5
    layers: int = 3
    mixer: MixerChoice = "x"
    angles: AngleChoice = "optimised"
    step: float | None = None
    starts: int = 4
    backend: str | None = None
    chain_strength: float | None = None
    anneal_us: float | None = None
    form: FormChoice | None = None
    time_limit_s: float | None = None

    def __post_init__(self) -> None:
        for item in ITEMS:
            item.check(getattr(self, item.field))
        if self.step is not None and self.angles != "ramp":
            raise InputError("solver: step is that of a ramp, so it needs angles ramp")
        if self.mixer == "walls" and (self.angles != "ramp" or self.backend is not None):
            raise InputError("solver: mixer walls needs angles ramp and no backend: its angles are not searched for")

    def deadline_s(self, start_s: float) -> float:
        """When the time limit of a solver that began at ``start_s`` ends, infinite where there is none."""
        return math.inf if self.time_limit_s is None else start_s + self.time_limit_s
