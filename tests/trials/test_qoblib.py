"""Submissions to QOBLIB: names, columns, averages, and solutions that the checker accepts."""

import csv
import statistics
import subprocess
import sys

from tgvdp.cli import main
from tgvdp.trials.qoblib import COLUMNS


def test_a_submission_has_the_columns_and_solutions_that_are_asked_for(tmp_path, capsys):
    out, target = tmp_path / "bench", tmp_path / "submission"
    words = ["bench", "easy-n004", "demand-n004", "--solvers", "dp,brute,random:unary:reads=1", "--runs", "3"]
    assert main([*words, "--out", str(out), "--qoblib", str(target), "--submitter", "A. Nonymous", "-q"]) == 0
    capsys.readouterr()
    with (out / "runs.csv").open() as file:
        walls = [float(row["wall_s"]) for row in csv.DictReader(file)
                 if (row["Problem"], row["Workflow"]) == ("easy-n004", "dp")]  # fmt: skip
    home = target / "dp" / "easy-n004"
    with (home / "easy-n004_summary.csv").open(newline="") as file:
        header, values = list(csv.reader(file))
    assert tuple(header) == COLUMNS and len(header) == 27
    row = dict(zip(header, values, strict=True))
    assert row["Submitter"] == "A. Nonymous" and row["GPU Runtime"] == "N/A"
    assert float(row["Total Runtime"]) == statistics.fmean(walls)
    for name in ("easy-n004", "demand-n004"):
        solution = target / "dp" / name / f"{name}_solution.sol"
        checked = [sys.executable, "-I", str(target / "check.py"), str(target / "instances" / f"{name}.json"), solution]
        assert subprocess.run(checked, capture_output=True, check=False).returncode == 0
    assert not (target / "random-unary-reads-1" / "demand-n004").exists()


def test_a_submitter_without_a_submission_is_wrong_usage(tmp_path, capsys):
    assert main(["bench", "easy-n004", "--solvers", "dp", "--out", str(tmp_path / "x"), "--submitter", "A"]) == 2
    assert "--qoblib" in capsys.readouterr().err
