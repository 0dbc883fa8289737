"""Rows of the study as a page and as CSV."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text, markdown_table, plain

_WORST = 5

_NOTES = """
- *refused*: no journey was found, exit code 4; *though a path keeps them*: the grid has a path that is in all windows.
- *missed*: by how much the train passes outside of a window, the worst of all points of all fronts.
- *above the grid*: by how much a point takes more than the cheapest path of the grid that keeps the windows and ends no
  later; below 0 where it takes less. Of each front without its earliest arrival, where the grid has a path at all.
- *gap*: of a front's points to their certified bounds, the median of each. *below a bound*: fronts of which a point, or
  a path of the grid, lies below one. *not ok*: runs that the referee does not pass.
"""


def summary(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The study in a few figures."""
    done = [row for row in rows if not row["refused"]]
    refused = [row for row in rows if row["refused"]]
    above_pct = np.array([row["above_grid_pct"] for row in done if row["above_grid_pct"] is not None])
    gap_pct = np.array([row["median_gap_pct"] for row in done if row["median_gap_pct"] is not None])
    figures = {
        "lines": len(rows),
        "refused": len(refused),
        "... though a path of the grid keeps them": sum(row["grid_keeps"] for row in refused),
        "points": sum(row["points"] for row in done),
        "missed, worst, s": max(row["missed_s"] for row in done),
        "above the grid, worst, %": above_pct.max(),
        "... fronts by more than 0.1 %": int((above_pct > 0.1).sum()),
        "gap, median, %": np.median(gap_pct),
        "gap, nine in ten below, %": np.percentile(gap_pct, 90.0),
        "below a bound": sum(row["below_bound"] for row in done),
        "not ok": sum(row["not_ok"] for row in done),
        "processor time of a front, median, s": np.median([row["cpu_s"] for row in done]),
        "... worst, s": max(row["cpu_s"] for row in done),
    }
    return [{"what": name, "": value} for name, value in figures.items()]


def page(rows: Sequence[dict[str, Any]], elapsed_s: float) -> str:
    """The page: summary, what is worst, what was refused, how it was made."""
    compared = [row for row in rows if not row["refused"] and row["above_grid_pct"] is not None]
    done = sorted(compared, key=lambda row: -row["above_grid_pct"])
    shown = ("seed", "energy", "km", "windows", "points", "above_grid_pct", "missed_s", "cpu_s", "warning")
    worst = markdown_table([{name: row[name] for name in shown} for row in done[:_WORST]])
    refused = "".join(
        f"- {row['seed']}{', though a path keeps them' if row['grid_keeps'] else ''}: {row['refused']}\n"
        for row in rows
        if row["refused"]
    )
    made = make_provenance({}, {}, elapsed_s)
    return (
        f"# Random windows between stops, on random lines\n\n{markdown_table(summary(rows))}{_NOTES}\n"
        f"## Dearest against the grid\n\n{worst}\n## Refused\n\n{refused}\n"
        f"Seeds {rows[0]['seed']} to {rows[-1]['seed']}, all lines in windows.csv. Made by `make windows` with tgvdp "
        f"{made['tgvdp']}, Python {made['python']}, numba {made['numba']} on {made['machine']['processor']} in "
        f"{elapsed_s:.0f} s, {made['utc']}.\n"
    )


def write(rows: Sequence[dict[str, Any]], folder: Path, elapsed_s: float) -> None:
    """Write windows.md and windows.csv into a folder."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    table = [{name: row.get(name) for name in names} for row in rows]
    write_files(folder, {"windows.md": page(rows, elapsed_s).encode(), "windows.csv": csv_text(plain(table))})
