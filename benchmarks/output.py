"""Files of a benchmark: JSON with provenance, CSV, a Markdown table and a picture."""

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text, markdown_table, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = "tgvdp.benchmark/1"


@dataclass
class Report:
    """What a benchmark found.

    Attributes
    ----------
    name, title : str
    rows : list of dict
        One per line of the table; all have the same keys, which carry units.
    figures : dict
        The few figures that the summary quotes.
    notes : list of str
        How it was measured, and what to know when reading it.
    inputs : dict
        What was read or generated, for provenance.
    options : dict
        Of the run, for provenance.
    plot : Figure, optional
    """

    name: str
    title: str
    rows: list[dict[str, Any]] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    inputs: dict[str, Any] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)
    plot: "Figure | None" = None


def write_report(report: Report, folder: Path, elapsed_s: float) -> None:
    """Write the files of a benchmark into a folder."""
    content = {
        "schema": SCHEMA,
        "name": report.name,
        "title": report.title,
        "figures": plain(report.figures),
        "rows": plain(report.rows),
        "notes": report.notes,
        "provenance": make_provenance(report.options, report.inputs, elapsed_s),
    }
    files = {
        f"{report.name}.json": json.dumps(content, indent=1, ensure_ascii=False).encode() + b"\n",
        f"{report.name}.csv": csv_text(plain(report.rows)),
        f"{report.name}.md": _page(report, content["provenance"]).encode(),
    }
    if report.plot is not None:
        image = io.BytesIO()
        report.plot.set_layout_engine("constrained")  # names of instances are long, and nobody waits for the picture
        report.plot.savefig(image, format="png")
        files[f"{report.name}.png"] = image.getvalue()
    write_files(folder, files)


def _page(report: Report, provenance: Mapping[str, Any]) -> str:
    machine = provenance["machine"]
    made = (
        f"Made by `python -m benchmarks {report.name}` with tgvdp {provenance['tgvdp']}, Python "
        f"{provenance['python']}, numpy {provenance['numpy']}, numba {provenance['numba']} on {machine['processor']}, "
        f"{provenance['utc']}."
    )
    notes = "\n".join(f"- {note}" for note in report.notes)
    picture = f"\n![{report.title}]({report.name}.png)\n" if report.plot is not None else ""
    return f"# {report.title}\n\n{markdown_table(report.rows)}\n{notes}\n{picture}\n{made}\n"


def read_reports(folder: Path) -> dict[str, dict[str, Any]]:
    """All reports of a folder, by name."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))]
    return {content["name"]: content for content in found if content.get("schema") == SCHEMA}


def replace_between(page: Path, begin: str, end: str, text: str) -> None:
    """Put text between two marks of a page."""
    head, mark, rest = page.read_text(encoding="utf-8").partition(begin)
    _, found, tail = rest.partition(end)
    if not (mark and found):
        raise SystemExit(f"{page}: has no lines {begin} and {end} to write between")
    page.write_text(f"{head}{begin}\n{text}{end}{tail}", encoding="utf-8")
