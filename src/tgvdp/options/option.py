"""The declaration of one option: its names, unit, range, choices and help, and the checks that follow from them."""

import dataclasses
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, get_args, get_origin

from tgvdp.constants import METHODS
from tgvdp.errors import ArgumentError
from tgvdp.model.checks import require_number, require_rows
from tgvdp.units import from_si, to_si


class _Unit(NamedTuple):
    """A unit of people: the end of a field's name in files, the quantity by which it becomes SI, and its unit there."""

    suffix: str
    quantity: str
    si: str


_UNITS = {
    "m": _Unit("_m", "length", "m"),
    "s": _Unit("_s", "time", "s"),
    "km/h": _Unit("_kmh", "speed", "m/s"),
    "%": _Unit("_pct", "ratio", "as a share"),
    "MB": _Unit("_mb", "memory", "B"),
}


@dataclass(frozen=True, kw_only=True)
class Option:
    """One option of a search, wherever somebody gives it.

    Attributes
    ----------
    argument : str
        Name in Python, of `tgvdp.search` and `SearchOptions`; in SI.
    kind : type
        float, int, bool, str, or tuple for several floats or rows.
    default : object
        In Python. None means that the trip, the convention or the method decides.
    name : str
        On the command line, without dashes in front. Empty: only other options set it.
    help : str
        One sentence, without the default and the methods.
    heading : str
        What it stands under on the help page.
    unit : str
        Of people, on the command line and in files: m, s, km/h, % or MB; empty: a plain number or none.
    above, at_least, at_most : float, optional
        Range in that unit.
    infinite_ok : bool
        Whether Python may give an infinite value.
    choices : tuple of str
        The only values; with `open` also names and files.
    methods : tuple of str
        Methods that have it.
    excludes : tuple of str
        Arguments that have no effect beside it.
    rows : type, optional
        Named tuple that each row of several is.
    read : callable, optional
        From a text of its own grammar, or a list of such, to the arguments that it sets; raises `InputError`.
    repeatable : bool
        Whether it may be given several times, a list in files.
    metavar : str
        Stands for the value on the help page.
    shown_default : str
        For the help page, where it is not the default itself.
    """

    argument: str = ""
    kind: type = str
    default: Any = None
    name: str = ""
    help: str = ""
    heading: str = ""
    unit: str = ""
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    infinite_ok: bool = False
    choices: tuple[str, ...] = ()
    open: bool = False
    methods: tuple[str, ...] = METHODS
    excludes: tuple[str, ...] = ()
    rows: type[Any] | None = None
    read: Callable[[Any], Mapping[str, Any]] | None = None
    repeatable: bool = False
    metavar: str = ""
    shown_default: str = ""

    @property
    def flag(self) -> str:
        """As it is written on the command line."""
        return f"--{self.name}"

    @property
    def field(self) -> str:
        """Its name in the table ``run`` of a file, which ends in the unit; texts have a grammar of their own."""
        return self.name.replace("-", "_") + (_UNITS[self.unit].suffix if self.unit and not self.read else "")

    @property
    def summary(self) -> str:
        """Help with the methods that have it and its default, as the help page shows it."""
        owners = "" if self.methods == METHODS else f"{', '.join(self.methods)}: "
        default = self.shown_default or self._default_text()
        parts = (f"{owners}{self.help}", f"[default: {default}]" if default else "")
        return "  ".join(filter(None, parts))

    @property
    def shown_value(self) -> Any:
        """Default in the unit of people; None where there is none, or where something else decides."""
        if self.default is None or self.default == ():
            return None
        return from_si(self.default, self.unit, _UNITS[self.unit].quantity) if self.unit else self.default

    def _default_text(self) -> str:
        value = self.shown_value
        if value is None or value is False:
            return ""
        if value is True:
            return self.name
        return f"{value:g}" if self.unit else str(value)

    def arguments(self, value: Any) -> dict[str, Any]:
        """Arguments of `tgvdp.search` that a value in the unit of people sets."""
        if self.read is not None:
            return dict(self.read(value))
        return {self.argument: self._si(value)}

    def _si(self, value: Any) -> Any:
        return to_si(value, self.unit, _UNITS[self.unit].quantity) if self.unit else value

    def is_default(self, value: Any) -> bool:
        """Whether an argument is the default, of its type as well."""
        return value is self.default or (type(value) is type(self.default) and value == self.default)

    def check(self, value: Any, owner: str = "search") -> Any:
        """Return an argument as its kind; the owner is whose argument errors say it is.

        Raises
        ------
        InputError
            Unless it is one, in range, and one of the choices.
        """
        if value is None and self.default is None:
            return None
        if self.kind is bool:
            return self._truth(value, owner)
        if self.kind is str:
            return self._name(value, owner)
        if self.kind is not tuple:
            return self._number(value, owner)
        if self.rows is not None:
            return require_rows(owner, self.argument, value, self.rows)
        # An array has a length too, and numpy is not loaded for this.
        if isinstance(value, str | bytes | Mapping) or not (hasattr(value, "__len__") and hasattr(value, "__iter__")):
            raise ArgumentError(owner, self.argument, f"must be a sequence of numbers, got {value!r:.60}")
        return tuple(self._number(one, owner) for one in value)

    def _truth(self, value: Any, owner: str) -> bool:
        if not isinstance(value, bool):
            raise ArgumentError(owner, self.argument, f"must be True or False, got {value!r:.60}")
        return value

    def choice(self, text: str) -> str:
        """Return the choice that a text means, in upper case or lower; any other text as it is."""
        return next((choice for choice in self.choices if choice.lower() == text.lower()), text)

    def _name(self, value: Any, owner: str) -> Any:
        value = self.choice(value) if isinstance(value, str) else value
        if not self.open and value not in self.choices:
            raise ArgumentError(owner, self.argument, f"must be one of {', '.join(self.choices)}, got {value!r:.60}")
        return value

    def check_given(self, value: Any, owner: str = "search") -> None:
        """Check a number in the unit of people, and say its name and range as files do.

        Raises
        ------
        ArgumentError
            Unless it is one, and in range.
        """
        self._in_range(owner, self.field, value, self.unit, (self.above, self.at_least, self.at_most))

    def _number(self, value: Any, owner: str) -> float:
        unit = _UNITS[self.unit].si if self.unit else ""
        limits = tuple(
            None if limit is None else self._si(limit) for limit in (self.above, self.at_least, self.at_most)
        )
        return self._in_range(owner, self.argument, value, unit, limits)

    def _in_range(self, owner: str, name: str, value: Any, unit: str, limits: tuple[float | None, ...]) -> float:
        above, at_least, at_most = limits
        number = require_number(owner, name, value, unit, above=above, at_least=at_least, infinite_ok=self.infinite_ok)
        of = f" {unit}" if unit else ""
        if at_most is not None and number > at_most:
            raise ArgumentError(owner, name, f"must be at most {at_most:g}{of}, got {number:.12g}{of}")
        if self.kind is not int:
            return number
        if number != int(number):
            raise ArgumentError(owner, name, f"must be a whole number, got {number:g}")
        return int(number)


def option(default: Any, help: str = "", **declared: Any) -> Any:
    """Declare a field of a frozen dataclass as an option; see `Option`."""
    return dataclasses.field(default=default, metadata={"option": Option(default=default, help=help, **declared)})


def options_of(declared: type) -> tuple[Option, ...]:
    """All options that a dataclass declares, in its order; kind and name from the field unless said otherwise."""
    return tuple(_completed(field) for field in dataclasses.fields(declared))


def _completed(field: "dataclasses.Field[Any]") -> Option:
    one: Option = field.metadata["option"]
    return dataclasses.replace(one, argument=field.name, kind=_kind(field.type))


def _kind(annotation: Any) -> type:
    """Float of ``float | None``, tuple of ``Sequence[float]``, str of what takes a name or more."""
    if isinstance(annotation, types.UnionType):
        annotation = get_args(annotation)[0]
    if get_origin(annotation) is Sequence:
        return tuple
    return annotation if annotation in (float, int, bool) else str
