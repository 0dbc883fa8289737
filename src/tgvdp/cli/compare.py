"""``tgvdp compare``: several results, or several trains and lines, at equal margins."""

import itertools
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_folder, complete_source
from tgvdp.cli.folder import OutFolder
from tgvdp.cli.notes import remarked
from tgvdp.cli.places import place, positions_on
from tgvdp.cli.screen import Screen, aligned, column
from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN
from tgvdp.errors import InputError

#: Points of a front besides the margins that are compared.
_POINTS = 30

_EXAMPLES = """
\b
Examples:
  tgvdp compare out flat                         folders that tgvdp search has written
  tgvdp compare --train tgv --train alstom-emu --track flat-100km
  tgvdp compare --train tgv --track lgv-100km --track flat-100km --at "3%,5%,8%" --json
"""


@click.command("compare", epilog=_EXAMPLES)
@click.argument("folders", metavar="[DIR]...", nargs=-1, shell_complete=complete_folder)
@click.option(
    "--train", "trains", metavar="FILE|NAME", multiple=True, shell_complete=complete_source,
    help="Train to search for; may be given several times.",
)  # fmt: skip
@click.option(
    "--track", "tracks", metavar="FILE|NAME", multiple=True, shell_complete=complete_source,
    help="Line to search on; may be given several times.",
)  # fmt: skip
@click.option(
    "--energy", metavar="MODEL", shell_complete=complete_source, help="What is minimised, see search.  [default: wheel]"
)
@click.option("--from", "from_m", metavar="M|STOP", type=place(at_least=0.0), help="Origin on the lines.  [default: 0]")
@click.option("--to", "to_m", metavar="M|STOP", type=place(), help="Destination on the lines.  [default: their ends]")
@click.option("--at", metavar="LIST", help="Margins to compare: 3%,5%.  [default: 0%,2%,5%,10%,15%,20%,25%]")
@click.option(
    "--out",
    metavar="DIR",
    default="compare",
    show_default=True,
    shell_complete=complete_folder,
    help="Folder of the results.",
)
@click.option("--force", is_flag=True, help="Write into a folder that holds files of others.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(
    folders: tuple[str, ...],
    trains: tuple[str, ...],
    tracks: tuple[str, ...],
    energy: str | None,
    from_m: float | str | None,
    to_m: float | str | None,
    at: str | None,
    out: str,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Compare the results in folders, or trains on lines, at equal margins over the fastest running time.

    Writes compare.json, compare.csv and compare.png into a folder.
    """
    from tgvdp.report import make_provenance
    from tgvdp.report.columns import to_csv
    from tgvdp.report.comparison import (
        compare_columns,
        compare_object,
        differences,
        names_of,
        plot_comparison,
        read_result,
    )
    from tgvdp.report.pictures import encode
    from tgvdp.report.plain import to_json
    from tgvdp.report.provenance import write_ledger

    context = click.get_current_context()
    asked = {"train": trains, "track": tracks, "energy": energy, "from_m": from_m, "to_m": to_m}
    given = [name for name, value in asked.items() if value not in (None, ())]
    if folders and given:
        raise click.UsageError(
            "folders hold results: --train, --track, --energy, --from, --to ask for searches", context
        )
    if not folders and not (trains or tracks):
        raise click.UsageError("name folders of results, or trains and lines: --train a --train b --track x", context)
    folder = OutFolder(out, "compare.json", force=force)
    started_s = time.perf_counter()
    with Screen(quiet=quiet) as screen:
        margins_pct = _margins(at)
        if folders:
            contents = [read_result(folder) for folder in folders]
            inputs: dict[str, Any] = {folder: _file_of(folder) for folder in folders}
        else:
            contents, inputs = _searched(
                trains or (DEFAULT_TRAIN,), tracks or (DEFAULT_TRACK,), asked, margins_pct, screen
            )
        names = names_of(contents, [Path(folder).name for folder in folders])
        content = compare_object(contents, names, margins_pct)
        if folders and (text := differences(contents)):
            screen.note(text)
        screen.progress("drawing and writing")
        provenance = make_provenance({**asked, "at": margins_pct}, inputs, time.perf_counter() - started_s)
        content["provenance"] = provenance
        written = {
            "compare.json": to_json(content),
            "compare.csv": to_csv(compare_columns(content)),
            "compare.png": encode(plot_comparison(contents, names), provenance),
        }
        files = write_ledger(out, written, provenance)
    folder.drop_earlier(files)
    if as_json:
        echo_json(content)
    elif not quiet:
        click.echo(compare_table(content))
        click.echo(f"in {out}: {', '.join(file.name for file in files)}")
    if "warning" in content and not quiet:
        click.echo(f"tgvdp: warning: {content['warning']}", err=True)


def _margins(at: str | None) -> tuple[float, ...]:
    """Margins to compare, %."""
    from tgvdp.options.texts import parse_targets
    from tgvdp.report.comparison import MARGINS_PCT

    if at is None:
        return MARGINS_PCT
    try:
        margins, times_s = parse_targets(at)
    except InputError as error:
        raise click.BadParameter(str(error), param_hint="'--at'") from None
    if times_s:
        raise click.BadParameter(
            "running times differ from trip to trip: margins only, such as 3%,5%", param_hint="'--at'"
        )
    return tuple(sorted({100.0 * margin for margin in margins}))


def _file_of(folder: str) -> Path:
    path = Path(folder)
    return path / "result.json" if path.is_dir() else path


def _searched(
    trains: Sequence[str], tracks: Sequence[str], asked: Mapping[str, Any], margins_pct: Sequence[float], screen: Screen
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Results of every train on every line, as objects of schema tgvdp.search/1, and what they were made of."""
    from tgvdp import api
    from tgvdp.formats import read_source
    from tgvdp.report import result_object

    top = max(*margins_pct, 1.0) / 100.0
    # Fronts are steep next to the fastest run: points get closer towards it.
    shares = {(step / _POINTS) ** 2 for step in range(1, _POINTS + 1)}
    margins = sorted({*(margin / 100.0 for margin in margins_pct if margin > 0.0), *(top * share for share in shares)})
    options = {} if asked["energy"] is None else {"energy": asked["energy"]}
    contents: list[dict[str, Any]] = []
    inputs: dict[str, Any] = {}
    for train, track in itertools.product(trains, tracks):
        screen.progress(f"searching: {train} on {track}")
        the_train, the_track = read_source(train, "train"), read_source(track, "track")
        for text in (*remarked(the_train.remarks), *remarked(the_track.remarks)):
            screen.note(text)
        ends = positions_on(the_track.value, asked)
        result = api.search(
            the_train.value, the_track.value, at_margin=margins,
            origin_m=ends["from_m"] or 0.0, destination_m=ends["to_m"], **options,
        )  # fmt: skip
        contents.append(result_object(result, result.verify(), {}))
        inputs |= {train: the_train.fingerprint, track: the_track.fingerprint}
    return contents, inputs


def compare_table(content: Mapping[str, Any]) -> str:
    """One row per margin: energy and saving of each, of an object of schema tgvdp.compare/1."""
    rows = content["rows"]
    columns = [column("margin", "%", 6, [f"{margin:g}" for margin in dict.fromkeys(row["margin_pct"] for row in rows)])]
    for name in (run["name"] for run in content["runs"]):
        own = [row for row in rows if row["name"] == name]
        columns.append(column(name, "kWh", 8, aligned([row["energy_kwh"] for row in own], 5)))
        columns.append(column("saved", "%", 6, aligned([row["saved_pct"] for row in own], 3)))
    return "\n".join("  ".join(cells) for cells in zip(*columns, strict=True))
