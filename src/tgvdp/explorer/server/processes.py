"""Child processes that do tasks: started when needed, used again while they are well, killed when they are not."""

import asyncio
import sys
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from tgvdp.errors import BudgetExceededError, TgvdpError
from tgvdp.explorer.compute.asked import FieldError
from tgvdp.explorer.compute.worker import BOOT, DONE, LENGTH, PROGRESS

Progress = Callable[[Mapping[str, Any]], None]


class CrashedError(TgvdpError):
    """A child process ended before its task did."""


class Processes:
    """Child processes, as many as tasks are done at a time.

    Parameters
    ----------
    memory_b : float
        Address space of each, B.
    """

    def __init__(self, memory_b: float) -> None:
        self._memory_b = memory_b
        self._idle: list[asyncio.subprocess.Process] = []
        self._alive: set[asyncio.subprocess.Process] = set()

    async def do(self, task: str, limit_s: float, progress: Progress | None = None, **arguments: Any) -> dict[str, Any]:
        """Have a task done, in a process of its own.

        Whoever cancels this, as time does, kills the process: another one takes its place when it is needed.

        Raises
        ------
        FieldError
            When the task fails; with the field of the form that it is about.
        BudgetExceededError
            When the time is up.
        CrashedError
            When the process ends: it may have met the limit of its memory.
        """
        process = self._idle.pop() if self._idle else await self._start()
        try:
            async with asyncio.timeout(limit_s):
                value = await _exchange(process, msgspec.msgpack.encode((task, arguments)), progress)
        except TimeoutError:
            await self._kill(process)
            raise BudgetExceededError(f"it took longer than {limit_s:g} s") from None
        except (asyncio.IncompleteReadError, OSError):
            await self._kill(process)
            raise CrashedError("the process that computed it has ended; it may have run out of memory") from None
        except FieldError:
            self._idle.append(process)
            raise
        except BaseException:  # cancelled
            await self._kill(process)
            raise
        self._idle.append(process)
        return value

    async def _start(self) -> asyncio.subprocess.Process:
        pipe = asyncio.subprocess.PIPE
        boot = BOOT.format(path=sys.path, memory_b=self._memory_b)
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", boot, stdin=pipe, stdout=pipe, stderr=asyncio.subprocess.DEVNULL
        )
        self._alive.add(process)
        return process

    async def _kill(self, process: asyncio.subprocess.Process) -> None:
        self._alive.discard(process)
        if process.returncode is None:
            process.kill()
        await process.communicate()  # to the end of its pipes, which close so

    async def close(self) -> None:
        """Leave no process behind."""
        self._idle.clear()
        for process in list(self._alive):
            await self._kill(process)

    @property
    def alive(self) -> list[int]:
        """Numbers of the processes that there are."""
        return [process.pid for process in self._alive]


async def _exchange(process: asyncio.subprocess.Process, request: bytes, progress: Progress | None) -> dict[str, Any]:
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(LENGTH.pack(len(request)) + request)
    await process.stdin.drain()
    while True:
        (length,) = LENGTH.unpack(await process.stdout.readexactly(LENGTH.size))
        kind, value = msgspec.msgpack.decode(await process.stdout.readexactly(length))
        if kind == PROGRESS:
            if progress is not None:
                progress(value)
        elif kind == DONE:
            return value or {}
        else:
            raise FieldError(value["field"], value["message"])
