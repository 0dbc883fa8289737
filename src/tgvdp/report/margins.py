"""Margins side by side as an object and as a table."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api.margins import Margins
    from tgvdp.report.columns import Columns


def margins_object(asked: Sequence[str], margins: Sequence["Margins"]) -> list[dict[str, Any]]:
    """Objects of running-time supplements, as they were asked for; docs/journeys.md says what each field means."""
    return [
        {
            "margin": text,
            "within_pct": 100.0 * one.within,
            "runs": [
                {
                    "name": name,
                    "margin_pct": margin_pct(one.time_s[name], one.fastest_s),
                    "time_s": one.time_s[name],
                    "energy_kwh": joule_to_kwh(one.energy_j[name]),
                    "above_optimum_pct": 0.0 - saved_pct(one.energy_j[name], one.energy_j["optimum"]),
                    "deviation_s": one.deviation_s[name],
                }
                for name in one.runs
            ],
        }
        for text, one in zip(asked, margins, strict=True)
    ]


def margins_columns(content: Sequence[dict[str, Any]]) -> "Columns":
    """Columns of ``margins.csv``: a row for each supplement and way of taking it."""
    rows = [{"margin": one["margin"].replace(",", ";"), **run} for one in content for run in one["runs"]]
    return {name: [row[name] for row in rows] for name in rows[0]}
