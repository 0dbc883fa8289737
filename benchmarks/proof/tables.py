"""Rows of the survey as a page and as CSV."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text, markdown_table, plain

_WORST = 10

_NOTES = """
- A point is *dearer* by what the polish saves in the same time, where the referee passes the polished run: local, so a
  lower bound of the error. Three points of each front are polished, others with each seed. Trips with any such point
  count.
- *gap*: certified, the largest of a front's from its third point on, in percent of the energy that is drawn, infinite
  where there is no bound; *fastest*: of the fastest run.
- *missed*: trips with a running time that was asked for and not met. *errors*: trips that ended in an error or a
  refusal, although each has a run by its making. *not ok*: points that the referee does not pass. *contradicted*: trips
  where the polish found a run that lies below the certified bound by more than 0.005 %.
- *phases* per point, median; *short*: phases under one second per point, mean. *replay*: largest difference of running
  time and energy that the referee found.
"""


def _share_above(rows: Sequence[dict[str, Any]], name: str, least: float) -> float:
    return 100.0 * float(np.mean([row[name] > least for row in rows]))


def _of(rows: Sequence[dict[str, Any]], name: str, take: Callable[[list[float]], Any]) -> Any:
    return float(take([row[name] for row in rows]))


def summary(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row for each kind of trip, and one for all."""
    kinds = sorted({row["kind"] for row in rows})
    return [_summed(kind, [row for row in rows if row["kind"] == kind]) for kind in kinds] + [_summed("all", rows)]


def _summed(kind: str, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    done = [row for row in rows if row["error"] is None]
    head = {"kind": kind, "trips": len(rows), "errors": len(rows) - len(done)}
    if not done:
        return head
    return head | {
        "dearer > 0.05 %": _share_above(done, "dearer_pct", 0.05),
        "dearer > 0.01 %": _share_above(done, "dearer_pct", 0.01),
        "dearer, worst %": _of(done, "dearer_pct", max),
        "gap > 0.1 %": _share_above(done, "gap_pct", 0.1),
        "gap > 1 %": _share_above(done, "gap_pct", 1.0),
        "gap, worst %": _of(done, "gap_pct", max),
        "fastest > 0.2 %": _share_above(done, "fastest_gap_pct", 0.2),
        "fastest, worst %": _of(done, "fastest_gap_pct", max),
        "missed": sum(row["missed"] > 0 for row in done),
        "not ok": sum(row["not_ok"] for row in done),
        "contradicted": sum(row["below_bound_pct"] > 5e-3 for row in done),
        "phases": _of(done, "phases", np.median),
        "short": _of(done, "short_phases", np.mean),
        "replay ms": _of(done, "replay_ms", max),
        "replay energy %": _of(done, "replay_energy_pct", max),
        "search ms": 1e3 * _of(done, "search_s", np.median),
        "certify ms": 1e3 * _of(done, "certify_s", np.median),
    }


def page(rows: Sequence[dict[str, Any]], elapsed_s: float) -> str:
    """The page: summary, what is worst, how it was made."""
    done = [row for row in rows if row["error"] is None]
    worst = {
        "Dearest against the polish": sorted(done, key=lambda row: -row["dearer_pct"])[:_WORST],
        "Largest certified gaps": sorted(done, key=lambda row: -row["gap_pct"])[:_WORST],
        "Errors": [row for row in rows if row["error"] is not None][:_WORST],
    }
    columns = ("seed", "kind", "feature", "km", "dearer_pct", "gap_pct", "fastest_gap_pct", "error")
    tables = [
        f"## {title}\n\n{markdown_table([{name: row[name] or '' for name in columns} for row in some])}"
        for title, some in worst.items()
        if some
    ]
    made = make_provenance({}, {}, elapsed_s)
    first, last = rows[0]["seed"], rows[-1]["seed"]
    return (
        f"# Survey of random trips\n\n{_turned(summary(rows))}{_NOTES}\n" + "\n".join(tables) + "\n"
        f"Seeds {first} to {last}, all trips in proof.csv. Made by `make proof` with tgvdp {made['tgvdp']}, Python "
        f"{made['python']}, numba {made['numba']} on {made['machine']['processor']} in {elapsed_s:.0f} s, "
        f"{made['utc']}.\n"
    )


def _turned(rows: Sequence[dict[str, Any]]) -> str:
    """Markdown table with a column for each kind: there are more figures than kinds."""
    names = list(rows[-1])[1:]
    return markdown_table([{"": name} | {row["kind"]: row.get(name) for row in rows} for name in names])


def write(rows: Sequence[dict[str, Any]], folder: Path, elapsed_s: float) -> None:
    """Write proof.md and proof.csv into a folder."""
    write_files(folder, {"proof.md": page(rows, elapsed_s).encode(), "proof.csv": csv_text(plain(rows))})
