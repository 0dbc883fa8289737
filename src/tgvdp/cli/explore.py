"""``tgvdp explore``: the page to look at fronts, and to run searches from."""

from typing import TYPE_CHECKING, Literal

import click

from tgvdp.cli.completions import complete_source
from tgvdp.cli.groups import GroupedCommand, heading
from tgvdp.cli.numbers import LINE_SPEED
from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN, TRACK_HELP, TRAIN_HELP
from tgvdp.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from tgvdp.explorer.compute.asked import Asked, File

_EXAMPLES = """
\b
Examples:
  tgvdp explore                           the built-in train on the built-in line
  tgvdp explore out                       a folder that tgvdp search, journey or bench wrote
  tgvdp explore out flat                  two of them, one over the other
  tgvdp explore --track line.json --train train.json
"""
_server = heading("Server")


@click.command("explore", cls=GroupedCommand, epilog=_EXAMPLES)
@click.argument("folders", metavar="[RESULT_DIR]...", nargs=-1, type=click.Path())
@heading("Train and line")("--track", metavar="FILE|NAME", shell_complete=complete_source, help=TRACK_HELP)
@heading("Train and line")("--train", metavar="FILE|NAME", shell_complete=complete_source, help=TRAIN_HELP)
@heading("Train and line")("--line-speed", "line_speed_kmh", **LINE_SPEED)
@_server("--host", default="127.0.0.1", show_default=True, help="Address to listen on; loopback unless told otherwise.")
@_server("--port", default=8765, show_default=True, type=click.IntRange(0, 65535), help="Port; 0: a free one.")
@_server("--name", "names", metavar="HOST", multiple=True, help="Another name under which it is reached.")
@_server("--browser/--no-browser", default=True, show_default=True, help="Open the page.")
def command(
    folders: tuple[str, ...],
    track: str | None,
    train: str | None,
    line_speed_kmh: float | None,
    host: str,
    port: int,
    names: tuple[str, ...],
    browser: bool,
) -> int:
    """Look at a front, not at a table: a page in the browser, served from this machine.

    Without a folder it begins with a search. Ctrl-C ends it.
    """
    try:
        from tgvdp.explorer.server.serve import serve
    except ImportError:
        raise MissingExtraError("explore needs starlette and uvicorn: pip install 'tgvdp[web]'") from None
    from tgvdp.explorer.folder import read_folder

    exhibits = [read_folder(folder) for folder in folders]
    asked: Asked | None = None
    files: list[File] = []
    if not folders or train is not None or track is not None:
        asked, files = _asked(train or DEFAULT_TRAIN, track or DEFAULT_TRACK, line_speed_kmh)

    def tell(url: str) -> None:
        click.echo(f"{url} (Ctrl-C ends it)")
        if browser:
            click.launch(url)

    serve(exhibits, asked, files, host=host, port=port, names=names, tell=tell)
    return 0


def _asked(train: str, track: str, line_speed_kmh: float | None) -> "tuple[Asked, list[File]]":
    """A run to begin with: names of the catalog, and files with the part of each that is meant."""
    from tgvdp.explorer.compute.asked import Asked, File
    from tgvdp.formats import load_bytes, read_source
    from tgvdp.formats.syntax.reading import read_bytes
    from tgvdp.model import catalog
    from tgvdp.units import kmh_to_mps

    line_speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    files: list[File] = []

    def source(kind: Literal["train", "track"], given: str) -> str:
        if given in catalog.names(kind):
            return given
        speed_mps = line_speed_mps if kind == "track" else None
        read = read_source(given, kind, line_speed_mps=speed_mps)
        file = File(read.path.name, read_bytes(read.path))
        held = [getattr(one, kind) for one in load_bytes(file.name, file.data, line_speed_mps=speed_mps)]
        if read.value not in held:
            raise InputError(
                f"{given}: the page reads a file as it is: tgvdp convert {given} {kind}.toml makes one of it"
            )
        files.append(file)
        return f"upload:{len(files)}:{held.index(read.value)}"

    return Asked(train=source("train", train), track=source("track", track), line_speed_kmh=line_speed_kmh), files
