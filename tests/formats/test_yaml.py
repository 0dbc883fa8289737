"""YAML as railtoolkit declares it, 1.2: what its traps in 1.1 become, and what bombs do."""

import time
from itertools import pairwise

import pytest

from tgvdp.errors import InputError, MissingExtraError
from tgvdp.formats import describe_file
from tgvdp.formats.syntax.reading import read_document
from tgvdp.formats.syntax.yaml import DEEPEST, MOST_SEPARATORS, parse_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"),
        ("yes", "yes"),
        ("on", "on"),
        ("true", True),
        ("False", False),
        ("tRUE", "tRUE"),
        ("~", None),
        ("null", None),
        ("", None),
        ("'null'", "null"),
        ("1e3", 1000.0),
        ("1E-3", 0.001),
        (".5", 0.5),
        ("5.", 5.0),
        ("-12", -12),
        ("'12'", "12"),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("2022.05", 2022.05),
        ("2024-07-01", "2024-07-01"),
        ("[1, [a, b], {c: 2}]", [1, ["a", "b"], {"c": 2}]),
        ("\t[1,\t2]\t# tabs", [1, 2]),
        ("# only\n  - 1 # a comment\n  - 2", [1, 2]),
        ("|\n  two\n  lines", "two\nlines\n"),
    ],
)
def test_scalars_follow_the_core_schema_of_yaml_1_2(text, value):
    got = parse_yaml(f"%YAML 1.2\n---\nfield: {text}\n" if "\n" not in text else f"field: {text}\n")[0]["field"]
    assert got == value
    assert type(got) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 010", "010 differs between YAML 1.1 and 1.2: write a plain decimal number in line 1"),
        ("a: 0x1F", "0x1F differs between YAML 1.1 and 1.2"),
        ("a: 0o17", "0o17 differs between"),
        ("a: 1\nb: 2\na: 3", "field 'a' is given twice in line 3"),
        ("a: &x [1]\nb: *x", "YAML anchors and aliases are not read, got 'x' in line 1"),
        ("b: *x", "YAML anchors and aliases are not read, got 'x' in line 1"),
        ("a: !!float 3", "YAML tags are not read, got 'tag:yaml.org,2002:float' in line 1"),
        ("a: !!python/object/apply:os.system ['true']", "YAML tags are not read"),
        ("a: 1\n---\nb: 2", "must hold one YAML document, another one starts in line 2"),
        ("? [1, 2]\n: 3", "names of fields must be text in line 1"),
        ("%YAML 1.3\n---\na: 1", "is not valid YAML: version"),
        ("%YAML 2.0\n---\na: 1", "is not valid YAML: found incompatible YAML document"),
        ("a: [1, 2", "is not valid YAML: "),
        ("a: 'open", "is not valid YAML: "),
        ("a: \x07", "is not valid YAML: "),
        ("a:\n\tb: 2", "is not valid YAML: found character '\\t' that cannot start any token in line 2"),
        ("&x a: 1", "YAML anchors and aliases are not read, got 'x' in line 1"),
        ("!!str a: 1", "YAML tags are not read, got 'tag:yaml.org,2002:str' in line 1"),
        ("a: 1\n b: 2", "is not valid YAML: "),
    ],
)
def test_what_is_refused(text, message):
    with pytest.raises(InputError) as caught:
        parse_yaml(text)
    assert str(caught.value).startswith(message)


BOMBS = {
    "aliases": "a: &a [x, x]\n" + "".join(f"{c}: &{c} [*{b}, *{b}]\n" for b, c in pairwise("abcdefghi")),
    "flow depth": "a: " + "[" * 100_000,
    "table depth": "a: " + "{a: " * 100_000,
    "block depth": "\n".join(f"{' ' * n}a:" for n in range(2 * DEEPEST)),
    "values": "a: [" + "1," * (2 * MOST_SEPARATORS) + "1]",
    "size": "a: '" + "x" * 3_000_000 + "'",
    "long integer": "a: " + "9" * 100_000,
    "huge float": "a: 1e999",
    "infinity": "a: -.inf",
    "not a number": "a: .NaN",
    "keys": "\n".join(f"k{n}: 1" for n in range(2 * MOST_SEPARATORS)),
    "twice": "vehicles: [1]\nvehicles: [2]",
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_are_refused_in_one_line_at_once(tmp_path, kind):
    path = tmp_path / "bomb.yaml"
    path.write_text(BOMBS[kind])
    started = time.process_time()
    with pytest.raises(InputError) as caught:
        describe_file(path)
    assert time.process_time() - started < 5.0  # what they unfold to takes minutes
    assert str(caught.value).startswith(f"{path}: ")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < len(str(path)) + 200


def test_wild_numbers_are_refused_with_their_field(tmp_path):
    path = tmp_path / "wild.yaml"
    path.write_text("vehicles:\n  - mass: .inf\n")
    with pytest.raises(InputError, match=r"vehicles\[0\].mass must be finite, got inf"):
        read_document(path)


def test_missing_package_is_named_in_one_line(tmp_path, monkeypatch):
    path = tmp_path / "train.yaml"
    path.write_text("vehicles: []\n")
    monkeypatch.setitem(__import__("sys").modules, "ruamel.yaml", None)
    with pytest.raises(MissingExtraError, match=r"needs ruamel.yaml: pip install 'tgvdp\[formats\]'"):
        describe_file(path)


def test_a_native_file_may_be_yaml(tmp_path):
    path = tmp_path / "line"
    path.write_text("track:\n  length_m: 5\n  speed_limits: [{from_m: 0, speed_kmh: 9}]\n")
    assert describe_file(path).kind == "track"
