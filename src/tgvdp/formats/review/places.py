"""Where a value stands in its file: lines by key path, for JSON, TOML and YAML; railML's readers know their own."""

import re
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any, Literal

from tgvdp.formats.railml import reader as railml
from tgvdp.formats.syntax.reading import Document

#: Keys of tables and indices of lists, from the top of a file.
KeyPath = tuple[str | int, ...]

_TOKEN = re.compile(
    r"""(?P<comment>\#[^\n]*)
      | (?P<text>\"{3}(?:\\.|[^\\])*?\"{3}|'{3}.*?'{3}|"(?:\\.|[^"\\\n])*"|'[^'\n]*')
      | (?P<mark>[][{},=:.\n])
      | (?P<bare>[^\s\[\]{},=:."'\#]+)""",
    re.VERBOSE | re.DOTALL,
)


def lines_of(document: Document) -> dict[KeyPath, int]:
    """Line of every key and list element of a document, from 1."""
    if document.syntax == "YAML":
        return dict(_yaml_lines(document.data))
    scanner = _Scanner(document.data.decode("utf-8-sig"))
    if document.syntax == "JSON":
        scanner.value(())
    else:
        scanner.toml()
    return scanner.lines


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int | None:
    """Line of a key path, or of the nearest one around it."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


class _Scanner:
    """Walks over the tokens of a text that a real parser has accepted, and notes where each key path starts."""

    def __init__(self, text: str) -> None:
        self.lines: dict[KeyPath, int] = {}
        self._tokens = [
            (match.lastgroup, match[0], line)
            for match, line in _with_lines(text, _TOKEN.finditer(text))
            if match.lastgroup != "comment"
        ]
        self._at = 0

    def _peek(self, *, over_lines: bool = True) -> tuple[str | None, str, int]:
        while over_lines and self._at < len(self._tokens) and self._tokens[self._at][1] == "\n":
            self._at += 1
        return self._tokens[self._at] if self._at < len(self._tokens) else (None, "", 0)

    def _take(self, *, over_lines: bool = True) -> tuple[str | None, str, int]:
        token = self._peek(over_lines=over_lines)
        self._at += 1
        return token

    def value(self, path: KeyPath) -> None:
        """Pass over a value of JSON or TOML."""
        _, text, line = self._peek()
        self.lines.setdefault(path, line)
        if text == "{":
            self._take()
            while self._peek()[1] not in ("}", ""):
                self._pair(path)
                self._skip(",")
            self._take()
        elif text == "[":
            self._take()
            index = 0
            while self._peek()[1] not in ("]", ""):
                self.value((*path, index))
                index += 1
                self._skip(",")
            self._take()
        else:
            self._take()
            while self._peek(over_lines=False)[1] not in (",", "]", "}", "\n", ""):
                self._take(over_lines=False)  # the rest of a number, a date

    def toml(self) -> None:
        """Pass over a whole TOML text."""
        table: KeyPath = ()
        counts: dict[KeyPath, int] = {}
        while self._peek()[0] is not None:
            if self._peek()[1] != "[":
                self._pair(table)
                continue
            line = self._take()[2]
            many = self._peek()[1] == "["
            if many:
                self._take()
            table = self._keys("]")
            if many:
                self._take()
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            self.lines.setdefault(table, line)

    def _pair(self, table: KeyPath) -> None:
        line = self._peek()[2]
        path = (*table, *self._keys("=", ":"))
        for length in range(len(table) + 1, len(path) + 1):
            self.lines.setdefault(path[:length], line)
        self.value(path)

    def _keys(self, *ends: str) -> KeyPath:
        """Keys up to a mark, which is passed."""
        keys: list[str] = []
        while True:
            kind, text, _ = self._take()
            if kind is None or text in ends:
                return tuple(keys)
            if text != ".":
                keys.append(_unquoted(text) if kind == "text" else text)

    def _skip(self, mark: str) -> None:
        if self._peek()[1] == mark:
            self._take()


def _with_lines(text: str, matches: Iterator[re.Match[str]]) -> Iterator[tuple[re.Match[str], int]]:
    line, before = 1, 0
    for match in matches:
        line += text.count("\n", before, match.start())
        before = match.start()
        yield match, line


def _unquoted(text: str) -> str:
    """Key of a quoted one; escapes in keys are rare, and one that is not resolved only loses its line."""
    return text[1:-1]


def _yaml_lines(data: bytes) -> Iterator[tuple[KeyPath, int]]:
    """Walk over the nodes of a YAML text; the reader has refused anchors, so that it is a tree."""
    yaml = import_module("yaml")
    todo: list[tuple[Any, KeyPath, int]] = [(yaml.compose(data.decode("utf-8-sig"), Loader=yaml.SafeLoader), (), 1)]
    while todo:
        node, path, line = todo.pop()
        yield path, line
        if isinstance(node, yaml.MappingNode):
            todo += ((value, (*path, str(key.value)), key.start_mark.line + 1) for key, value in node.value)
        elif isinstance(node, yaml.SequenceNode):
            todo += ((one, (*path, index), one.start_mark.line + 1) for index, one in enumerate(node.value))


#: Field of the model → key path, by format; ``None`` stands for the index of a row.
_TRAIN_KEYS: dict[str, dict[str, Sequence[str]]] = {
    "native": {
        "mass_kg": ("train", "mass_t"), "max_speed_mps": ("train", "max_speed_kmh"),
        "length_m": ("train", "length_m"), "rotating_mass_factor": ("train", "rotating_mass_factor"),
        "davis_a_n": ("train", "davis_a_n"), "davis_c_n_per_mps2": ("train", "davis_c_n_per_kmh2"),
        "resistance": ("train", "davis_a_n"), "traction": ("train", "traction"),
        "friction_brake_n": ("train", "friction_brake_kn"), "braking_rates": ("train", "braking_rates"),
        "traction_efficiency": ("train", "traction_efficiency_pct"),
        "regeneration_efficiency": ("train", "regeneration_efficiency_pct"),
        "auxiliary_power_w": ("train", "auxiliary_power_kw"),
    },
    "TTOBench": {
        "mass_kg": ("mass", "value"), "max_speed_mps": ("max speed", "value"), "length_m": ("length", "value"),
        "rotating_mass_factor": ("rho", "value"), "davis_a_n": ("rolling resistance r0", "value"),
        "davis_c_n_per_mps2": ("rolling resistance r2", "value"), "resistance": ("rolling resistance r0", "value"),
        "traction": ("max traction force", "value"), "friction_brake_n": ("max pn braking force", "value"),
        "traction_efficiency": ("efficiency traction", "value"),
        "regeneration_efficiency": ("efficiency reg brake", "value"),
    },
    "OSRD": {
        "mass_kg": ("mass",), "max_speed_mps": ("max_speed",), "length_m": ("length",),
        "rotating_mass_factor": ("inertia_coefficient",), "davis_a_n": ("rolling_resistance", "A"),
        "davis_c_n_per_mps2": ("rolling_resistance", "C"), "resistance": ("rolling_resistance",),
        "traction": ("effort_curves",), "braking_rates": ("const_gamma",),
    },
}  # fmt: skip
_TRACK_KEYS: dict[str, dict[str, Sequence[str]]] = {
    "native": {name: ("track", name) for name in ("length_m", "speed_limits", "gradients", "curves", "tunnels")},
    "TTOBench": {
        "length_m": ("stops", "values"), "speed_limits": ("speed limits", "values"),
        "gradients": ("gradients", "values"), "curves": ("curvatures", "values"), "tunnels": ("tunnels", "values"),
    },
}  # fmt: skip


#: Of a vehicle of railtoolkit; the first one of a formation stands for it.
_VEHICLE_KEYS = {
    "mass_kg": "mass", "max_speed_mps": "speed_limit", "length_m": "length", "rotating_mass_factor": "rotation_mass",
    "davis_a_n": "base_resistance", "davis_c_n_per_mps2": "air_resistance", "resistance": "base_resistance",
    "traction": "tractive_effort", "braking_rates": "a_braking",
}  # fmt: skip


class Places:
    """Lines of the fields of one train or track of a file.

    Parameters
    ----------
    document : Document
    form : str
        Format, as `Scenario` names it.
    kind : {"train", "track"}
    part : str or None
        Which of several things in the file is meant.
    """

    def __init__(self, document: Document, form: str, kind: Literal["train", "track"], part: str | None) -> None:
        xml = document.syntax == "XML"
        self._known = railml.lines_of(document, kind, part) if xml else {}
        self._lines = lines_of(document) if document.tree else {}  # XML and tables have none
        if form == "railtoolkit":
            self._keys: Mapping[str, Sequence[str | int]] = _railtoolkit_keys(document.tree, kind, part)
        else:
            self._keys = (_TRAIN_KEYS if kind == "train" else _TRACK_KEYS).get(form, {})

    def line(self, field: str) -> int | None:
        """Line of a field such as ``mass_kg`` or ``speed_limits[3]``; None where it does not stand in the file."""
        if field in self._known:
            return self._known[field]
        name, _, index = field.partition("[")
        keys = self._keys.get(name)
        if keys is None:
            return None
        return line_of(self._lines, (*keys, *((int(index.rstrip("]")),) if index else ())))


def _railtoolkit_keys(tree: Any, kind: str, part: str | None) -> dict[str, Sequence[str | int]]:
    """Key paths of a train or path of railtoolkit, which stand in lists."""

    def index_of(rows: list[dict[str, Any]], wanted: Any) -> int:
        return next((i for i, row in enumerate(rows) if wanted in (row.get("id"), row.get("name"))), 0)

    if kind == "track":
        sections = ("paths", index_of(tree["paths"], part), "characteristic_sections")
        return dict.fromkeys(("length_m", "speed_limits", "gradients"), sections)
    formation = tree["trains"][index_of(tree["trains"], part)]["formation"]
    vehicle = index_of(tree["vehicles"], formation[0])
    return {field: ("vehicles", vehicle, key) for field, key in _VEHICLE_KEYS.items()}
