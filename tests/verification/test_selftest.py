"""``tgvdp selftest``: every part passes here, and a wrong number fails it."""

import json
from pathlib import Path

import pytest

from tgvdp.cli import main
from tgvdp.verification import closed_forms, references, report
from tgvdp.verification.case import equal

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "verification.md"


@pytest.fixture(scope="module")
def cases():
    return report.verify()


def test_every_part_passes(cases):
    assert [case.name for case in cases if not case.ok] == []
    assert list(report.by_part(cases)) == [
        "closed forms", "order of convergence", "exhaustive small cases", "agreement of methods", "energy balance",
        "survey of random trips",
    ]  # fmt: skip
    assert len(cases) > 50
    assert len({(case.part, case.name) for case in cases}) == len(cases)


def test_reference_optima_pass(shared):
    cases = list(references.cases(shared))
    assert len(cases) > 30
    assert all(case.ok for case in cases)


def test_the_page_is_made_of_all_parts(cases, shared):
    """Numbers are those of the machine that wrote it; the cases are these."""
    text = DOCUMENT.read_text(encoding="utf-8")
    for case in [*cases, *references.cases(shared)]:
        assert f"| {case.name} |" in text
    assert text.startswith(report.PAGE)
    assert "**fails**" not in text


@pytest.fixture
def few(monkeypatch):
    """One part alone, its first case forged on demand."""
    forged = []
    some = list(closed_forms.cases())[:3]
    monkeypatch.setattr(report, "verify", lambda *_: forged + some)
    return forged


def test_json_and_table_say_the_same(few, capsys, tmp_path):
    page = tmp_path / "page.md"
    assert main(["selftest", "--json", "--quiet", "--out", str(page)]) == 0
    content = json.loads(capsys.readouterr().out)
    assert (content["schema"], content["ok"], len(content["cases"])) == ("tgvdp.selftest/1", True, 3)
    assert set(content["cases"][0]) == {
        "part", "name", "found", "expected", "error", "least_digits", "digits", "ok",
    }  # fmt: skip
    assert "| constant forces, with a limit: energy, J | 18 | 18 | 15.0 | 11 | ok |" in page.read_text()
    assert main(["selftest"]) == 0
    assert "3 of 3 cases agree" in capsys.readouterr().out


def test_a_case_that_fails_ends_with_exit_code_1(few, capsys, tmp_path):
    few.append(equal("closed forms", "forged", float("nan"), 1.0, 3.0))
    page = tmp_path / "page.md"
    assert main(["selftest", "--json", "--out", str(page)]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["cases"][0]["found"] is None
    assert "failed: forged: nan, expected 1" in printed.err
    assert "**fails**" in page.read_text()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "optimum.csv: cannot be read: No such file or directory"),
        ("track,variant\n", "holds no rows of variant A"),
        ("variant,from_stop_m\nA,x\n", "line 2: from_stop_m must be a number, got 'x'"),
        ("track,train,from_stop_m,to_stop_m,variant,T_min_s,T_s,E_ref_kWh\na,b,0,1,A,1,1,1\n", "b.json: no such file"),
    ],
)
def test_references_that_cannot_be_read(tmp_path, capsys, text, message):
    if text is not None:
        (tmp_path / "reference").mkdir()
        (tmp_path / "reference" / "optimum.csv").write_text(text)
    with pytest.raises(Exception, match=message):
        list(references.cases(tmp_path))


def test_an_existing_page_is_kept_unless_forced(few, capsys, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("mine")
    assert main(["selftest", "--out", str(page)]) == 3
    assert capsys.readouterr().err == f"tgvdp: error: {page}: exists already (--force overwrites it)\n"
    assert main(["selftest", "--quiet", "--force", "--out", str(page)]) == 0
    assert page.read_text().startswith("# Verification")
