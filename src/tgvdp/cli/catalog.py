"""``tgvdp catalog``: the trains, lines and energy maps that come with tgvdp."""

import json
import textwrap
from typing import TYPE_CHECKING, Any

import click

from tgvdp.errors import InputError

if TYPE_CHECKING:
    from tgvdp.formats import Description

SCHEMA = "tgvdp.catalog/1"
_WIDTH = 110
_LISTED = {"mass", "length", "top speed", "power at the wheel", "speed limits", "gradients", "power drawn"}
_EXAMPLES = """
\b
Examples:
  tgvdp catalog
  tgvdp catalog tgv
  tgvdp catalog --json
"""


@click.command("catalog", epilog=_EXAMPLES)
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(name: str | None, as_json: bool) -> None:
    """List the built-in trains, lines and energy maps, or show NAME and its sources."""
    entries = _entries(name)
    if as_json:
        listed = [_plain(*entry) for entry in entries]
        click.echo(json.dumps({"schema": SCHEMA, "entries": listed}, ensure_ascii=False, allow_nan=False))
        return
    width = max(len(entry) for entry, _ in entries)
    for entry, description in entries:
        if name is None:
            figures = (f"{figure.name} {figure}" for figure in description.figures if figure.name in _LISTED)
            click.echo(f"{description.kind:5}  {entry:{width}}  {', '.join(figures)}")
        else:
            click.echo("\n".join(map(_folded, f"{entry}: {description}".splitlines())))


def _entries(wanted: str | None) -> list[tuple[str, "Description"]]:
    """Names and descriptions of what the catalog has, or of the one that is wanted."""
    from tgvdp.formats import describe_file
    from tgvdp.formats.syntax.typed import suggestion
    from tgvdp.model import catalog

    known = [(kind, name) for kind in catalog.KINDS for name in catalog.names(kind)]
    chosen = [(kind, name) for kind, name in known if wanted in (None, name)]
    if not chosen:
        raise InputError(f"catalog: unknown name {wanted!r:.60}{suggestion(str(wanted), [name for _, name in known])}")
    return [(name, describe_file(catalog.path(name, kind))) for kind, name in chosen]


def _plain(entry: str, description: "Description") -> dict[str, Any]:
    figures = [figure._asdict() for figure in description.figures]
    return {
        "name": entry,
        "kind": description.kind,
        "title": description.name,
        "figures": figures,
        "notes": description.notes,
    }


def _folded(line: str) -> str:
    """Fold a long line below itself."""
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.fill(line, _WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
