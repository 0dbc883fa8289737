"""What a solver may spend, and where what it draws begins; every solver says in its details what it used."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from tgvdp.errors import InputError

AngleChoice: TypeAlias = Literal["optimised", "ramp"]
#: How the angles of QAOA are found.
ANGLES: tuple[AngleChoice, ...] = get_args(AngleChoice)


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
    time_limit_s : float or None
        For solvers that prove optimality (milp, scip); none by default.
    backend : str or None
        Machine: of dwave the name of a solver (any, where absent), of qaoa a fake backend (``fake_manila``, noise
        included) or a real one (``ibm_...``). QAOA is simulated without noise where absent.

    Raises
    ------
    InputError
        When a number is out of range.
    """

    seed: int = 1
    reads: int = 100
    sweeps: int = 1000
    layers: int = 3
    angles: AngleChoice = "optimised"
    starts: int = 4
    time_limit_s: float | None = None
    backend: str | None = None

    def __post_init__(self) -> None:
        for name, least, most in (
            ("seed", 0, 2**31 - 1),
            ("reads", 1, 1_000_000),
            ("sweeps", 1, 100_000_000),
            ("layers", 1, 100),
            ("starts", 0, 10_000),
        ):
            value = getattr(self, name)
            if not least <= value <= most:
                raise InputError(f"solver: {name} must be {least} .. {most}, got {value}")
        if self.angles not in ANGLES:
            raise InputError(f"solver: angles must be one of {', '.join(ANGLES)}, got {self.angles!r}")
        if self.time_limit_s is not None and not self.time_limit_s > 0.0:
            raise InputError(f"solver: time limit must be above 0 s, got {self.time_limit_s:g} s")
