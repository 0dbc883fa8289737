"""A second Python process for part of the work, on another core; nothing depends on it.

What it is asked for is named ``"module:function"`` and called over there. Where there is no second process, and where
it fails, the same function is called here, later: a failure costs time and nothing else.

The second process ends with the first one, however that ends, since it watches the pipe that its work comes through.
Ctrl-C is the business of the first one alone. It is started from nothing, so that every platform does it alike.
"""

import contextlib
import functools
import itertools
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import IO, Any

from tgvdp.cores import usable_cores

_LENGTH = struct.Struct("<Q")
_BOOT = (
    "import sys; sys.path[:] = {path!r}; from tgvdp import second_process, start;"
    " start.start_fast({needs_scipy!r}); second_process.serve()"
)
#: Loaded only by who draws: then drawing here is quicker than in a process that has to load it first.
_DRAWING = "matplotlib"
#: Processes per core, as the system averages them, from which on a second one of ours would take from others.
_BUSY = 1.5


def is_of_use(draws: bool) -> bool:
    """Whether a second process is any quicker: there is a core, and what it ``draws`` with is still to be loaded."""
    cores = usable_cores()
    idle = not hasattr(os, "getloadavg") or os.getloadavg()[0] < _BUSY * cores
    known = Path(sys.executable or "").name.startswith("python")  # how Python is started: programs that embed it differ
    return cores > 1 and idle and known and not (draws and _DRAWING in sys.modules)


class SecondProcess:
    """A second process as a context: started when it is first asked, where it is of use; gone on exit.

    Parameters
    ----------
    draws : bool
        Whether it will be asked for pictures: where this process is ready to draw them, it is of no use.
    """

    def __init__(self, *, draws: bool = True) -> None:
        self._draws = draws
        self._process: subprocess.Popen[bytes] | None = None
        self._is_wanted = True  # no second one is started in place of one that failed
        self._numbers = itertools.count()
        self._answers: dict[int, tuple[bool, Any, list[Warning]]] = {}
        self._reading = threading.Lock()

    def __enter__(self) -> "SecondProcess":
        return self

    def _start(self) -> None:
        self._is_wanted = False
        if is_of_use(self._draws):
            # A process that does without scipy says so by None in place of the module.
            boot = _BOOT.format(path=sys.path, needs_scipy=sys.modules.get("scipy", ...) is not None)
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
            with contextlib.suppress(OSError):  # no memory, no more processes: this one does the work
                self._process = subprocess.Popen([sys.executable, "-c", boot], **pipes)  # type: ignore[call-overload]

    def __exit__(self, *_: object) -> None:
        """Leave no process behind; what it has not answered yet nobody waits for."""
        self._is_wanted = False
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    @property
    def is_there(self) -> bool:
        """Whether there is one, and it has not failed so far."""
        return self._process is not None

    def load(self, *modules: str) -> None:
        """Have modules imported over there, for what will be asked."""
        self._send((None, modules, ()))

    def promise(self, task: str, *arguments: Any) -> Callable[[], Any]:
        """Have ``"module:function"`` called over there; what is returned waits for its value.

        Arguments and values are pickled. Without a second process, or where it fails, the function is called here when
        somebody waits for its value.
        """
        number = next(self._numbers)
        here = functools.partial(_call, task, arguments)
        return functools.partial(self._wait, number, here) if self._send((number, task, arguments)) else here

    def _send(self, request: Any) -> bool:
        if self._is_wanted:
            self._start()
        if self._process is None:
            return False
        content = pickle.dumps(request)
        try:
            _write(self._process.stdin, content)
        except OSError:  # it is gone
            self.__exit__()
            return False
        return True

    def _wait(self, number: int, here: Callable[[], Any]) -> Any:
        if not self._is_answered(number):
            return here()
        done, value, caught = self._answers.pop(number)
        if not done:
            return here()  # what is wrong shows here
        for message in caught:
            warnings.warn(message, stacklevel=3)
        return value

    def _is_answered(self, number: int) -> bool:
        """Wait for an answer, which another thread may read, as this one may read another's; False if none comes."""
        with self._reading:
            while number not in self._answers:
                content = None if self._process is None else _read(self._process.stdout)
                if content is None:
                    self.__exit__()
                    return False
                answered, answer = pickle.loads(content)
                self._answers[answered] = answer
        return True


def serve() -> None:
    """Be the second process: answer one request after the other, until the first process closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    requests: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests,), daemon=True).start()
    while True:
        number, task, arguments = pickle.loads(requests.get())
        if number is None:
            for module in task:
                import_module(module)
            continue
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("default")
            try:
                done, value = True, _call(task, arguments)
            except Exception:
                done, value = False, None
        _write(answers, pickle.dumps((number, (done, value, [one.message for one in caught]))))


def _listen(requests: "queue.SimpleQueue[bytes]") -> None:
    while (content := _read(sys.stdin.buffer)) is not None:
        requests.put(content)
    os._exit(0)  # whatever is being done: nobody wants it any more


def _call(task: str, arguments: tuple[Any, ...]) -> Any:
    module, _, name = task.partition(":")
    return getattr(import_module(module), name)(*arguments)


def _write(pipe: Any, content: bytes) -> None:
    pipe.write(_LENGTH.pack(len(content)))
    pipe.write(content)
    pipe.flush()


def _read(pipe: IO[bytes] | None) -> bytes | None:
    """One message; None where the pipe ends before it does."""
    if pipe is None:
        return None
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    content = pipe.read(length)
    return content if len(content) == length else None
