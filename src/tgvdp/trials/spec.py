"""What to run: a solver, its encoding and penalty, and its budget, as one word of the command line.

``NAME[:ENCODING][:KEY=VALUE ...]``, such as ``dp``, ``sa:unary:sweeps=3000`` or ``qaoa:bits:layers=2:runs=1``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.names import Encoding, PenaltyRule, parse_encoding, parse_penalty, penalty_word
from tgvdp.solvers.allowance import ITEMS, Allowance
from tgvdp.solvers.registry import SOLVERS


def _count(text: str) -> int:
    count = int(text)
    if count < 1:
        raise ValueError
    return count


def _shown(value: object) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _encoding(text: str) -> Encoding | None:
    try:
        return parse_encoding(text)
    except ValueError:
        return None


#: Keys of a solver's budget, the field of `Allowance` that they set, and how they are read. Trials count their seeds.
_BUDGET: Mapping[str, tuple[str, Callable[[str], Any]]] = {
    item.key: (item.field, item.read) for item in ITEMS if item.field != "seed"
}


@dataclass(frozen=True)
class SolverSpec:
    """A solver as the benchmark runs it.

    Attributes
    ----------
    solver : str
        One of `tgvdp.solvers.registry.SOLVERS`.
    encoding : str or None
        Of solvers of a QUBO; ``unary`` where none is given.
    penalty : "sufficient", "tenfold", float, tuple of float or None
        As `tgvdp.formulations.qubo.encodings.encode` takes it.
    budget : mapping
        Fields of `Allowance` that differ from their defaults.
    runs : int or None
        Own number of runs, for solvers that always do the same or take long.
    """

    solver: str
    encoding: Encoding | None = None
    penalty: PenaltyRule | None = None
    budget: Mapping[str, Any] = field(default_factory=dict)
    runs: int | None = None

    @property
    def label(self) -> str:
        """The word for it, in one order of its parts; ``runs`` does not change what a run does and is left out."""
        keys = {name: key for key, (name, _) in _BUDGET.items()}
        parts = [self.solver, *([self.encoding] if self.encoding else [])]
        parts += [f"penalty={penalty_word(self.penalty)}"] if self.penalty is not None else []
        return ":".join(parts + [f"{keys[name]}={_shown(value)}" for name, value in sorted(self.budget.items())])

    @property
    def draws(self) -> bool:
        """Whether runs differ: the solver draws random numbers."""
        return "seed" in SOLVERS[self.solver].uses

    def allowance(self, seed: int) -> Allowance:
        """What one run may spend."""
        return Allowance(**({"seed": seed} if self.draws else {}) | dict(self.budget))


def parse_spec(text: str) -> SolverSpec:
    """Read one word.

    Raises
    ------
    InputError
        When the solver is unknown, or a part is not one that it uses.
    """
    name, *parts = text.strip().split(":")
    if name not in SOLVERS:
        raise InputError(f"solvers: there is no {name!r}; there are {', '.join(SOLVERS)}")
    entry = SOLVERS[name]
    encoding: Encoding | None = "unary" if entry.qubo else None
    found: dict[str, Any] = {}
    for part in parts:
        key, equals, value = part.partition("=")
        if not equals and entry.qubo and (word := _encoding(part)) is not None:
            encoding = word
            continue
        usable = {key: rule for key, rule in _BUDGET.items() if rule[0] in entry.uses} | {"runs": ("runs", _count)}
        usable |= {"penalty": ("penalty", parse_penalty)} if entry.qubo else {}
        if not equals or key not in usable:
            others = " or ".join([*(["an encoding"] if entry.qubo else []), *(f"{one}=…" for one in sorted(usable))])
            raise InputError(f"solvers: {text!r}: {name} takes {others}, not {part!r}")
        target, read = usable[key]
        try:
            found[target] = read(value)
        except ValueError:
            raise InputError(f"solvers: {text!r}: {value!r} is no value of {key}") from None
    penalty, runs = found.pop("penalty", None), found.pop("runs", None)
    spec = SolverSpec(name, encoding, penalty, found, runs)
    spec.allowance(1)  # refuses what is out of range
    return spec


def parse_specs(text: str) -> list[SolverSpec]:
    """Read a list with commas; no two of them may be the same.

    Raises
    ------
    InputError
        As `parse_spec`, or when the list is empty or names a solver twice.
    """
    specs = [parse_spec(word) for word in text.split(",") if word.strip()]
    labels = [spec.label for spec in specs]
    if not labels or len(set(labels)) < len(labels):
        twice = next((label for label in labels if labels.count(label) > 1), None)
        raise InputError(f"solvers: {twice!r} is given twice" if twice else "solvers: none is given")
    return specs
