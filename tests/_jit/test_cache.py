"""The kernel cache: fresh after every change, whole or rebuilt, and never the reason why a program fails."""

import os
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tgvdp import _jit, errors
from tgvdp._jit import cache as kernel_cache
from tgvdp._jit.steps import shortened

PROGRAM = """
from tgvdp._jit import kernel
from tgvdp.helper import offset

@kernel
def shifted(x):
    return x + offset(x)

print(shifted(1.0))
stats = getattr(shifted, "stats", None)
print(sum(stats.cache_hits.values()) if stats else "python")
"""
HELPER = """
from tgvdp._jit import kernel

@kernel
def offset(x):
    return 41.0
"""


@pytest.fixture
def program(tmp_path):
    """Runs a package of two modules around a copy of ``_jit``; returns the words it printed and its stderr."""
    package = tmp_path / "tgvdp"
    package.mkdir()
    shutil.copytree(Path(_jit.__file__).parent, package / "_jit", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(errors.__file__, package)
    (package / "__init__.py").touch()
    (package / "program.py").write_text(PROGRAM)
    (package / "helper.py").write_text(HELPER)

    def run(cache: Path = tmp_path / "cache", **variables: str) -> tuple[list[str], str]:
        environment = {name: text for name, text in os.environ.items() if not name.startswith("NUMBA_")}
        environment |= {kernel_cache.CACHE_DIR_VARIABLE: str(cache), **variables}
        command = [sys.executable, "-m", "tgvdp.program"]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.split(), done.stderr

    run.cache = tmp_path / "cache"
    run.helper = package / "helper.py"
    run.source = package / "program.py"
    return run


def entries(cache: Path, suffix: str) -> list[Path]:
    return sorted(cache.rglob(f"*{suffix}"))


@pytest.mark.parametrize("mode", [{}, {"NUMBA_DISABLE_JIT": "1"}])
def test_arrays_made_in_kernels_come_from_the_cache_too(program, mode):
    program.source.write_text("""
import numpy as np
from tgvdp._jit import allocating, kernel

@kernel
def fill(row, x):
    row[:] = x

@allocating
def table(n, x):
    made = np.zeros((n, n))
    for row in made:
        fill(row, x)
    return made

print(table(3, 2.0).sum())
""")
    assert [program(**mode)[0] for _ in range(2)] == [["18.0"], ["18.0"]]


@pytest.mark.skipif(not shortened(), reason="numba's own steps load the runtime with every kernel")
def test_kernels_that_count_references_after_all_are_loaded_with_the_runtime(program):
    """Numba compiles what both of them need, the text of an error, once: as the first one asks, with references."""
    program.source.write_text("""
import os
import numpy as np
from tgvdp._jit import allocating, kernel

@allocating
def table(n):
    made = np.zeros((n, 2))
    made[0] = (1.0, 2.0)
    return made

@kernel
def fill(rows):
    rows[0] = (1.0, 2.0)
    return rows[0, 0]

if "FIRST" in os.environ:
    table(3)
try:
    fill(np.zeros((1, 3)))
except ValueError as error:
    print(str(error).partition(" of ")[0].replace(" ", "_"), sum(fill.stats.cache_hits.values()))
""")
    assert program(FIRST="allocating")[0] == ["cannot_assign_slice", "0"]
    (counting,) = [path for path in entries(program.cache, ".nbc") if "fill" in path.name]
    assert b"NRT_" in counting.read_bytes()
    assert program()[0] == ["cannot_assign_slice", "1"]


def test_second_process_loads_what_the_first_compiled(program):
    assert program() == (["42.0", "0"], "")
    assert program() == (["42.0", "1"], "")


def test_change_in_another_module_is_seen(program):
    program()
    program.helper.write_text(HELPER.replace("41.0", "6.0"))
    assert program() == (["7.0", "0"], "")


@pytest.mark.parametrize(
    ("suffix", "damage"),
    [(".nbi", "truncated"), (".nbi", "emptied"), (".nbc", "truncated"), (".nbc", "bit flipped"), (".nbc", "altered")],
)
def test_damaged_entry_is_replaced(program, suffix, damage):
    program()
    damaged = entries(program.cache, suffix)
    assert len(damaged) == 1  # what kernels call is part of them
    for path in damaged:
        content = path.read_bytes()
        half = len(content) // 2
        if damage == "truncated":
            content = content[:half]
        elif damage == "emptied":
            content = b""
        elif damage == "bit flipped":
            content = content[:half] + bytes([content[half] ^ 0x10]) + content[half + 1 :]
        else:  # a whole pickle of sound machine code with another constant in it
            content = content.replace(struct.pack("<d", 41.0), struct.pack("<d", 6.0))
        path.write_bytes(content)
    lines, errors = program()
    assert (lines[0], errors) == ("42.0", "")
    assert program() == (["42.0", "1"], "")


def test_vanished_entry_is_replaced(program):
    program()
    for path in entries(program.cache, ".nbc"):
        path.unlink()
    assert program() == (["42.0", "0"], "")
    assert program() == (["42.0", "1"], "")


def test_unwritable_cache_warns_once_and_goes_on(program, tmp_path):
    (tmp_path / "file").write_text("a cache folder cannot be made below a file")
    lines, errors = program(cache=tmp_path / "file" / "cache")
    assert lines == ["42.0", "0"]
    assert errors.count("RuntimeWarning") == 1
    assert kernel_cache.CACHE_DIR_VARIABLE in errors


def test_no_home_folder_warns_and_goes_on(program):
    if sys.platform == "win32":
        pytest.skip("on Windows the cache folder does not derive from HOME")
    lines, errors = program(TGVDP_CACHE_DIR="", XDG_CACHE_HOME="", HOME="nowhere")
    assert lines == ["42.0", "0"]
    assert errors.count("RuntimeWarning") == 1


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="folders have no owner here")
def test_cache_that_others_could_have_written_is_neither_read_nor_filled(program, tmp_path):
    assert program() == (["42.0", "0"], "")
    (folder,) = (tmp_path / "cache").iterdir()
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o770)
    words, stderr = program()
    assert words == ["42.0", "0"]
    assert stderr.count("can be written by others") == 1
    folder.chmod(0o700)
    assert program() == (["42.0", "1"], "")
    if os.geteuid() == 0:
        os.chown(folder, 12345, 12345)
        words, stderr = program()
        assert words == ["42.0", "0"]
        assert stderr.count("belongs to another user") == 1


def test_modes_of_numba_do_not_share_a_cache(program):
    program()
    assert program(NUMBA_BOUNDSCHECK="1") == (["42.0", "0"], "")
    assert program(NUMBA_BOUNDSCHECK="1") == (["42.0", "1"], "")
    assert program() == (["42.0", "1"], "")
    assert len(list(program.cache.iterdir())) == 2


def test_steps_of_compilation_do_not_share_a_cache(program):
    program(TGVDP_PIPELINE="short")
    assert program(TGVDP_PIPELINE="plain") == (["42.0", "0"], "")
    assert program(TGVDP_PIPELINE="plain") == (["42.0", "1"], "")
    assert len(list(program.cache.iterdir())) == 2


def test_without_jit_kernels_are_python_and_nothing_is_cached(program):
    assert program(NUMBA_DISABLE_JIT="1") == (["42.0", "python"], "")
    assert not program.cache.exists()


def test_cache_settings_of_other_numba_users_are_untouched(program, tmp_path):
    other = tmp_path / "other"
    program(NUMBA_CACHE_DIR=str(other))
    assert not other.exists()
    assert entries(program.cache, ".nbc")


def test_filled_cache_may_be_read_only(program):
    program()
    for folder in (program.cache, *program.cache.rglob("*")):
        folder.chmod(0o555)
    try:
        assert program() == (["42.0", "1"], "")
    finally:
        for folder in (program.cache, *program.cache.rglob("*")):
            folder.chmod(0o755)


@pytest.mark.nojit
def test_key_follows_every_source_that_kernels_may_use(tmp_path):
    (tmp_path / "room").mkdir()
    (tmp_path / "a.py").write_text("x = 1\n")
    (tmp_path / "room" / "b.py").write_text("y = 1\n")
    first = kernel_cache.cache_key(tmp_path)
    assert kernel_cache.cache_key(tmp_path) == first
    (tmp_path / "room" / "b.py").write_text("y = 2\n")
    second = kernel_cache.cache_key(tmp_path)
    (tmp_path / "room" / "b.py").rename(tmp_path / "room" / "c.py")
    third = kernel_cache.cache_key(tmp_path)
    assert len({first, second, third}) == 3
    (tmp_path / "note.txt").write_text("no source")
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "a.py").write_text("no source")
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "a.py").write_text("no kernel")
    assert kernel_cache.cache_key(tmp_path) == third


@pytest.mark.nojit
def test_moving_text_between_files_changes_the_key(tmp_path):
    for name, (a, b) in {"one": ("x = 1\n", ""), "two": ("", "x = 1\n")}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.py").write_text(a)
        (tmp_path / name / "b.py").write_text(b)
    assert kernel_cache.sources_digest(tmp_path / "one") != kernel_cache.sources_digest(tmp_path / "two")


def test_hashing_the_sources_is_quick():
    durations_s = []
    for _ in range(9):
        start_s = time.perf_counter()
        kernel_cache.cache_key(kernel_cache.PACKAGE)
        durations_s.append(time.perf_counter() - start_s)
    print(f"hashing the sources: {1e3 * sorted(durations_s)[4]:.2f} ms")


def test_old_key_folders_make_room(tmp_path):
    keys = [f"{number:032x}" for number in range(5)]
    for age, key in enumerate(keys):
        (tmp_path / key).mkdir()
        os.utime(tmp_path / key, (1e9 - age, 1e9 - age))
    (tmp_path / "notes").mkdir()
    os.utime(tmp_path / "notes", (1e8, 1e8))
    kernel_cache.remove_old_folders(tmp_path, kept=2)
    assert {path.name for path in tmp_path.iterdir()} == {*keys[:2], "notes"}


@pytest.mark.parametrize(
    ("platform", "variables", "expected"),
    [
        ("linux", {"XDG_CACHE_HOME": "/elsewhere"}, "/elsewhere/tgvdp"),
        ("linux", {"XDG_CACHE_HOME": "relative"}, "/home/me/.cache/tgvdp"),
        ("linux", {}, "/home/me/.cache/tgvdp"),
        ("darwin", {"XDG_CACHE_HOME": "/elsewhere"}, "/home/me/Library/Caches/tgvdp"),
        ("darwin", {"TGVDP_CACHE_DIR": "/mine"}, "/mine"),
        ("win32", {"LOCALAPPDATA": "/local"}, "/local/tgvdp"),
    ],
)
def test_cache_root(monkeypatch, platform, variables, expected):
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA", kernel_cache.CACHE_DIR_VARIABLE):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"HOME": "/home/me", **variables}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "platform", platform)
    assert kernel_cache.cache_root() == Path(expected)
