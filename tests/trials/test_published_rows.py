"""An outsider runs published rows again from their words and finds them within their intervals."""

import csv
import json

import pytest

from benchmarks.timing import ROOT
from tgvdp.cli import main

ROWS = ROOT / "results" / "quantum" / "named" / "benchmark.csv"
#: Problem and start of the word of five rows, of different solvers.
CHOSEN = (
    ("easy-n008", "sa:bits"),
    ("easy-n008", "pt:bits"),
    ("easy-n009", "sa:bits"),
    ("easy-n009", "qaoa:unary:penalty=0.1:angles=ramp:layers=3"),
    ("zones-n040", "sa:unary"),
)


@pytest.mark.slow
@pytest.mark.parametrize(("problem", "start"), CHOSEN)
def test_a_published_row_is_found_again_within_its_interval(tmp_path, capsys, problem, start):
    pytest.importorskip("dwave.samplers")
    with ROWS.open(newline="") as file:
        published = next(
            row for row in csv.DictReader(file) if row["Problem"] == problem and row["Workflow"].startswith(start)
        )
    words = ["bench", problem, "--solvers", published["Workflow"], "--runs", published["# Runs"], "--seed", "1"]
    assert main([*words, "--out", str(tmp_path), "--json", "-q"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    slack = 1e-9  # of exact probabilities, whose interval is a point
    assert float(published["p low"]) - slack <= row["p_success"] <= float(published["p high"]) + slack
    assert 0.0 < row["p_success"] < 1.0
