"""Results as one page and as figures for papers."""

import json
import re
import signal
import subprocess
import sys
import urllib.request
from dataclasses import replace

import pytest

from tests.helpers.browser_case import ARGUMENTS, Watched, await_address, executable, figure
from tests.helpers.railml_line_case import LINE_2
from tests.helpers.report_case import make_result, railway_trip
from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.explorer.folder import read_folder
from tgvdp.explorer.standalone import page
from tgvdp.formats import load_bytes, load_track
from tgvdp.report.results import write_results

SEARCH = '"schema": "tgvdp.search/1"'
FIELDS = '"trip": {}, "front": [], "fastest": {}, "line": {}, "energy": {}, "tariff": {}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    home = tmp_path_factory.mktemp("written")
    write_results(make_result(railway_trip(), [38.0, 30.0, 23.0]), home, pictures=())
    return home


def test_one_file_holds_the_page_and_nothing_else_is_fetched(folder, tmp_path):
    sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
    assert main(["report", str(folder), "-o", str(tmp_path / "report.html")]) == 0
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=ARGUMENTS)
        watched = Watched(browser.new_page())
        watched.page.goto(f"file://{tmp_path}/report.html#point=0")
        watched.page.wait_for_selector("#figures dl")
        first = figure(watched.page, "Running time")
        watched.page.locator("#delay").press("End")
        await_address(watched.page, "point=2")
        assert figure(watched.page, "Running time") != first
        assert watched.page.locator("#new-run").is_hidden()
        watched.require_clean("file://")
        browser.close()


def test_nothing_in_a_result_ends_its_element(folder):
    exhibit = read_folder(str(folder))
    evil = exhibit.view.replace(b'"Test train"', b'"</script><script>alert(1)</script>"')
    html = page([replace(exhibit, view=evil)]).decode()
    assert evil != exhibit.view
    assert "<script>alert" not in html
    assert html.count("</script>") == html.count("<script")


@pytest.mark.parametrize(("width", "mm"), [("single", 90.0), ("double", 190.0)])
def test_figures_have_the_width_of_journals_and_hold_their_fonts(folder, tmp_path, width, mm):
    arguments = ["report", str(folder), "-o", str(tmp_path / "a.html"), "--figures", "pdf,svg", "--width", width]
    assert main(arguments) == 0
    names = {"paper_front.pdf", "paper_front.svg", "paper_profile.pdf", "paper_profile.svg", "a.html"}
    assert {file.name for file in tmp_path.iterdir()} == names
    for name in ("paper_front", "paper_profile"):
        pdf = (tmp_path / f"{name}.pdf").read_bytes()
        box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+)", pdf)
        assert float(box[1]) * 25.4 / 72.0 == pytest.approx(mm, abs=0.1)
        assert b"/FontFile2" in pdf
        assert b"/Subtype /Type3" not in pdf
        assert "<text" not in (tmp_path / f"{name}.svg").read_text()


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "holds none of result.json"),
        ({"result.json": "{"}, "is not valid JSON"),
        ({"result.json": "[]"}, "must hold an object"),
        ({"result.json": '{"schema": "tgvdp.search/2"}'}, "schema tgvdp.search/1, got 'tgvdp.search/2'"),
        ({"result.json": f'{{{SEARCH}, "trip": {{}}, "front": [], "fastest": {{}}}}'}, "holds no line"),
        ({"result.json": f"{{{SEARCH}, {FIELDS}}}"}, "holds no provenance"),
        ({"result.json": f'{{{SEARCH}, {FIELDS}, "provenance": {{}}}}'}, "front holds no point"),
        ({"result.json": f'{{{SEARCH}, {FIELDS}, "provenance": {{}}}}'.replace("[]", "[{}]")}, "no such file"),
        ({"journey.json": "{}"}, "schema tgvdp.journey/1, got None"),
        ({"journey.json": '{"schema": "tgvdp.journey/1"}'}, "holds no sections"),
    ],
)
def test_what_is_missing_in_a_folder_is_named(tmp_path, files, words, capsys):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words):
        read_folder(str(tmp_path))
    assert main(["report", str(tmp_path)]) == 3
    assert capsys.readouterr().err.startswith("tgvdp: error: ")


def test_a_broken_row_is_named(folder, tmp_path):
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    text = (tmp_path / "profiles.csv").read_text().splitlines()
    (tmp_path / "profiles.csv").write_text("\n".join([*text[:4], text[4].replace("0.", "x.")]))
    with pytest.raises(InputError, match=r"profiles\.csv: line 5: "):
        read_folder(str(tmp_path))


def test_figures_name_the_run_that_is_missing(folder, tmp_path, capsys):
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    rows = (tmp_path / "profiles.csv").read_text().splitlines(keepends=True)
    (tmp_path / "profiles.csv").write_text("".join(row for row in rows if not row.startswith("fastest")))
    assert main(["report", str(tmp_path), "--figures", "pdf"]) == 3
    assert "holds no rows of run fastest" in capsys.readouterr().err
    assert not (tmp_path / "report.html").exists()


def test_a_folder_has_its_own_name_wherever_one_stands(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert read_folder(".").name == folder.name


def test_explore_says_what_it_cannot_show(tmp_path, capsys):
    assert main(["explore", str(tmp_path / "absent"), "--no-browser"]) == 3
    assert "no such folder" in capsys.readouterr().err
    (tmp_path / "front.csv").touch()
    for command in ("explore", "report"):
        assert main([command, str(tmp_path / "front.csv")]) == 3
        assert "front.csv: is a file, not a folder" in capsys.readouterr().err
    assert main(["explore", "--train", str(tmp_path / "absent.toml"), "--no-browser"]) == 3
    assert "absent.toml: no such file" in capsys.readouterr().err


@pytest.mark.parametrize("force", [(), ("--force",)])
def test_a_page_takes_the_place_of_no_folder(folder, tmp_path, capsys, force):
    assert main(["report", str(folder), "-o", str(tmp_path), *force]) == 3
    assert capsys.readouterr().err == f"tgvdp: error: {tmp_path}: is a folder, not a file\n"


def test_a_page_makes_no_folder_and_figures_are_of_some_format(folder, tmp_path, capsys):
    assert main(["report", str(folder), "-o", str(tmp_path / "none" / "a.html")]) == 3
    assert capsys.readouterr().err.endswith(f"a.html: there is no folder {tmp_path / 'none'}\n")
    assert not list(tmp_path.iterdir())
    assert main(["report", str(folder), "-o", str(tmp_path / "a.html"), "--figures", ""]) == 2
    assert "'--figures': there is none; there are pdf, svg, png" in capsys.readouterr().err


@pytest.fixture
def begun(monkeypatch):
    """What `tgvdp explore` begins with, instead of a server."""
    pytest.importorskip("uvicorn", reason="the explorer needs the extra web")
    found = []
    monkeypatch.setattr(
        "tgvdp.explorer.server.serve.serve", lambda exhibits, asked, files, **_: found.append((asked, files))
    )
    return found


def test_explore_takes_the_part_of_a_file_that_is_named(begun, tmp_path, capsys):
    line = tmp_path / "line.xml"
    line.write_text(LINE_2)
    assert main(["explore", "--no-browser", "--track", f"{line}#t1:down"]) == 0
    ((asked, (file,)),) = begun
    assert (asked.train, file.name) == ("tgv", "line.xml")
    item = int(asked.track.removeprefix("upload:1:"))
    assert load_bytes(file.name, file.data)[item].track == load_track(f"{line}#t1:down")
    assert main(["explore", "--no-browser", "--track", str(line)]) == 3
    assert "t1:up, t1:down" in capsys.readouterr().err


def test_explore_ends_when_it_is_told_to(folder):
    pytest.importorskip("uvicorn", reason="the explorer needs the extra web")
    command = [sys.executable, "-m", "tgvdp", "explore", str(folder), "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as explorer:
        with urllib.request.urlopen(explorer.stdout.readline().split()[0]) as answer:
            assert answer.status == 200
        explorer.send_signal(signal.SIGINT)
        _, errors = explorer.communicate(timeout=60.0)
    assert (explorer.returncode, errors) == (0, "")


def test_a_search_that_was_traced_is_shown_with_its_trace(tmp_path, capsys):
    grid = ["--track", "flat-100km", "--to", "10km", "--segment", "2500", "--speeds", "8", "--paths", "2"]
    quiet = ["--quiet", "--no-certify", "--no-pictures", "--out", str(tmp_path / "out")]
    assert main(["search", "--method", "best-first", *grid, "--trace", *quiet]) == 0
    trace = json.loads(read_folder(str(tmp_path / "out")).view)["trace"]
    assert trace["schema"] == "tgvdp.trace/1"
    assert len(trace["found"]) == 2
    assert main(["search", "--method", "exact", "--trace", *quiet]) == 2
    assert "--trace belongs to method best-first" in capsys.readouterr().err
