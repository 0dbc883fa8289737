"""Names of the published instances, wherever an instance is asked for."""

import json
import re
from pathlib import Path

import pytest

from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.instances import FOLDER, find, index


def test_every_name_is_a_file_of_its_own():
    assert {find(name) for name in index()} == set(FOLDER.glob("*.json"))
    assert all(json.loads(find(name).read_bytes())["id"] == name for name in index())


def test_the_pages_say_how_many_there_are():
    root = Path(__file__).resolve().parents[2]
    pages = ("README.md", "docs/formulations.md", "docs/quantum-benchmark.md", "src/tgvdp/instances/__init__.py")
    for page in pages:
        text = (root / page).read_text(encoding="utf-8")
        said = re.findall(r"^(?:.*\. )?(\d+) (?:instances|problems of N|of them are built in)", text, re.MULTILINE)
        assert said == [str(len(index()))], page


def test_a_path_is_a_path_and_a_name_goes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("easy-n004", "mine"):
        (tmp_path / name).write_text("{}")
    assert find("easy-n004") == FOLDER / "easy-n004.json"
    assert find("./easy-n004").resolve() == tmp_path / "easy-n004"
    assert str(find("mine")) == "mine"  # a file without any mark of a path
    assert str(find("absent.json")) == "absent.json"  # whoever opens it says so


@pytest.mark.parametrize(
    ("word", "part"),
    [
        ("easy-n08", "did you mean 'easy-n080' or 'easy-n008'"),
        ("EASY-N008", "did you mean 'easy-n008'"),
        ("turbot", f"unknown instance 'turbot' ({len(index())} are built in: tgvdp catalog lists them"),
        ("", "unknown instance ''"),
    ],
)
def test_unknown_names_are_one_line_with_the_nearest(word, part):
    with pytest.raises(InputError) as caught:
        find(word)
    assert part in str(caught.value) and "\n" not in str(caught.value)


def test_commands_take_names(tmp_path, capsys):
    assert main(["solve", "easy-n004", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["objective"] == 0.7
    assert main(["formulate", "easy-n004", "--to", "lp", "-o", "-"]) == 0
    assert capsys.readouterr().out.startswith("\\ easy-n004\n")
    arguments = ["bench", "easy-n004", "zones-n006", "--solvers", "dp", "--runs", "1", "--json"]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [(row["Problem"], row["optimum from"]) for row in rows] == [
        ("easy-n004", "optima.csv"), ("zones-n006", "optima.csv"),
    ]  # fmt: skip
    for command in (["solve"], ["formulate", "--to", "lp", "-o", "-"], ["bench", "--out", str(tmp_path / "none")]):
        assert main([*command, "easy-n44"]) == 3
        assert "did you mean 'easy-n040'" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
