"""The loop of a child process: one task after the other, until its pipe ends.

It listens in a thread of its own, so that it ends at once when the server does, whatever it is computing.
"""

import contextlib
import os
import queue
import signal
import struct
import sys
import threading
import time
from typing import IO, Any

import msgspec

from tgvdp.errors import TgvdpError

LENGTH = struct.Struct("<Q")
#: What a process is started with: quick imports first, then this module with the limit of its memory, B.
BOOT = (
    "import sys; sys.path[:] = {path!r}; from tgvdp import start; start.start_fast(False);"
    " from tgvdp.explorer.compute import worker; worker.serve({memory_b!r})"
)
#: Kinds of messages back: any number of the first, then one of the others.
PROGRESS, DONE, FAILED = "progress", "done", "failed"
#: Least time between two words of progress, s.
_QUIET_S = 0.05


def serve(memory_b: float) -> None:
    """Do tasks until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _limit_memory(int(memory_b))
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    requests: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests,), daemon=True).start()
    while True:
        _answer(requests.get(), answers)


def _limit_memory(memory_b: int) -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # Windows has no such limit
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory_b, memory_b))


def _listen(requests: "queue.SimpleQueue[bytes]") -> None:
    pipe = sys.stdin.buffer
    while len(head := pipe.read(LENGTH.size)) == LENGTH.size:
        requests.put(pipe.read(*LENGTH.unpack(head)))
    os._exit(0)  # whatever is being done: nobody wants it any more


def _answer(request: bytes, answers: IO[bytes]) -> None:
    """Do one task and send what comes of it."""
    from tgvdp.explorer.compute.asked import FieldError
    from tgvdp.explorer.compute.tasks import TASKS

    told = {"at": -_QUIET_S}

    def tell(stage: str, done: float | None = None, total: float | None = None, **counters: int) -> None:
        if time.monotonic() - told["at"] >= _QUIET_S:
            told["at"] = time.monotonic()
            _send(answers, PROGRESS, {"stage": stage, "done": done, "total": total, "counters": counters})

    try:
        name, arguments = msgspec.msgpack.decode(request)
        value = TASKS[name](tell, **arguments)
    except TgvdpError as error:
        field = error.field if isinstance(error, FieldError) else ""
        _send(answers, FAILED, {"message": str(error), "field": field})
    except MemoryError:
        _send(answers, FAILED, {"message": "it takes more memory than a run may have here", "field": ""})
    except RecursionError:
        _send(answers, FAILED, {"message": "it is nested too deeply", "field": ""})
    except Exception as error:  # a fault of ours: the process goes on, the page says so
        _send(answers, FAILED, {"message": f"a fault of tgvdp, please report it: {error!r:.200}", "field": ""})
    else:
        _send(answers, DONE, value)


def _send(pipe: IO[bytes], kind: str, value: Any) -> None:
    content = msgspec.msgpack.encode((kind, value))
    pipe.write(LENGTH.pack(len(content)))
    pipe.write(content)
    pipe.flush()
