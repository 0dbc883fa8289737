"""The wheel in empty environments, by lowest and newest dependencies: ``python -m tests.versions [PYTHON ...]``.

Of each Python that is named, or found, it makes an environment, installs nothing but the wheel and its dependencies,
searches twice, with kernels that are compiled and then loaded, and lets it verify itself (`tgvdp selftest`). Takes
minutes, four times as many where numba compiles by its own steps, and the registry.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
_ABSENT = "cannot be installed"
_SHORT = ("--track", "flat-100km", "--to", "3000", "--points", "6")
PYTHONS = ("python3.11", "python3.12", "python3.13")


def main(pythons: list[str]) -> int:
    """Try all; exit code 1 where one fails."""
    with tempfile.TemporaryDirectory(prefix="tgvdp-versions-") as folder:
        home = Path(folder)
        run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", home, cwd=ROOT)
        (wheel,) = home.glob("*.whl")
        failed = 0
        for python in pythons or filter(runs, PYTHONS):
            for what, pins in bounds():
                fault = tried(home / f"{Path(python).name}-{what}", python, wheel, pins)
                print(f"{python}, {what} dependencies: {fault or 'ok'}", flush=True)
                failed += bool(fault) and (what, fault) != ("lowest", _ABSENT)  # Pythons may be newer than these
    return min(failed, 1)


def runs(python: str) -> bool:
    """Whether there is a Python of that name: what is found may be no more than a hint to install it."""
    return shutil.which(python) is not None and run(python, "-c", "").returncode == 0


def bounds() -> Iterator[tuple[str, list[str]]]:
    """Requirements that pip is given besides the wheel."""
    dependencies = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    yield "lowest", [requirement.replace(">=", "==") for requirement in dependencies]
    yield "newest", []


def tried(place: Path, python: str, wheel: Path, pins: list[str]) -> str:
    """What fails in a new environment; empty where nothing does."""
    binary = place / "env" / "bin"
    run(python, "-m", "venv", place / "env")
    pip = [binary / "python", "-m", "pip", "--disable-pip-version-check", "install", "-q", "--only-binary", ":all:"]
    if run(*pip, *pins, wheel).returncode:
        return _ABSENT
    variables = {name: text for name, text in os.environ.items() if not name.startswith(("PYTHON", "TGVDP", "MPL"))}
    settings = {"cwd": place, "env": variables | {"HOME": str(place)}}
    for kernels in ("compiled", "loaded"):
        done = run(binary / "tgvdp", "search", *_SHORT, "--out", kernels, **settings)
        if done.returncode:
            return f"a search with {kernels} kernels ends with {done.returncode}: {done.stderr.strip()}"
    done = run(binary / "tgvdp", "selftest", "--json", "--quiet", **settings)
    if done.returncode:
        return done.stderr.strip() or ", ".join(
            case["name"] for case in json.loads(done.stdout)["cases"] if not case["ok"]
        )
    return ""


def run(*command: object, **settings: object) -> "subprocess.CompletedProcess[str]":
    """Run a command and keep what it prints."""
    return subprocess.run([str(word) for word in command], check=False, capture_output=True, text=True, **settings)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
