"""Files that cannot be read, are no JSON, TOML or YAML, or hold what no format may hold: one line of error each."""

import gzip
import os

import pytest

from tgvdp.errors import InputError
from tgvdp.formats import describe_file, input_digest, load_scenario, load_track, load_train
from tgvdp.formats.syntax.reading import LARGEST_BYTES

EVERY_READER = [load_train, load_track, load_scenario, describe_file]


@pytest.fixture(params=EVERY_READER, ids=lambda reader: reader.__name__)
def refused(request):
    """Function that asserts that a file is refused in one line that starts with its path, and returns the line."""

    def check(path):
        with pytest.raises(InputError) as caught:
            request.param(path)
        line = str(caught.value)
        assert line.startswith(f"{path}: ")
        assert line.isprintable()
        assert caught.value.exit_code == 3
        return line.removeprefix(f"{path}: ")

    return check


def test_missing_file(refused, tmp_path):
    assert refused(tmp_path / "absent.json") == "no such file"


def test_folder(refused, tmp_path):
    assert refused(tmp_path) == "is a folder, not a file"


def test_file_without_permission(refused, tmp_path):
    path = tmp_path / "secret.toml"
    path.write_text("[train]")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read every file")
    assert refused(path) == "cannot be read: Permission denied"


def test_permission_is_reported_by_its_reason(refused, tmp_path, monkeypatch):
    path = tmp_path / "secret.toml"
    path.write_text("[train]")
    monkeypatch.setattr("pathlib.Path.read_bytes", lambda self: (_ for _ in ()).throw(PermissionError(13, "denied")))
    assert refused(path) == "cannot be read: denied"


def test_endless_and_special_files(refused, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert refused(pipe) == "is not a regular file"


def test_file_as_folder_and_name_too_long(refused, tmp_path):
    (tmp_path / "file").write_text("x")
    assert refused(tmp_path / "file" / "below.json").startswith("cannot be read: ")
    assert refused(tmp_path / ("x" * 5000)).startswith("cannot be read: ")


def test_too_large(refused, tmp_path):
    path = tmp_path / "large.json"
    with path.open("wb") as file:
        file.truncate(LARGEST_BYTES + 1)
    assert refused(path) == "is larger than 20 MB, got 20.0 MB"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"[train]\nname = '\xff'", "is not UTF-8 text (byte 16)"),
        (b"<?xml version='1.0'?>", "line 1: is not well-formed XML: "),
        (b"{", "is not valid JSON: Expecting property name enclosed in double quotes: line 1 column 2 (char 1)"),
        (b'{"mass": NaN, "rho": 1}', "mass must be finite, got nan"),
        (b'{"mass": [1, {"x": Infinity}]}', "mass[1].x must be finite, got inf"),
        (b'{"stops": {"values": [0, 1e999]}}', "stops.values[1] must be finite, got inf"),
        (b"track.length_m = nan", "track.length_m must be finite, got nan"),
        (b"track.length_m = -inf", "track.length_m must be finite, got -inf"),
        (b"x = 1" + 400 * b"0", "x must be finite, got an integer of 401 digits"),
        (b'{"mass": 1' + 5000 * b"0" + b"}", "Exceeds the limit"),
        (b'{"mass": 1, "rho": 2, "mass": 3}', "field 'mass' is given twice"),
        (b'{"train": {"mass_t": 1, "mass_t": 3}}', "field 'mass_t' is given twice"),
        (b"[track]\nlength_m = 1\nlength_m = 2", "is not valid TOML, and neither JSON, YAML nor XML: Cannot"),
        (b"just some words\n", "is not valid TOML, and neither JSON, YAML nor XML: "),
        (b"[" * 100_000, "is n"),  # TOML: too deep, or no table
        (b'{"a":' * 100_000, "is nested too deeply"),
        (b"x = " + b"[" * 100_000, "is nested too deeply"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_content_that_no_format_has(refused, tmp_path, content, message):
    path = tmp_path / "input"
    path.write_bytes(content)
    assert refused(path).startswith(message)


def test_json_that_is_no_object(refused, tmp_path):
    path = tmp_path / "list.json"
    path.write_text("[1, 2]")
    assert refused(path) == "must hold one table of named fields, got [1, 2]"


def test_unprintable_paths_and_values_stay_on_one_line(tmp_path):
    with pytest.raises(InputError) as caught:
        load_train(tmp_path / "two\nlines\x1b[31m.json")
    assert str(caught.value).isprintable()
    with pytest.raises(InputError) as caught:
        load_train("null\0byte.json")
    assert str(caught.value).isprintable()


def test_byte_order_mark_is_accepted(tmp_path):
    path = tmp_path / "bom.toml"
    path.write_bytes(b"\xef\xbb\xbf[track]\nlength_m = 5\nspeed_limits = [{ from_m = 0, speed_kmh = 9 }]")
    assert load_track(path).length_m == 5.0


def test_digest_is_the_sha256_of_the_bytes(tmp_path):
    path = tmp_path / "abc"
    path.write_bytes(b"abc")
    assert input_digest(path) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    with pytest.raises(InputError, match="no such file"):
        input_digest(tmp_path / "absent")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('{"train": "\\ud800"}', "train"),
        ('{"map": {"notes": ["x", "\\udfff"]}}', "map.notes[1]"),
        ('{"train": "tgv", "run": {"\\udc00": 1}}', "run.\\udc00"),
        ('train: "\\ud800"', "train"),
    ],
)
def test_half_of_a_character_is_refused_with_its_field(refused, tmp_path, text, place):
    path = tmp_path / "input"
    path.write_text(text)
    assert refused(path).startswith(f"{place}: holds half of a character, got '")


@pytest.mark.parametrize("name", ["book.xls", "book.csv"])
def test_workbooks_of_old_excel_are_told_by_their_first_bytes(refused, tmp_path, name):
    (tmp_path / name).write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(500))
    assert refused(tmp_path / name) == "is a workbook of old Excel (.xls), which is not read: save it as .xlsx"


@pytest.mark.parametrize("name", ["line.csv", "line.csv.gz", "line.json.gz"])
def test_what_is_compressed_is_told_by_its_first_bytes(refused, tmp_path, name):
    """Of a table it was "neither UTF-8, UTF-16 nor Windows-1252"."""
    path = tmp_path / name
    path.write_bytes(gzip.compress(b"km,limit_kmh\n0,80\n5,80\n"))
    assert "is compressed by gzip, which is not read: unpack it" in refused(path)
