"""The files of the page, held in memory by name: no name from outside is ever looked for on disk."""

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from tgvdp.report.palette import DARK, LIGHT

INDEX = "index.html"
TOKENS = "tokens.css"
_TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


class Asset(NamedTuple):
    """A file of the page and its media type."""

    data: bytes
    type: str


@cache
def assets() -> Mapping[str, Asset]:
    """All files of the page by name."""
    folder = files("tgvdp.explorer") / "page"
    found = {TOKENS: Asset(_tokens().encode(), _TYPES["css"])}
    for place in (folder, folder / "vendor"):
        for file in place.iterdir():
            suffix = file.name.rpartition(".")[2]
            if suffix in _TYPES:
                found[file.name] = Asset(file.read_bytes(), _TYPES[suffix])
    return found


def _tokens() -> str:
    """Colours of the palette as custom properties, light and dark: by the system's wish, or as the page was told."""
    light, dark = ("".join(f"  --{role}: {color};\n" for role, color in colors.items()) for colors in (LIGHT, DARK))
    return (
        f":root {{\n{light}  color-scheme: light;\n}}\n"
        f"@media (prefers-color-scheme: dark) {{\n:root {{\n{dark}  color-scheme: dark;\n}}\n}}\n"
        f":root[data-theme='light'] {{\n{light}  color-scheme: light;\n}}\n"
        f":root[data-theme='dark'] {{\n{dark}  color-scheme: dark;\n}}\n"
    )
