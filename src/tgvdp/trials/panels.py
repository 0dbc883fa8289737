"""What the pictures show, in small multiples by family: of each solver the variant that does best; sizes."""

import math
from collections.abc import Sequence

import numpy as np

from tgvdp.report.trial_plots import FamilyPanel, Series, SizePanel, median_series
from tgvdp.trials.ensembles import family_of
from tgvdp.trials.rows import Row

#: Families that a picture has room for.
_MOST_FAMILIES = 4
#: Lines that an eye tells apart.
_MOST_LINES = 6


def family_panels(ensembles: Sequence[Row]) -> list[FamilyPanel]:
    """Panels of the families of most sizes; what never succeeds has a success of 0 and no time to solution."""
    timed = [row for row in ensembles if math.isfinite(row["TTS99 s"])]
    names = _best_variants(timed)
    shown = [row for row in ensembles if row["solver"] in names]
    panels = []
    for family in _longest([(row["family"], row["N"]) for row in timed if row["solver"] in names]):
        lines = [[row for row in shown if (row["family"], row["solver"]) == (family, name)] for name in names]
        success = [_line(rows, "p median") for rows in lines if rows]
        times = [_line(rows, "TTS99 s", "TTS99 s low", "TTS99 s high") for rows in lines if rows]
        panels.append(FamilyPanel(family, success, times))
    return panels


def size_panels(rows: Sequence[Row], embeddings: Sequence[Row]) -> list[SizePanel]:
    """Panels of the families of most sizes: bits and couplers of the QUBOs, qubits of their embeddings."""
    written = [
        row | {"couplers": row["# Non-Zero Coefficients"] - row["# Decision Variables"]}
        for row in rows
        if row["encoding"] and row["# Non-Zero Coefficients"] is not None
    ]  # fmt: skip
    topologies = dict.fromkeys(row["topology"] for row in embeddings)
    columns = {
        "Bits": ("# Decision Variables", written),
        "Couplers": ("couplers", written),
        **{f"Qubits, {one}": ("qubits", [row for row in embeddings if row["topology"] == one]) for one in topologies},
    }
    panels = []
    for family in _longest([(family_of(row["Problem"]), row["N"]) for row in written]):
        lines: dict[str, list[Series]] = {}
        for quantity, (column, known) in columns.items():
            own = [row for row in known if family_of(row["Problem"]) == family]
            series = (
                median_series(encoding, [row for row in own if row["encoding"] == encoding], "N", column)
                for encoding in dict.fromkeys(row["encoding"] for row in own)
            )
            lines[quantity] = [one for one in series if one is not None]
        panels.append(SizePanel(family, lines))
    return panels


def _longest(sizes: Sequence[tuple[str, int]]) -> list[str]:
    """Of families and their sizes, the families of most sizes."""
    found: dict[str, set[int]] = {}
    for family, steps in sizes:
        found.setdefault(family, set()).add(steps)
    return sorted(found, key=lambda name: -len(found[name]))[:_MOST_FAMILIES]


def _line(rows: Sequence[Row], *columns: str) -> Series:
    return Series(rows[0]["solver"], *(np.array([row[name] for row in rows], dtype=float) for name in ("N", *columns)))


def _best_variants(ensembles: Sequence[Row]) -> list[str]:
    """For each solver the variant that solves the most instances, then with the higher success; of these the best."""
    score: dict[str, tuple[int, float]] = {}
    for row in ensembles:
        solved, chance = score.get(row["solver"], (0, 0.0))
        score[row["solver"]] = (solved + row["solved"], chance + row["p median"])
    best: dict[str, str] = {}
    for name in score:
        solver = name.partition(":")[0]
        best[solver] = max(best.get(solver, name), name, key=lambda one: score[one])
    chosen = sorted(best.values(), key=lambda one: score[one], reverse=True)[:_MOST_LINES]
    return [name for name in best.values() if name in chosen]
