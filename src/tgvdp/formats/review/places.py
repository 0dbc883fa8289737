"""Where a value stands in its file: lines by key path, for JSON, TOML and YAML; railML's readers know their own."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from tgvdp.formats.railml import reader as railml
from tgvdp.formats.syntax.reading import Document
from tgvdp.formats.syntax.yaml import KeyPath, parse_yaml

_TOKEN = re.compile(
    r"""\#[^\n]*
      | (?P<text>\"{3}(?:\\.|[^\\])*?\"{3}|'{3}.*?'{3}|"(?:\\.|[^"\\\n])*"|'[^'\n]*')
      | (?P<mark>[][{},=:])
      | (?P<bare>[^\s\[\]{},=:"'\#][^\s\[\]{},="'\#]*)""",
    re.VERBOSE | re.DOTALL,
)


class _Token(NamedTuple):
    kind: str
    text: str
    line: int


def lines_of(document: Document) -> dict[KeyPath, int]:
    """Line of every key and list element of a document, from 1."""
    text = document.data.decode("utf-8-sig")
    if document.syntax == "YAML":
        return parse_yaml(text)[1]
    lines: dict[KeyPath, int] = {}
    tokens = [_Token("end", "", 0), *reversed(list(_tokens(text)))]  # taken from the end
    if document.syntax == "JSON":
        _take_value(tokens, (), lines)
    else:
        _take_toml(tokens, lines)
    return lines


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int | None:
    """Line of a key path, or of the nearest one around it."""
    return next((lines[path[:end]] for end in range(len(path), 0, -1) if path[:end] in lines), None)


def _tokens(text: str) -> Iterator[_Token]:
    """Tokens of a text that a real parser has accepted; those of a number or date may be several."""
    line, before = 1, 0
    for match in _TOKEN.finditer(text):
        line += text.count("\n", before, match.start())
        before = match.start()
        if match.lastgroup is not None:
            yield _Token(match.lastgroup, match[0], line)


def _take_toml(tokens: list[_Token], lines: dict[KeyPath, int]) -> None:
    table: KeyPath = ()
    counts: Counter[KeyPath] = Counter()
    while tokens[-1].kind != "end":
        if tokens[-1].text != "[":
            _take_pair(tokens, table, lines)
            continue
        line = tokens.pop().line
        many = tokens[-1].text == "["
        *around, last = _take_keys(tokens, "]")
        table = ()
        for key in around:
            table = (*table, key)
            if table in counts:  # a list of tables: its last one is meant
                table = (*table, counts[table] - 1)
        table = (*table, last)
        if many:
            tokens.pop()
            counts[table] += 1
            table = (*table, counts[table] - 1)
        _note_line(table, 1, line, lines)


def _take_pair(tokens: list[_Token], table: KeyPath, lines: dict[KeyPath, int]) -> None:
    line = tokens[-1].line
    path = (*table, *_take_keys(tokens, "=", ":"))
    _note_line(path, len(table) + 1, line, lines)
    _take_value(tokens, path, lines)


def _note_line(path: KeyPath, shortest: int, line: int, lines: dict[KeyPath, int]) -> None:
    """Note the line of a path and of the tables around it that it opens."""
    for end in range(shortest, len(path) + 1):
        lines.setdefault(path[:end], line)


def _take_keys(tokens: list[_Token], *ends: str) -> KeyPath:
    """Keys up to a mark, which is taken too; an escape in a key is not resolved, so that its line is lost."""
    keys: list[str] = []
    while (token := tokens.pop()).text not in ends:
        if token.kind == "text":
            keys.append(token.text[1:-1])
        elif token.kind == "bare":
            keys += filter(None, token.text.split("."))
    return tuple(keys)


def _take_value(tokens: list[_Token], path: KeyPath, lines: dict[KeyPath, int]) -> None:
    opening = tokens.pop()
    lines.setdefault(path, opening.line)
    closing = {"{": "}", "[": "]"}.get(opening.text)
    index = 0
    while closing and tokens[-1].text != closing:
        if tokens[-1].text == ",":
            tokens.pop()
        elif closing == "}":
            _take_pair(tokens, path, lines)
        else:
            _take_value(tokens, (*path, index), lines)
            index += 1
    if closing:
        tokens.pop()
    while tokens[-1].kind == "bare" and tokens[-1].line == opening.line:
        tokens.pop()  # the time of a date


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
        self._known = railml.lines_of(document, kind, part) if form.startswith(railml.FORMAT) else {}
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
