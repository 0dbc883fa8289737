"""Lines of values, in all syntaxes, are those that a reader of the file sees."""

import json
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tgvdp.errors import InputError
from tgvdp.formats.native.write import SYNTAXES
from tgvdp.formats.review.places import line_of, lines_of
from tgvdp.formats.syntax.reading import parse_document

TOML = '''# a comment with [brackets] and = signs
name = "a # no comment"

[train]
mass_t = 200
"quoted key" = 'literal = [ # '
traction = { force_kn = 1.5, power_kw = 4_000 }   # inline
notes = [
    "one",   # the first
    """two
    lines""", "three",
]
a.b.c = 2020-01-01 07:32:00

[track]
speed_limits = [ { from_m = 0 },
  { from_m = 1 } ]

[[rows]]
x = 1
[[rows]]
x = -1.5e3
[rows.deep]
y = true
[p.q]
"a b". d = 1.5
'''

YAML = """%YAML 1.2
---
# a comment
trains:
  - name: x
    formation: [a, b]
vehicles:	# a tab
  - id:	a
    rows:
      - [0.0, 1]
      - [1.0,
         2]
  - id: b
"""


def lines(path, text):
    return lines_of(parse_document(path, text.encode()))


@pytest.mark.parametrize(
    ("key_path", "line"),
    [
        (("name",), 2), (("train",), 4), (("train", "mass_t"), 5), (("train", "quoted key"), 6),
        (("train", "traction", "power_kw"), 7), (("train", "notes"), 8), (("train", "notes", 0), 9),
        (("train", "notes", 1), 10), (("train", "notes", 2), 11), (("train", "a", "b", "c"), 13),
        (("track", "speed_limits", 0, "from_m"), 16), (("track", "speed_limits", 1), 17),
        (("rows", 0, "x"), 20), (("rows", 1, "x"), 22), (("rows", 1, "deep", "y"), 24), (("p",), 25),
        (("p", "q", "a b", "d"), 26), (("train", "mass_t", "unit"), 5), (("nothing",), None),
    ],
)  # fmt: skip
def test_toml(tmp_path, key_path, line):
    assert line_of(lines(tmp_path / "a.toml", TOML), key_path) == line


@pytest.mark.parametrize(
    ("key_path", "line"),
    [(("trains",), 4), (("trains", 0, "name"), 5), (("trains", 0, "formation", 1), 6), (("vehicles", 0, "id"), 8),
     (("vehicles", 0, "rows", 1), 11), (("vehicles", 0, "rows", 1, 1), 12), (("vehicles", 1), 13)],
)  # fmt: skip
def test_yaml(tmp_path, key_path, line):
    pytest.importorskip("ruamel.yaml")
    assert line_of(lines(tmp_path / "a.yaml", YAML), key_path) == line


def places_of(tree, at=()):
    below = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for step, child in below:
        yield (*at, step)
        yield from places_of(child, (*at, step))


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("abc[]{},=:# ", max_size=4), inner, max_size=3),
    max_leaves=12,
)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(st.text("abc[]{},=:# ", max_size=4), VALUES, max_size=4), st.sampled_from([None, 0, 2]))
def test_every_place_of_any_json_is_found_and_lines_do_not_decrease(tree, indent):
    text = json.dumps(tree, indent=indent)
    found = lines(Path("a.json"), text)
    places = list(places_of(tree))
    assert set(places) <= set(found)
    order = [found[place] for place in places]
    assert order == sorted(order)
    assert all(1 <= line <= text.count("\n") + 1 for line in order)
    if indent is not None:
        rows = text.splitlines()
        for place in places:
            if isinstance(place[-1], str):
                assert json.dumps(place[-1]) in rows[found[place] - 1]


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.dictionaries(
        st.text("abc[]{},=:# .", max_size=4), VALUES.filter(lambda tree: "None" not in repr(tree)), max_size=4
    )
)
def test_every_place_of_any_toml_is_found(tree):
    tree["x"] = 1
    text = SYNTAXES["toml"](tree)
    assert set(places_of(tree)) <= set(lines(Path("a.toml"), text))


def test_a_file_of_many_levels_is_refused_before_its_lines_are_looked_for(tmp_path):
    deep = '{"metadata": {"id": "x"}, "stops": ' + "[" * 200 + "]" * 200 + "}"
    with pytest.raises(InputError, match="is nested too deeply"):
        lines(tmp_path / "a.json", deep)


def test_what_is_written_is_found_again(tmp_path):
    tree = {"name": "x", "train": {"mass_t": 1, "traction": {"points": [{"speed_kmh": 0}, {"speed_kmh": 9}]}}}
    text = SYNTAXES["toml"](tree)
    assert tomllib.loads(text) == tree
    found = lines(tmp_path / "a.toml", text)
    assert "speed_kmh = 9" in text.splitlines()[found["train", "traction", "points", 1] - 1]
