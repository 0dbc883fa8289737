"""Runs: queued, computed a few at a time, kept, cancelled."""

import asyncio
import contextlib
import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import msgspec

from tgvdp.errors import TgvdpError
from tgvdp.explorer.compute.asked import Asked, FieldError, File
from tgvdp.explorer.exhibit import Exhibit
from tgvdp.explorer.limits import Limits
from tgvdp.explorer.server.processes import Processes

State = Literal["queued", "running", "done", "failed"]
_FINISHED = ("done", "failed")


class QueueFullError(TgvdpError):
    """More runs wait than may."""


@dataclass
class Run:
    """A run, from the moment it is asked for."""

    id: str
    name: str
    state: State = "queued"
    progress: Mapping[str, Any] = field(default_factory=dict)
    error: Mapping[str, str] | None = None
    exhibit: Exhibit | None = None
    task: "asyncio.Task[None] | None" = None

    def summary(self) -> dict[str, Any]:
        """What the page lists of it."""
        return {
            "id": self.id, "name": self.name, "kind": self.exhibit.kind if self.exhibit else "search",
            "state": self.state, "progress": self.progress, "error": self.error,
        }  # fmt: skip


class Runs:
    """All runs of a server by id: first the exhibits that it was started with, then what the page asks for.

    A run is computed whether or not somebody watches: a page that is reloaded finds it again.
    """

    def __init__(self, limits: Limits, processes: Processes) -> None:
        self._limits, self._processes = limits, processes
        self._slots = asyncio.Semaphore(limits.runs_at_once)
        self._numbers = itertools.count(1)
        self._runs: dict[str, Run] = {}

    def show(self, exhibit: Exhibit) -> Run:
        """Keep an exhibit that is there from the start."""
        run = Run(f"folder-{len(self._runs) + 1}", exhibit.name, "done", exhibit=exhibit)
        self._runs[run.id] = run
        return run

    def ask(self, asked: Asked, uploads: Mapping[str, File]) -> Run:
        """Queue a run.

        Raises
        ------
        QueueFullError
            When too many wait.
        """
        if sum(run.state == "queued" for run in self._runs.values()) >= self._limits.runs_queued:
            raise QueueFullError(f"{self._limits.runs_queued} runs wait already: cancel one, or try again later")
        run = Run(str(next(self._numbers)), _name_of(asked, uploads))
        self._runs[run.id] = run
        run.task = asyncio.create_task(self._compute(run, asked, dict(uploads)))
        self._drop_old()
        return run

    async def _compute(self, run: Run, asked: Asked, uploads: Mapping[str, File]) -> None:
        def hear(progress: Mapping[str, Any]) -> None:
            run.progress = progress

        async with self._slots:
            run.state = "running"
            try:
                found = await self._processes.do(
                    "run", self._limits.running_s, hear,
                    asked=msgspec.to_builtins(asked), uploads=files_of(asked, uploads),
                )  # fmt: skip
            except TgvdpError as error:
                run.state, run.error = "failed", _as_error(error)
            else:
                run.exhibit = Exhibit("search", found["name"], found["view"], found["profiles"])
                run.state, run.name = "done", found["name"]

    def _drop_old(self) -> None:
        """Let the oldest go that are finished, where too many are kept."""
        asked = [run for run in self._runs.values() if run.task is not None and run.state in _FINISHED]
        for run in asked[: max(0, len(asked) - self._limits.runs_kept)]:
            del self._runs[run.id]

    def get(self, id: str) -> Run | None:
        """Run of an id."""
        return self._runs.get(id)

    def all(self) -> list[Run]:
        """All runs, the oldest first."""
        return list(self._runs.values())

    async def drop(self, id: str) -> bool:
        """Cancel a run, or forget it; False where there is none."""
        run = self._runs.pop(id, None)
        if run is None:
            return False
        if run.task is not None:
            run.task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await run.task
        return True

    async def close(self) -> None:
        """Cancel what goes on."""
        for id in list(self._runs):
            await self.drop(id)


def files_of(asked: Asked, uploads: Mapping[str, File]) -> dict[str, Any]:
    """Files that a run reads, and no others."""
    sources = [asked.train, asked.track, str(asked.options.get("energy", ""))]
    ids = {source.split(":")[1] for source in sources if source.startswith("upload:")}
    return {id: {"name": file.name, "data": file.data} for id, file in uploads.items() if id in ids}


def _name_of(asked: Asked, uploads: Mapping[str, File]) -> str:
    names = (
        uploads[source.split(":")[1]].name if source.startswith("upload:") else source
        for source in (asked.train, asked.track)
    )
    return " on ".join(names)


def _as_error(error: TgvdpError) -> dict[str, str]:
    return {"message": str(error), "field": error.field if isinstance(error, FieldError) else ""}
