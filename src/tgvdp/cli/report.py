"""``tgvdp report``: results as one HTML page, and as figures for papers."""

from pathlib import Path

import click

from tgvdp.cli.completions import complete_file
from tgvdp.cli.groups import GroupedCommand
from tgvdp.errors import InputError

_WIDTHS = ("single", "double")
_FORMATS = ("pdf", "svg", "png")
_EXAMPLES = """
\b
Examples:
  tgvdp report out                                 writes out/report.html
  tgvdp report out flat -o both.html               two results, one over the other
  tgvdp report out --figures pdf,svg --width single
"""


def _formats(_: click.Context, __: click.Parameter, text: str | None) -> tuple[str, ...]:
    if text is None:
        return ()
    formats = tuple(dict.fromkeys(word.strip().lower() for word in text.split(",") if word.strip()))
    unknown = next((word for word in formats if word not in _FORMATS), None)
    if unknown is not None or not formats:
        missing = "there is none" if unknown is None else f"there is no {unknown!r}"
        raise click.BadParameter(f"{missing}; there are {', '.join(_FORMATS)}")
    return formats


@click.command("report", cls=GroupedCommand, epilog=_EXAMPLES)
@click.argument("folders", metavar="RESULT_DIR...", nargs=-1, required=True, type=click.Path())
@click.option(
    "-o",
    "--out",
    metavar="FILE",
    shell_complete=complete_file,
    help="The page.  [default: report.html in the first folder]",
)
@click.option("--figures", metavar="LIST", callback=_formats, help="Figures for papers beside the page: pdf, svg, png.")
@click.option("--force", is_flag=True, help="Overwrite FILE where it is no such page.")
@click.option("--width", type=click.Choice(_WIDTHS), default="single", show_default=True, help="Columns of a figure.")
def command(folders: tuple[str, ...], out: str | None, figures: tuple[str, ...], force: bool, width: str) -> int:
    """Put results into one self-contained HTML page, with the pictures of ``tgvdp explore``.

    The page needs no server and no network: mail it, or keep it beside a paper.
    """
    from tgvdp.explorer.folder import read_folder
    from tgvdp.explorer.standalone import is_page, page
    from tgvdp.report.files import check_new, write_files

    target = Path(folders[0]) / "report.html" if out is None else Path(out)
    exhibits = [read_folder(folder) for folder in folders]
    check_new(target, force=force or is_page(target))
    files = {target.name: page(exhibits)}
    if figures:
        files |= _figures(folders[0], figures, width)
    written = write_files(target.parent, files)
    click.echo(f"in {target.parent}: {', '.join(file.name for file in written)}")
    return 0


def _figures(folder: str, formats: tuple[str, ...], width: str) -> dict[str, bytes]:
    """Figures of a search, by the names of their files."""
    from tgvdp.explorer.folder import read_search
    from tgvdp.report.paper_plots import WIDTHS_MM, plot_paper_front, plot_paper_profile
    from tgvdp.report.pictures import encode

    found = read_search(folder)
    if found is None:
        raise InputError(f"{folder}: figures for papers are made of what tgvdp search wrote")
    content, profiles = found
    if missing := next((name for name in ("fastest", str(content["front"][-1]["id"])) if name not in profiles), None):
        raise InputError(f"{folder}: profiles.csv holds no rows of run {missing}, which a figure shows")
    about = content["provenance"]
    drawn = {
        "paper_front": plot_paper_front(content, WIDTHS_MM[width]),
        "paper_profile": plot_paper_profile(content, profiles, WIDTHS_MM[width]),
    }
    return {f"{name}.{format}": encode(figure, about, format) for name, figure in drawn.items() for format in formats}
