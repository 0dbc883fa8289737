"""``tgvdp catalog``: the trains, lines, energy maps and instances of the formulations that come with tgvdp."""

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_name
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
  tgvdp catalog easy-n008
  tgvdp catalog --json
"""


@click.command("catalog", epilog=_EXAMPLES)
@click.argument("name", required=False, shell_complete=complete_name)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(name: str | None, as_json: bool) -> None:
    """List the built-in trains, lines, energy maps and instances of the formulations, or show NAME and its sources."""
    entries = _entries(name)
    if as_json:
        listed = [_plain(*entry) for entry in entries]
        echo_json({"schema": SCHEMA, "entries": listed})
        return
    if name is not None:
        ((entry, description),) = entries
        click.echo("\n".join(map(_folded, f"{entry}: {description}".splitlines())))
        return
    width = max(len(entry) for entry, _ in entries)
    families: dict[str, list[str]] = {}
    for entry, description in entries:
        if description.kind == "instance":
            family, _, steps = entry.rpartition("-n")
            families.setdefault(family, []).append(steps)
            continue
        figures = (f"{figure.name} {figure}" for figure in description.figures if figure.name in _LISTED)
        click.echo(f"{description.kind:5}  {entry:{width}}  {', '.join(figures)}")
    for family, sizes in families.items():  # as a shell takes them, because there are many
        click.echo(f"instances  {family}-n{{{','.join(sizes)}}}")


def _entries(wanted: str | None) -> list[tuple[str, "Description"]]:
    """Names and descriptions of what the catalog has, or of the one that is wanted."""
    from tgvdp import instances
    from tgvdp.formats import describe_file
    from tgvdp.formats.syntax.typed import suggestion
    from tgvdp.model import catalog

    files = {name: catalog.path(name, kind) for kind in catalog.KINDS for name in catalog.names(kind)}
    index = instances.index()
    if wanted not in (None, *files, *index):
        raise InputError(f"catalog: unknown name {wanted!r:.60}{suggestion(str(wanted), [*files, *index])}")
    found = [(name, describe_file(path)) for name, path in files.items() if wanted in (None, name)]
    return found + [(name, _instance(row)) for name, row in index.items() if wanted in (None, name)]


def _instance(row: Mapping[str, str]) -> "Description":
    from tgvdp.formats.review.describe import Description
    from tgvdp.formats.review.figures import Figure

    model = f", {row['model']} model" if row["model"] else ""
    figures = [Figure("steps", int(row["N"]), "")]
    if row["objective"]:
        figures += [
            Figure("certified optimum", float(row["objective"]), row["unit"]),
            Figure("optimal schedules", row["n_optimal"] or "not counted", ""),
        ]
        note = "proved by " + ", ".join([row["certified_by"], *row["confirmed_by"].split()])
    else:
        figures += [
            Figure("best known", float(row["best_known"]), row["unit"]),
            Figure("bound", float(row["bound"]), row["unit"]),
        ]
        note = "open: nothing has proved an optimum"
    return Description(
        kind="instance", format=row["kind"] + model, name=row["id"], figures=tuple(figures), notes=(note,)
    )


def _plain(entry: str, description: "Description") -> dict[str, Any]:
    figures = [{"name": one.name, "value": one.value, "unit": one.unit} for one in description.figures]
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
