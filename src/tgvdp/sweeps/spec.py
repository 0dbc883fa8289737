"""What a sweep runs: trains × lines × sections × everything that varies, as a sequence of scenarios.

A scenario is made when it is asked for, by its number, so that a sweep of a million takes no memory. Lines change
slowest and the last axis fastest: neighbours share their line and train.
"""

import functools
import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, NamedTuple, overload

from tgvdp.formats.native.changes import written
from tgvdp.formats.scenario import fingerprint_beside
from tgvdp.options.search import arguments_of, by_argument
from tgvdp.sweeps.scenario import Kind, Part, Scenario, Section

#: What a field of a train or line begins with; others are options of the search.
SET = ("train.", "track.")
#: Combinations of values that are remembered, for they come again with each section.
_KNOWN = 4096


class _Chosen(NamedTuple):
    """What a combination of values means for each scenario that has it."""

    parameters: Mapping[str, Any]
    changes: tuple[str, ...]
    arguments: Mapping[str, Any]
    reverse: bool


@dataclass(frozen=True)
class Axis:
    """What varies together: names of fields or options, and their values, a row each."""

    names: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


class Tables(NamedTuple):
    """Files that values of axes name: they are read once, so that workers need none.

    Attributes
    ----------
    settled : mapping of str to str
        What is set in place of an assignment that names a file.
    inputs : mapping of str to str
        SHA-256 of each file, by its path.
    remarks : tuple of str
        What their reader noted.
    """

    settled: Mapping[str, str]
    inputs: Mapping[str, str]
    remarks: tuple[str, ...]

    @property
    def provenance(self) -> dict[str, Any]:
        """Inputs of a sweep, by role: what was set, as a single search has it; none where no file was read."""
        return {"set": fingerprint_beside(self.inputs, self.remarks)} if self.inputs else {}


@dataclass(frozen=True)
class SweepSpec(Sequence[Scenario]):
    """A sweep.

    Attributes
    ----------
    trains, lines : tuple of Part
    sections : tuple of tuple of Section
        Of each line, positions from its beginning.
    sections_back : tuple of tuple of Section
        Of each line as it is run in the other direction, as many, positions from its end.
    axes : tuple of Axis
        Every row of one with every row of the others.
    tables : Tables
        What values of the axes name.
    run : mapping
        Options that all scenarios have, by their names in files.
    kind : {"search", "journey"}
    profiles_every_m : float or None
        Distance of the rows of speed profiles, m; None: no profiles.
    dwell_s : float
        Least standstill at stops, of journeys.
    csv : bool
        Whether tables are written as CSV, too.
    text : str
        The file.
    """

    trains: tuple[Part, ...]
    lines: tuple[Part, ...]
    sections: tuple[tuple[Section, ...], ...]
    sections_back: tuple[tuple[Section, ...], ...]
    axes: tuple[Axis, ...]
    tables: Tables
    run: Mapping[str, Any]
    kind: Kind
    profiles_every_m: float | None
    dwell_s: float | None
    csv: bool
    text: str

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of all that varies beside train, line and section."""
        return tuple(name for axis in self.axes for name in axis.names)

    @functools.cached_property
    def _combinations(self) -> int:
        return math.prod(len(axis.rows) for axis in self.axes)

    @functools.cached_property
    def _ends(self) -> list[int]:
        """Number of the first scenario behind each line."""
        return list(accumulate(len(self.trains) * len(own) * self._combinations for own in self.sections))

    def __len__(self) -> int:
        return self._ends[-1]

    @overload
    def __getitem__(self, number: int) -> Scenario: ...
    @overload
    def __getitem__(self, number: slice) -> list[Scenario]: ...
    def __getitem__(self, number: int | slice) -> Scenario | list[Scenario]:
        if isinstance(number, slice):
            return [self[one] for one in range(*number.indices(len(self)))]
        ends = self._ends
        if not 0 <= number < ends[-1]:
            raise IndexError(number)
        at = bisect_right(ends, number)
        rest = number - (ends[at - 1] if at else 0)
        rest, combination = divmod(rest, self._combinations)
        train, section = divmod(rest, len(self.sections[at]))
        chosen = self._chosen(combination)
        sections = self.sections_back if chosen.reverse else self.sections
        return self._scenario(number, self.trains[train], self.lines[at], sections[at][section], chosen)

    def _scenario(self, number: int, train: Part, line: Part, section: Section, chosen: _Chosen) -> Scenario:
        arguments = chosen.arguments
        if self.kind == "search":
            arguments = {**arguments, **_set_ones(_ends_of(section, line))}
        return Scenario(
            number=number,
            train=train,
            line=line,
            section=section,
            kind=self.kind,
            changes=chosen.changes,
            arguments=arguments,
            parameters=chosen.parameters,
            profiles_every_m=self.profiles_every_m,
        )

    @functools.cached_property
    def _chosen(self) -> Callable[[int], _Chosen]:
        """What a combination means, by its number; remembered."""
        return functools.lru_cache(maxsize=_KNOWN)(self._choose)

    def _choose(self, combination: int) -> _Chosen:
        chosen: dict[str, Any] = {}
        for axis in reversed(self.axes):
            combination, row = divmod(combination, len(axis.rows))
            chosen = dict(zip(axis.names, axis.rows[row], strict=True)) | chosen
        options = dict(self.run) | {name: value for name, value in chosen.items() if not name.startswith(SET)}
        arguments = arguments_of(options)
        if self.dwell_s is not None:
            arguments["dwell_s"] = self.dwell_s
        settled = self.tables.settled
        changes = tuple(settled.get(change, change) for change in changes_of(chosen))
        return _Chosen(chosen, changes, _set_ones(arguments), bool(arguments.get("reverse")))


def changes_of(chosen: Mapping[str, Any]) -> list[str]:
    """Assignments of the fields of train and line among what is chosen."""
    return [f"{name}={written(value)}" for name, value in chosen.items() if name.startswith(SET)]


def _set_ones(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments that are not left at their default."""
    return {name: value for name, value in arguments.items() if not is_default(name, value)}


def _ends_of(section: Section, line: Part) -> dict[str, float | None]:
    """Origin and destination of a stretch, in the direction in which it is run."""
    return {"origin_m": section.from_m, "destination_m": None if section.to_m == line.value.length_m else section.to_m}


def is_default(argument: str, value: Any) -> bool:
    """Whether a search that is not given an argument takes this value."""
    return argument != "dwell_s" and bool(value == by_argument(argument).default)
