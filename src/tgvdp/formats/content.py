"""What a file of a foreign format holds: named trains, tracks and journeys, each made when it is asked for."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

from tgvdp.formats.syntax.reading import bad, shown
from tgvdp.model.journey import Journey
from tgvdp.model.track import Track
from tgvdp.model.train import Train

Kind = Literal["train", "track", "map", "journey"]

_MOST_NAMES = 12


class Item(NamedTuple):
    """One thing in a file: its identifier there, how to make it, other names, and its fields that no run uses.

    ``own`` are those of its notes that are the file's own words, of which nobody has to be warned.
    """

    id: str
    make: Callable[[], Train | Track | Journey]
    names: tuple[str, ...] = ()
    kept: Mapping[str, Any] = {}
    own: tuple[str, ...] = ()


class Outline(NamedTuple):
    """A timetable that is nothing without a line: its identifier, what it is of, what it says, and other names."""

    id: str
    what: str
    text: str
    names: tuple[str, ...] = ()


_Named = TypeVar("_Named", bound=Item | Outline)


@dataclass(frozen=True, kw_only=True)
class Content:
    """What a file holds.

    Attributes
    ----------
    format : str
        For people, such as "TTOBench".
    items : dict
        By kind, in the order of the file; kinds that it does not hold are absent.
    default : str, optional
        Identifier of the item that the file itself prefers where it holds several of its kind.
    takes_line_speed : bool
        Whether its tracks may lack speed limits, in place of which ``Document.line_speed_mps`` can stand.
    inputs : mapping of str to str
        SHA-256 of other files that it refers to, by their paths; they are read when its items are made.
    lacking : mapping of str to str
        By kind: why the file does not hold one, where that is worth saying.
    outline : tuple of Outline
        What the file does hold, where that is nothing without another file, and ``items`` is empty.
    """

    format: str
    items: Mapping[Kind, tuple[Item, ...]]
    default: str | None = None
    takes_line_speed: bool = False
    inputs: Mapping[str, str] = field(default_factory=dict)
    lacking: Mapping[Kind, str] = field(default_factory=dict)
    outline: tuple[Outline, ...] = ()

    @property
    def is_one(self) -> bool:
        """Whether nothing has to be chosen."""
        return all(len(self.each(kind)) == 1 for kind in self.items)

    def has(self, kind: Kind, part: str) -> bool:
        """Whether there is an item of that kind and name."""
        return any(part in (item.id, *item.names) for item in self.items.get(kind, ()))

    def each(self, kind: Kind) -> tuple[Item, ...]:
        """The items of a kind, or only the one that the file prefers."""
        preferred = tuple(item for item in self.items[kind] if item.id == self.default)
        return preferred or self.items[kind]

    def choose(self, path: Path, kind: Kind, part: str | None) -> Item:
        """Return the item that a user means by the text behind ``#``, or by none.

        Raises
        ------
        InputError
            When there is none of that name, several of it, or several and no name.
        """
        items = self.items[kind] if part is not None else self.each(kind)
        return items[0] if part is None and len(items) == 1 else _chosen(path, kind, items, part)

    def outlined(self, path: Path, part: str | None) -> tuple[Outline, ...]:
        """Return the timetables that a user means by the text behind ``#``, all by none; see `choose`."""
        return self.outline if part is None else (_chosen(path, "journey", self.outline, part),)


def _chosen(path: Path, kind: Kind, items: tuple[_Named, ...], part: str | None) -> _Named:
    named = [item for item in items if part in item.names]
    chosen = [item for item in items if part == item.id] or named
    if len(chosen) == 1 or (chosen and chosen is not named):
        return chosen[0]
    known = [item.id for item in chosen or items]
    names = ", ".join(known[:_MOST_NAMES]) + (", …" if len(known) > _MOST_NAMES else "")
    if part is None or chosen:
        called = f" that are called {shown(part)}" if part is not None else ""
        raise bad(path, f"holds {len(known)} {kind}s{called}, choose one as FILE#NAME: {names}")
    near = get_close_matches(part, [name for one in items for name in (one.id, *one.names)], n=1)
    hint = f", did you mean {near[0]!r}?" if near else f"; it holds: {names}"
    raise bad(path, f"holds no {kind} {shown(part)}{hint}")
