"""The routes of the server, and its life from the first process to the last."""

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator, Iterable
from pathlib import PurePath

import msgspec
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from tgvdp.errors import TgvdpError
from tgvdp.explorer.assets import INDEX, assets
from tgvdp.explorer.compute.asked import Asked, FieldError, File, read_asked
from tgvdp.explorer.exhibit import Exhibit
from tgvdp.explorer.limits import Limits
from tgvdp.explorer.server.form import form
from tgvdp.explorer.server.guard import LOOPBACK, Guard
from tgvdp.explorer.server.processes import Processes
from tgvdp.explorer.server.runs import QueueFullError, Run, Runs, files_of

#: Letters of a file's name that are kept: it is shown, and its suffix may tell the format.
_LONGEST_NAME = 100
_JSON = "application/json"


class Explorer:
    """What the routes share.

    Parameters
    ----------
    exhibits : iterable of Exhibit
        What is shown from the start.
    asked : Asked, optional
        A run to begin with.
    uploads : iterable of File
        Files that this run reads; they get the ids 1, 2, ….
    limits : Limits
    """

    def __init__(
        self, exhibits: Iterable[Exhibit] = (), asked: Asked | None = None, uploads: Iterable[File] = (),
        limits: Limits | None = None,
    ) -> None:  # fmt: skip
        self.limits = limits or Limits()
        self.processes = Processes(self.limits.memory_b)
        self._drafts = asyncio.Lock()
        self._numbers = itertools.count(1)
        self._exhibits, self._asked = list(exhibits), asked
        self.uploads: dict[str, File] = {}
        for file in uploads:
            self.keep(file)

    @contextlib.asynccontextmanager
    async def life(self, _: Starlette) -> AsyncIterator[None]:
        """Begin with what the command line gave; leave no process behind."""
        self.runs = Runs(self.limits, self.processes)
        for exhibit in self._exhibits:
            self.runs.show(exhibit)
        if self._asked is not None:
            self.runs.ask(self._asked, self.uploads)
        warming = asyncio.create_task(self._warm())
        try:
            yield
        finally:
            warming.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await warming
            await self.runs.close()
            await self.processes.close()

    async def _warm(self) -> None:
        """Load, or compile, the kernels before the first one who drags waits for them."""
        with contextlib.suppress(TgvdpError):
            await self.processes.do("warm", self.limits.running_s)

    def keep(self, file: File) -> str:
        """Keep an uploaded file, and let the oldest go; returns its id."""
        number = str(next(self._numbers))
        self.uploads[number] = file
        for old in list(self.uploads)[: -self.limits.uploads]:
            del self.uploads[old]
        return number

    async def form(self, _: Request) -> Response:
        """What can be asked for."""
        return JSONResponse(form())

    async def list(self, _: Request) -> Response:
        """All runs."""
        return JSONResponse([run.summary() for run in self.runs.all()])

    async def ask(self, request: Request) -> Response:
        """Queue a run."""
        asked = read_asked(await _json(request), self.uploads)
        return JSONResponse(self.runs.ask(asked, self.uploads).summary(), 202)

    async def run(self, request: Request) -> Response:
        """How far a run is."""
        return JSONResponse(self._run(request).summary())

    async def drop(self, request: Request) -> Response:
        """Cancel a run, or forget it."""
        if not await self.runs.drop(request.path_params["id"]):
            raise HTTPException(404, "there is no such run")
        return Response(status_code=204)

    async def view(self, request: Request) -> Response:
        """What a finished run found."""
        return Response(self._exhibit(request).view, media_type=_JSON)

    async def profile(self, request: Request) -> Response:
        """Speed profile of one point of a finished run."""
        found = self._exhibit(request).profiles.get(request.path_params["point"])
        if found is None:
            raise HTTPException(404, "this run has no such profile")
        return Response(found, media_type=_JSON)

    async def upload(self, request: Request) -> Response:
        """Take a file, and say what it holds."""
        name = _shown_name(request.query_params.get("name", ""))
        line_speed = request.query_params.get("line_speed_kmh") or None
        file = File(name, await _body(request, self.limits.upload_b))
        try:
            line_speed_kmh = None if line_speed is None else float(line_speed)
        except ValueError:
            raise FieldError("line_speed_kmh", f"must be a number of km/h, got {line_speed!r:.40}") from None
        found = await self.processes.do(
            "read", self.limits.reading_s, file={"name": name, "data": file.data}, line_speed_kmh=line_speed_kmh
        )
        return JSONResponse({"id": self.keep(file), "name": name, **found}, 201)

    async def draft(self, request: Request) -> Response:
        """Search anew while somebody drags; one at a time, and none for a page that has left."""
        data = await _json(request)
        try:
            wanted = msgspec.json.decode(data)
            asked, delay_s = wanted["asked"], float(wanted["delay_s"])
        except (msgspec.DecodeError, RecursionError, KeyError, TypeError, ValueError):
            raise FieldError("", "request: must hold asked and delay_s") from None
        checked = read_asked(msgspec.json.encode(asked), self.uploads)
        async with self._drafts:
            if await request.is_disconnected():
                return Response(status_code=204)
            found = await self.processes.do(
                "draft", self.limits.reading_s, asked=msgspec.to_builtins(checked),
                uploads=files_of(checked, self.uploads), delay_s=delay_s,
            )  # fmt: skip
        return Response(b'{"content":%b,"profile":%b}' % (found["content"], found["profile"]), media_type=_JSON)

    def _run(self, request: Request) -> Run:
        run = self.runs.get(request.path_params["id"])
        if run is None:
            raise HTTPException(404, "there is no such run")
        return run

    def _exhibit(self, request: Request) -> Exhibit:
        run = self._run(request)
        if run.exhibit is None:
            raise HTTPException(409, f"this run is {run.state}")
        return run.exhibit


def make_app(explorer: Explorer, hosts: Iterable[str] = LOOPBACK) -> Starlette:
    """Make the application that shows an explorer under some names."""
    return Starlette(
        routes=[
            Route("/", _page),
            Route("/page/{name}", _page),
            Route("/api/form", explorer.form),
            Route("/api/runs", explorer.list),
            Route("/api/runs", explorer.ask, methods=["POST"]),
            Route("/api/runs/{id}", explorer.run),
            Route("/api/runs/{id}", explorer.drop, methods=["DELETE"]),
            Route("/api/runs/{id}/view", explorer.view),
            Route("/api/runs/{id}/profiles/{point}", explorer.profile),
            Route("/api/uploads", explorer.upload, methods=["POST"]),
            Route("/api/drafts", explorer.draft, methods=["POST"]),
        ],
        middleware=[Middleware(Guard, hosts=hosts, limits=explorer.limits)],
        exception_handlers={FieldError: _refused, QueueFullError: _busy, TgvdpError: _failed, HTTPException: _plain},
        lifespan=explorer.life,
    )


async def _page(request: Request) -> Response:
    """A file of the page, by its name among those that are held in memory."""
    asset = assets().get(request.path_params.get("name", INDEX))
    if asset is None:
        raise HTTPException(404, "there is no such file")
    return Response(asset.data, media_type=asset.type)


async def _json(request: Request) -> bytes:
    if request.headers.get("content-type", "").partition(";")[0].strip() != _JSON:
        raise HTTPException(415, f"must be {_JSON}")
    return await request.body()


async def _body(request: Request, most_b: int) -> bytes:
    """Body of a request, at most so many bytes."""
    data = bytearray()
    async for chunk in request.stream():
        data += chunk
        if len(data) > most_b:
            raise HTTPException(413, f"larger than {most_b / 1e6:g} MB")
    return bytes(data)


def _shown_name(name: str) -> str:
    """Last part of a file's name, printable: it is shown and never opened."""
    last = PurePath(name.replace("\\", "/")).name[-_LONGEST_NAME:]
    return "".join(letter for letter in last if letter.isprintable()) or "file"


def _error(error: Exception, status: int) -> Response:
    field = error.field if isinstance(error, FieldError) else ""
    return JSONResponse({"message": str(error), "field": field}, status)


async def _refused(_: Request, error: Exception) -> Response:
    return _error(error, 422)


async def _busy(_: Request, error: Exception) -> Response:
    return _error(error, 429)


async def _failed(_: Request, error: Exception) -> Response:
    return _error(error, 500)


async def _plain(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return JSONResponse({"message": error.detail, "field": ""}, error.status_code, headers=error.headers)
