"""The page of the quantum benchmark states what the published rows say, and nothing else."""

import pytest

from benchmarks.output import replace_between
from benchmarks.quantum import PAGE
from benchmarks.quantum_claims import BEGIN, END, claims
from benchmarks.quantum_penalties import penalty_rows
from benchmarks.timing import ROOT
from tgvdp.report.plain import csv_text

RESULTS = ROOT / "results" / "quantum"


def test_the_page_states_what_the_rows_say(tmp_path):
    copy = tmp_path / "page.md"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    replace_between(copy, BEGIN, END, claims(RESULTS))
    assert copy.read_text(encoding="utf-8") == PAGE.read_text(encoding="utf-8")


def test_the_penalties_are_what_enumeration_says():
    assert (RESULTS / "penalties.csv").read_bytes() == csv_text(penalty_rows())


def test_a_page_without_marks_is_refused(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("nothing", encoding="utf-8")
    with pytest.raises(SystemExit, match="has no lines"):
        replace_between(page, BEGIN, END, "")
