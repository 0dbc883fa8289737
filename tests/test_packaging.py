"""What a stranger installs: files, metadata, public names."""

import ast
import inspect
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest

import tgvdp

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "tgvdp"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel, built without the network."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=120)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as archive:
        yield archive


def test_wheel_holds_every_source_and_data_file(wheel):
    files = [
        path
        for path in PACKAGE.rglob("*")
        if path.suffix in {".py", ".toml", ".json", ".csv", ".html", ".css", ".js", ".svg"} or path.name == "py.typed"
    ]
    assert {path.relative_to(PACKAGE.parent).as_posix() for path in files} <= set(wheel.namelist())
    assert "tgvdp/py.typed" in wheel.namelist()
    assert "tgvdp/instances/easy-n008.json" in wheel.namelist()
    assert "tgvdp/explorer/page/vendor/uPlot.LICENSE" in wheel.namelist()
    assert any(re.fullmatch(r"tgvdp/model/catalog/\w+/tgv\.toml", name) for name in wheel.namelist())


def test_wheel_metadata(wheel):
    (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = message_from_bytes(wheel.read(name))
    assert metadata["Name"] == "tgvdp"
    assert metadata["Version"] == tgvdp.__version__
    assert metadata["License-Expression"] == "Apache-2.0"
    assert metadata["Requires-Python"] == ">=3.11"
    assert any(name.endswith("/licenses/LICENSE") for name in wheel.namelist())


def test_version_is_the_same_everywhere():
    assert f"\nversion: {tgvdp.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    numbers = re.findall(r"^## \[(\d.+?)\]", (ROOT / "CHANGELOG.md").read_text(), re.M)  # above them: Unreleased
    assert numbers[0] == tgvdp.__version__


def test_licence_is_complete():
    text = (ROOT / "LICENSE").read_text()
    assert "Apache License" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_core_dependencies_are_those_that_are_imported():
    declared = {re.match(r"[A-Za-z0-9_-]+", line)[0].replace("-", "_") for line in PROJECT["dependencies"]}
    imported = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(str(node.module).partition(".")[0])
    foreign = {name for name in imported if name not in sys.stdlib_module_names and name != "tgvdp"}
    assert declared <= foreign


def test_ci_gets_a_browser_calls_make_test_and_does_nothing_cleverer():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert os.access(ROOT / ".ci" / "browser", os.X_OK)
    lines = ["set -euo pipefail", 'cd "$(dirname "$0")/.."', ".ci/browser", "make test"]
    assert script.read_text().splitlines()[1:] == lines


def test_public_names_resolve_and_are_listed():
    for name in tgvdp.__all__:
        assert getattr(tgvdp, name) is not None
    assert set(tgvdp.__all__) <= set(dir(tgvdp))


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = tgvdp.no_such_name


def test_search_is_the_function():
    assert inspect.isfunction(tgvdp.search)
    assert "points" in inspect.signature(tgvdp.search).parameters
