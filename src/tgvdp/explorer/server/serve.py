"""Serving the page until Ctrl-C."""

import contextlib
import socket
from collections.abc import Callable, Iterable, Sequence

import uvicorn

from tgvdp.errors import InputError
from tgvdp.explorer.compute.asked import Asked, File
from tgvdp.explorer.exhibit import Exhibit
from tgvdp.explorer.server.app import Explorer, make_app
from tgvdp.explorer.server.guard import LOOPBACK


def serve(
    exhibits: Iterable[Exhibit],
    asked: Asked | None,
    files: Iterable[File],
    *,
    host: str,
    port: int,
    names: Sequence[str],
    tell: Callable[[str], None],
) -> None:
    """Serve the page.

    Parameters
    ----------
    exhibits, asked, files
        As `Explorer` takes them.
    host : str
        Address to listen on.
    port : int
        0: a free one.
    names : sequence of str
        Names under which the page may be asked for, besides those of loopback and the address.
    tell : callable
        Told the page's address once somebody listens there.

    Raises
    ------
    InputError
        When nobody can listen there.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen()
    except OSError as error:
        listener.close()
        raise InputError(f"--host {host} --port {port}: cannot listen there: {error.strerror or error}") from None
    app = make_app(Explorer(exhibits, asked, files), {*LOOPBACK, host, *names})
    config = uvicorn.Config(
        app, log_level="warning", access_log=False, ws="none", server_header=False, timeout_graceful_shutdown=1
    )
    shown = f"[{host}]" if ":" in host else host
    tell(f"http://{shown}:{listener.getsockname()[1]}/")
    with contextlib.suppress(KeyboardInterrupt):  # which is how it ends
        uvicorn.Server(config).run(sockets=[listener])
