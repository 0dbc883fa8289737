"""The page as one file: its styles, scripts and exhibits inside, for whoever has no server."""

import base64
import re
from collections.abc import Sequence
from pathlib import Path

import msgspec

from tgvdp.explorer.assets import INDEX, assets
from tgvdp.explorer.exhibit import Exhibit

#: Inside a file everything is inline, and nothing may be fetched from anywhere.
POLICY = "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:"
#: What a page says of who made it, and within how many bytes.
_GENERATOR, _HEAD_B = b'name="generator" content="tgvdp"', 1000
_STYLE = re.compile(r'<link rel="stylesheet" href="/page/([\w.]+)">')
_ICON = re.compile(r'<link rel="icon" href="/page/([\w.]+)"')
_SCRIPT = re.compile(r'<script src="/page/([\w.]+)" defer></script>')
_MODULE = re.compile(r'<script src="/page/([\w.]+)" type="module"></script>')
_IMPORT = re.compile(r'from "\./([\w.]+)"')


def page(exhibits: Sequence[Exhibit]) -> bytes:
    """One self-contained HTML page that shows exhibits.

    Parameters
    ----------
    exhibits : sequence of Exhibit
    """
    html = assets()[INDEX].data.decode()
    html = html.replace('<meta charset="utf-8">', f'<meta charset="utf-8">\n{_policy()}')
    html = _STYLE.sub(lambda found: f"<style>\n{_text(found[1])}</style>", html)
    html = _ICON.sub(lambda found: f'<link rel="icon" href="{_data_url(found[1], assets()[found[1]].data)}"', html)
    html = _SCRIPT.sub(lambda found: f"<script>{_text(found[1])}</script>", html)
    # Modules within a file are imported by name, from a map of names to data.
    html = _MODULE.sub(
        lambda found: f'{_import_map()}\n<script type="module">import "tgvdp/{found[1]}";</script>', html
    )
    held = b",".join(_exhibit(number, one) for number, one in enumerate(exhibits, start=1))
    content = f'<script type="application/json" id="exhibits">[{_harmless(held.decode())}]</script>'
    return html.replace("</body>", f"{content}\n</body>").encode()


def is_page(path: Path) -> bool:
    """Whether a file is such a page."""
    try:
        with path.open("rb") as file:
            return _GENERATOR in file.read(_HEAD_B)
    except OSError:
        return False


def _policy() -> str:
    return f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'


def _text(name: str) -> str:
    return assets()[name].data.decode()


def _data_url(name: str, data: bytes) -> str:
    return f"data:{assets()[name].type.partition(';')[0]};base64,{base64.b64encode(data).decode()}"


def _import_map() -> str:
    modules = {
        f"tgvdp/{name}": _data_url(name, _IMPORT.sub(r'from "tgvdp/\1"', _text(name)).encode())
        for name in assets()
        if name.endswith(".js") and not name.endswith(".min.js")
    }
    return f'<script type="importmap">{msgspec.json.encode({"imports": modules}).decode()}</script>'


def _start(name: str) -> str:
    return f'<script type="module">import "tgvdp/{name}";</script>'


def _exhibit(number: int, exhibit: Exhibit) -> bytes:
    raw = {name: msgspec.Raw(profile) for name, profile in exhibit.profiles.items()}
    return msgspec.json.encode({"id": str(number), "view": msgspec.Raw(exhibit.view), "profiles": raw})


def _harmless(json: str) -> str:
    """JSON in which nothing ends the element that it stands in."""
    return json.replace("<", "\\u003c")
