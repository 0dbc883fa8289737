"""railML 2.0 to 2.5 and 3.1 to 3.3: the infrastructure that one run needs, and rolling stock with effort tables.

A file may hold many tracks, directions, speed profiles, trains, propulsions, and, of 2.x, timetables. Names behind
``FILE#`` choose: ``ID``, ``ID:DIRECTION``, ``ID:DIRECTION:PROFILE`` for a track, several joined by ``+`` for a line of
tracks one after the other; ``ID`` or ``ID:PROPULSION`` for a train, ``ID`` or its number for the journey of one. What
is not said must be unique. See docs/formats.md.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item, Kind, Outline
from tgvdp.formats.railml import line2, line3, stock, timetable2
from tgvdp.formats.railml.rows import Piece, join
from tgvdp.formats.syntax.reading import Document, bad, shown
from tgvdp.formats.syntax.typed import suggestion
from tgvdp.formats.syntax.xml import Node, parse_xml
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.units import mps_to_kmh

FORMAT = "railML"
_VERSIONS = ("2.0", "2.1", "2.2", "2.3", "2.4", "2.5", "3.1", "3.2", "3.3")
#: What a file without a version can only be.
_BY_NAMESPACE = {
    "http://www.railml.org/schemas/2009": "2.0",
    "http://www.railml.org/schemas/2011": "2.1",
    "http://www.railml.org/schemas/2013": "2.2",
    "https://www.railml.org/schemas/2016": "2.3",
    "https://www.railml.org/schemas/2018": "2.4",
    "https://www.railml.org/schemas/2021": "2.5",
    "https://www.railml.org/schemas/3.1": "3.1",
    "https://www.railml.org/schemas/3.2": "3.2",
    "https://www.railml.org/schemas/3.3": "3.3",
}
_ROOTS = ("railml", "railML")  # 2.x and 3.x
_MOST_NAMES = 12


@dataclass(frozen=True, kw_only=True)
class RailmlContent(Content):
    """Tracks, trains and journeys of a railML file; a track may be several that join."""

    file: "_File"

    def has(self, kind: Kind, part: str) -> bool:
        """Whether the first of the joined names is one of that kind."""
        if kind == "journey":
            return super().has(kind, part)
        return self.file.knows(kind, _owner(part.partition("+")[0]))

    def choose(self, path: Path, kind: Kind, part: str | None) -> Item:
        """Return the item that the text behind ``#`` means, or the only one."""
        if part is None or kind == "journey":
            return super().choose(path, kind, part)
        make = self.file.make_track if kind == "track" else self.file.make_train
        return Item(part, lambda: make(part)[0])


def open_document(document: Document) -> Content | None:
    """Return what a railML document holds; None when it is no XML.

    Raises
    ------
    InputError
        When it is not well formed, another kind of XML, or of an unknown version.
    """
    if document.syntax != "XML":
        return None
    file = _File(document)
    items: dict[Kind, tuple[Item, ...]] = {
        "train": tuple(Item(name, partial(_first, file.make_train, name)) for name in file.train_names()),
        "track": tuple(Item(name, partial(_first, file.make_track, name)) for name in file.track_names()),
    }
    lacking: dict[Kind, str] = {}
    if document.places:
        items["journey"] = file.journeys(document.places)
    elif file.journeys(()):
        lacking["journey"] = "its timetable names places alone, and no line is given that has names"
    items = {kind: some for kind, some in items.items() if some}
    outline = () if items else file.outline()
    if not items and not outline:
        raise bad(document.path, f"holds no track and no train: {file.wanted}")
    form = f"{FORMAT} {file.version}"
    return RailmlContent(format=form, items=items, takes_line_speed=True, lacking=lacking, outline=outline, file=file)


def lines_of(document: Document, kind: Kind, part: str | None) -> dict[str, int]:
    """Line of the file of each field of a chosen track or train, as far as it stands there."""
    file = _File(document)
    names = file.train_names() if kind == "train" else file.track_names()
    chosen = names[0] if part is None else part
    return (file.make_train(chosen) if kind == "train" else file.make_track(chosen))[1]


def _first(make: Callable[[str], tuple[Train, object] | tuple[Track, object]], name: str) -> Train | Track:
    return make(name)[0]


class _File:
    """A parsed file, by version."""

    def __init__(self, document: Document) -> None:
        self.path = document.path
        speed_mps = document.line_speed_mps
        self._line_speed_kmh = None if speed_mps is None else mps_to_kmh(speed_mps)
        self.root = parse_xml(document.path, document.data)
        if self.root.name not in _ROOTS:
            root = shown(self.root.name)
            raise bad(self.path, f"holds XML, but neither railML nor SFERA to be run: its root is {root}")
        self.version = self.root.text("version") or _BY_NAMESPACE.get(self.root.namespace) or ""
        if not self.version:
            raise self.root.bad("missing attribute, and the namespace is that of no known version", "version")
        if not re.match(rf"({'|'.join(map(re.escape, _VERSIONS))})(\D|$)", self.version):
            raise self.root.bad(f"must be one of {', '.join(_VERSIONS)}, got {shown(self.version)}", "version")
        self._old = self.version.startswith("2")
        self._line = line2 if self._old else line3

    @property
    def wanted(self) -> str:
        """What would make a file one that a run can be read from."""
        track = "track" if self._old else "track or line with a linearLocation over net elements"
        return f"neither a {track}, nor a formation or a vehicle with engine"

    def track_names(self) -> list[str]:
        """All tracks, with the directions and profiles that they can be run in where there are several."""
        return [name for track in self._line.tracks(self.root) for name in self._ways(track)]

    def train_names(self) -> list[str]:
        """All trains, with their propulsions where there are several."""
        names = []
        for train in stock.trains(self.root):
            modes = stock.modes(self.root, train)
            names += [f"{_id(train)}:{mode}" for mode in modes] if modes else [_id(train)]
        return names

    def journeys(self, places: tuple[tuple[float, str], ...]) -> tuple[Item, ...]:
        """Journeys of trains over a line with named places; only 2.x has such timetables."""
        trains = timetable2.timed_trains(self.root) if self._old else []
        return tuple(
            Item(train.id, partial(timetable2.make_journey, self.root, train, places), train.names) for train in trains
        )

    def outline(self) -> tuple[Outline, ...]:
        """The trains of a timetable, by their names, which a line would make journeys of."""
        return tuple(timetable2.outlined(self.root)) if self._old else ()

    def knows(self, kind: Kind, name: str) -> bool:
        """Whether there is a track or train of that id or name."""
        nodes = stock.trains(self.root) if kind == "train" else self._line.tracks(self.root)
        return any(name == _id(node) or name in _names(node) for node in nodes)

    def make_track(self, part: str) -> tuple[Track, dict[str, int]]:
        """Make the track, or the tracks one after the other, that a text means."""
        self.root = self.root.fresh()
        chosen = [self._chosen_way(one) for one in part.split("+")]
        pieces = [self._piece(*one) for one in chosen]
        return join(chosen[0][0], pieces, self._line_speed_kmh)

    def make_train(self, part: str) -> tuple[Train, dict[str, int]]:
        """Make the train that a text means."""
        self.root = self.root.fresh()
        train, (mode, *more) = self._named(part, "train", stock.trains(self.root), 1)
        modes = stock.modes(self.root, train)
        if more or (mode and mode not in modes) or (modes and not mode):
            raise self._choose("train", part, [name for name in self.train_names() if _owner(name) == _id(train)])
        return stock.read_train(self.root, train, mode)

    def _piece(self, track: Node, direction: str, profile: str) -> Piece:
        if self._old:
            return line2.read_piece(self.root, track, direction, profile)
        return line3.read_piece(self.root, track, direction, profile, self._line_speed_kmh)

    def _ways(self, track: Node) -> Iterator[str]:
        """Names of the ways to run over a track, as short as they are unique."""
        directions, profiles = self._line.directions(self.root, track), self._line.profiles(self.root, track)
        for direction in directions:
            for profile in profiles:
                short = len(directions) == 1 and not profile
                yield _id(track) + ("" if short else f":{direction}") + (f":{profile}" if profile else "")

    def _chosen_way(self, part: str) -> tuple[Node, str, str]:
        """Track, direction and profile that one name means."""
        track, words = self._named(part, "track", self._line.tracks(self.root), 2)
        directions, profiles = self._line.directions(self.root, track), self._line.profiles(self.root, track)
        direction = next((word for word in words if word in self._line.DIRECTIONS), "")
        given = [word for word in words if word and word != direction]
        profile = given[0] if given else ("" if "" in profiles else profiles[0])
        ambiguous = (not direction and len(directions) > 1) or (not given and "" not in profiles and len(profiles) > 1)
        if ambiguous or len(given) > 1 or profile not in profiles:
            raise self._choose("track", part, list(self._ways(track)))
        return track, direction or directions[0], profile

    def _named(self, part: str, kind: str, nodes: list[Node], words: int) -> tuple[Node, list[str]]:
        """Element of an id or name, and the words behind it."""
        name, *given = part.split(":")
        # Names are for people: several elements may have one, ids are unique.
        found = [node for node in nodes if _id(node) == name] or [node for node in nodes if name in _names(node)]
        if len(found) > 1:
            listed = ", ".join(_id(node) for node in found[:_MOST_NAMES])
            raise bad(
                self.path, f"holds {len(found)} {kind}s of the name {shown(name)}, choose one by its id: {listed}"
            )
        if found:
            return found[0], [*given, *[""] * (words - len(given))]
        ids = [_id(node) for node in nodes]
        hint = suggestion(name, ids) or f"; it holds: {', '.join(ids[:_MOST_NAMES])}, …"
        raise bad(self.path, f"holds no {kind} {shown(name)}{hint}")

    def _choose(self, kind: str, part: str, names: list[str]) -> InputError:
        listed = ", ".join(names[:_MOST_NAMES]) + (", …" if len(names) > _MOST_NAMES else "")
        return bad(self.path, f"{kind} {shown(part)} can be run in several ways, choose one as FILE#NAME: {listed}")


def _id(node: Node) -> str:
    return node.text("id") or node.text("name") or f"line-{node.line}"


def _names(node: Node) -> list[str]:
    """Names for people: an attribute, or elements of their own, in several languages, from 3.1 on."""
    return [name for one in (node, *node.children("name")) if (name := one.text("name"))]


def _owner(name: str) -> str:
    return name.partition(":")[0]
