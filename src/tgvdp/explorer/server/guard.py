"""What stands before all routes: forged hosts, foreign origins and large requests are refused; headers are strict."""

from collections.abc import Iterable
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from tgvdp.explorer.limits import Limits

#: Names under which a server on loopback is reached.
LOOPBACK = ("127.0.0.1", "localhost", "::1")
#: Nothing but the page's own files runs, styles or is fetched; nobody may frame it. Pictures may be drawn into memory.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
_READING = ("GET", "HEAD")
_UPLOADS = "/api/uploads"


class Guard:
    """ASGI middleware.

    Parameters
    ----------
    app : ASGI application
    hosts : iterable of str
        Names under which it may be asked for, without the port: a page of elsewhere whose name was made to point here
        (DNS rebinding) has another one.
    limits : Limits
    """

    def __init__(self, app: ASGIApp, hosts: Iterable[str], limits: Limits) -> None:
        self._app, self._hosts, self._limits = app, frozenset(hosts), limits

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse a request, or pass it on."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self._app(scope, receive, send)
            return  # no web sockets
        refusal = self._refusal(scope["method"], scope["path"], Headers(scope=scope))
        answer = _strict(send)
        if refusal is not None:
            status, message = refusal
            await JSONResponse({"message": message, "field": ""}, status)(scope, receive, answer)
            return
        await self._app(scope, receive, answer)

    def _refusal(self, method: str, path: str, headers: Headers) -> tuple[int, str] | None:
        hosts = headers.getlist("host")
        if len(hosts) != 1 or host_name(hosts[0]) not in self._hosts:
            return 400, "this server is not known by that name"
        if method in _READING:
            return None
        if headers.get("origin") != f"http://{hosts[0]}":
            return 403, "changes are made from the page itself only"
        length = headers.get("content-length")
        if length is None and method == "POST":
            return 411, "a request must say how long it is"
        most_b = self._limits.upload_b if path == _UPLOADS else self._limits.request_b
        if length is not None and not (length.isdecimal() and int(length) <= most_b):
            return 413, f"larger than {most_b / 1e6:g} MB"
        return None


def host_name(host: str) -> str | None:
    """Name in a Host header, without the port; None where it is no host."""
    try:
        parts = urlsplit(f"//{host}")
        _ = parts.port
    except ValueError:
        return None
    return parts.hostname if parts.netloc == host and "@" not in host and not parts.path else None


def _strict(send: Send) -> Send:
    async def with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers[name] = value
        await send(message)

    return with_headers
