"""What the picture of success shows: small multiples by family, of each solver the variant that does best."""

import math
from collections.abc import Sequence

import numpy as np

from tgvdp.report.trial_plots import FamilyPanel, Series
from tgvdp.trials.rows import Row

#: Families that a picture has room for.
_MOST_FAMILIES = 4
#: Lines that an eye tells apart.
_MOST_LINES = 6


def family_panels(ensembles: Sequence[Row]) -> list[FamilyPanel]:
    """Panels of the families of most sizes; rows without a time to solution are left out."""
    ensembles = [row for row in ensembles if math.isfinite(row["TTS99 s"])]
    sizes: dict[str, set[int]] = {}
    for row in ensembles:
        sizes.setdefault(row["family"], set()).add(row["N"])
    shown = _best_variants(ensembles)
    panels = []
    for family in sorted(sizes, key=lambda name: -len(sizes[name]))[:_MOST_FAMILIES]:
        lines = [[row for row in ensembles if (row["family"], row["solver"]) == (family, name)] for name in shown]
        success = [_line(rows, "p median") for rows in lines if rows]
        times = [_line(rows, "TTS99 s", "TTS99 s low", "TTS99 s high") for rows in lines if rows]
        panels.append(FamilyPanel(family, success, times))
    return panels


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
