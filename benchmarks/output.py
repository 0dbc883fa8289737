"""Files of a benchmark: JSON with provenance, CSV, a Markdown table and a picture."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.plain import plain

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


def shown(value: Any) -> str:
    """One cell of a table: four significant digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"
    return str(value)


def markdown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as a Markdown table; words to the left, numbers to the right."""
    if not rows:
        return ""
    columns = list(rows[0])
    aligned = ["---" if isinstance(rows[0][name], str) else "---:" for name in columns]
    lines = [columns, aligned, *([shown(row[name]) for name in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


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
    text = io.StringIO()
    writer = csv.DictWriter(text, list(report.rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(plain(report.rows))
    files = {
        f"{report.name}.json": json.dumps(content, indent=1, ensure_ascii=False).encode() + b"\n",
        f"{report.name}.csv": text.getvalue().encode(),
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
