"""A process with all kernels loaded, and children that are forked from it, one per case, within limits."""

import contextlib
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from fuzz.cases import LIMITED, TIME_LIMIT_S, Case

#: What a command with a time limit may take beyond it, in s of processor time.
SLACK_S = 1.0
#: Processor time after which a child is ended, s, and wall time, which only who waits for something reaches.
_ENDED_CPU_S, _ENDED_WALL_S = 12, 600
_MOST_MEMORY_B = 1 << 30
#: Address space that a child may ask for beyond what it starts with, B.
_MORE_ADDRESSES_B = 3 << 30
#: Exit code of a child that an exception ended.
_TRACEBACK = 99
_KNOWN_CODES = (0, 2, 3, 4, 5)


class Outcome(NamedTuple):
    """How a case ended.

    Attributes
    ----------
    code : int
        Exit code; negative is a signal.
    fault : str
        What is wrong with that, in a word or two; empty where nothing is.
    text : str
        What the child printed on stderr.
    cpu_s, memory_b : float, int
        Processor time, and most memory.
    """

    case: Case
    code: int
    fault: str
    text: str
    cpu_s: float
    memory_b: int


def warmed() -> None:
    """Load or compile all kernels, so that no child has to."""
    from tgvdp.api.warm import TOURS, checks, tour

    checks()
    for name in TOURS:
        tour(name)
    from tgvdp.cli import bench, compare, formulate, journey, score, search, solve, validate  # noqa: F401  (as commands do)


def run(cases: Iterable[Case], processes: int = 1) -> Iterator[Outcome]:
    """Outcomes of cases, in the order in which they end."""
    running: dict[int, tuple[Case, Path]] = {}
    root = Path(tempfile.mkdtemp(prefix="tgvdp-fuzz-"))
    try:
        for number, case in enumerate(cases):
            folder = root / str(number)
            folder.mkdir()
            running[_forked(case, folder)] = case, folder
            if len(running) >= processes:
                yield _ended(running)
        while running:
            yield _ended(running)
    finally:
        for pid in running:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        shutil.rmtree(root, ignore_errors=True)


def _ended(running: dict[int, tuple[Case, Path]]) -> Outcome:
    pid, status, used = os.wait4(-1, 0)
    case, folder = running.pop(pid)
    text = (folder / "stderr").read_text(encoding="utf-8", errors="replace")
    code, cpu_s, memory_b = os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss * 1024
    is_limited = LIMITED[0] in case.commands[-1]
    outcome = Outcome(case, code, _fault(code, text, cpu_s, memory_b, folder, is_limited), text, cpu_s, memory_b)
    shutil.rmtree(folder, ignore_errors=True)
    return outcome


def _fault(code: int, text: str, cpu_s: float, memory_b: int, folder: Path, is_limited: bool) -> str:
    if code in (-signal.SIGXCPU, -signal.SIGALRM):
        return "hang"
    if code < 0:
        return f"signal {-code}"
    if code == _TRACEBACK:
        return "traceback"
    if code not in _KNOWN_CODES:
        return f"exit code {code}"
    errors = [line for line in text.splitlines() if not line.startswith(("tgvdp: note: ", "tgvdp: warning: "))]
    if len(errors) > 1 or not all(line.startswith("tgvdp: ") for line in errors):
        return "not one line"
    if any(word in file.read_bytes() for file in folder.glob("*/*.csv") for word in (b"nan", b"inf")):
        return "not a number in a file"
    if is_limited and cpu_s > TIME_LIMIT_S + SLACK_S:
        return "beyond its time"
    return "memory" if memory_b > _MOST_MEMORY_B else ""


def _forked(case: Case, folder: Path) -> int:
    pid = os.fork()
    if pid:
        return pid
    code = _TRACEBACK
    try:
        _confine(folder)
        (folder / case.file).write_bytes(case.content)
        code = _command(case)
    except BaseException:
        with contextlib.suppress(Exception):
            traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stderr.flush()
        os._exit(code)


def _confine(folder: Path) -> None:
    """Give a child its own folder, output and limits; the default actions of signals end it."""
    os.chdir(folder)
    output = os.open("stderr", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(output, 2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + _MORE_ADDRESSES_B
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    used = int(time.process_time()) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (used + _ENDED_CPU_S, used + 2 * _ENDED_CPU_S))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(_ENDED_WALL_S)
    time.perf_counter = time.process_time  # its clock is the one that it is judged by, however busy the machine is


def _command(case: Case) -> int:
    """Run one command after the other, while they succeed; numpy's own warnings are errors here, with a place."""
    from tgvdp import cli

    warnings.simplefilter("error")
    code = 0
    for arguments in case.commands:
        code = code or cli.main(list(arguments))
    return code
