"""``tgvdp solve --json``: every field is documented."""

import json
from pathlib import Path

import pytest

from tgvdp.cli import main

PAGE = (Path(__file__).parents[2] / "docs" / "solvers.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("words", ["easy-n004", "demand-n004", "substation-k2-n006", "easy-n004 --solver exact-qubo"])
def test_every_field_of_a_solution_is_documented(words, capsys):
    if "qubo" in words:
        pytest.importorskip("dimod")
    assert main(["solve", *words.split(), "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content.pop("schema") == "tgvdp.solve/2"
    replayed, qubo = content["replay"], content.get("qubo", {})
    assert not {"speeds", "distance"} & set(content)  # names carry units
    names = [*content, *content["constraints"][0], *replayed, *replayed.get("fine", {}), *qubo]
    assert [name for name in names if f"`{name}`" not in PAGE] == []
