"""What a solver may spend, and where what it draws begins; every solver says in its details what it used."""

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

from tgvdp.errors import InputError

AngleChoice: TypeAlias = Literal["optimised", "ramp"]


class Item(NamedTuple):
    """Declaration of one field of `Allowance`, from which checks, the command line and the words of trials derive.

    Attributes
    ----------
    field, key : str
        Its name in Python and, without dashes in front, on the command line.
    kind : type
        int, float (s, above 0) or str.
    help : str
        Without the default.
    least, most : int
        Range of an int.
    choices : tuple of str
        The only values of a str; any where there are none.
    """

    field: str
    key: str
    kind: type
    help: str
    least: int = 0
    most: int = 0
    choices: tuple[str, ...] = ()

    def check(self, value: Any) -> None:
        """Raise `InputError` when a value is out of range."""
        if self.kind is int and not self.least <= value <= self.most:
            raise InputError(f"solver: {self.key} must be {self.least} .. {self.most}, got {value}")
        if self.kind is float and value is not None and not value > 0.0:
            raise InputError(f"solver: {self.key} must be above 0 s, got {value:g} s")
        if self.choices and value not in self.choices:
            raise InputError(f"solver: {self.key} must be one of {', '.join(self.choices)}, got {value!r}")


ITEMS = (
    Item("seed", "seed", int, "Of what is drawn.", 0, 2**31 - 1),
    Item("reads", "reads", int, "Reads of a sampler, shots of qaoa.", 1, 1_000_000),
    Item("sweeps", "sweeps", int, "sa, tabu: updates per bit.", 1, 100_000_000),
    Item("layers", "layers", int, "qaoa: layers.", 1, 100),
    Item("angles", "angles", str, "qaoa: how angles are found.", choices=get_args(AngleChoice)),
    Item("starts", "starts", int, "qaoa: random starts of the search for angles, per layer.", 0, 10_000),
    Item("backend", "backend", str, "qaoa, dwave: machine, such as fake_manila; without one qaoa is simulated."),
    Item("time_limit_s", "time-limit", float, "milp, scip, leap: end then."),
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
        Updates per bit and read (simulated annealing, tabu).
    layers : int
        p of QAOA.
    angles : {"optimised", "ramp"}
        Of QAOA.
    starts : int
        Random starting points of the optimisation of the angles, per number of layers.
    backend : str or None
        Machine: of dwave the name of a solver (any, where absent), of qaoa a fake backend (``fake_manila``, noise
        included) or a real one (``ibm_...``). QAOA is simulated without noise where absent.
    time_limit_s : float or None
        For solvers that prove optimality (milp, scip); none by default.

    Raises
    ------
    InputError
        When a value is out of range.
    """

    seed: int = 1
    reads: int = 100
    sweeps: int = 1000
    layers: int = 3
    angles: AngleChoice = "optimised"
    starts: int = 4
    backend: str | None = None
    time_limit_s: float | None = None

    def __post_init__(self) -> None:
        for item in ITEMS:
            item.check(getattr(self, item.field))
