"""The report of a finished sweep as files: a page, tables and pictures."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tgvdp.report.columns import to_csv
from tgvdp.report.pictures import encode
from tgvdp.report.plain import markdown_table, plain, to_json
from tgvdp.report.provenance import make_provenance, write_ledger
from tgvdp.report.style import Picture
from tgvdp.report.sweep_plots import Effect, plot_distribution, plot_map, plot_tornado
from tgvdp.sweeps.summary import (
    Level,
    Savings,
    axes_of_map,
    by_effect,
    grid,
    report_object,
    told_apart,
)

#: Axes that a tornado shows, and values of an axis that the page lists.
_AXES, _LISTED = 12, 12


def write_report(savings: Savings, source: Path, out: Path) -> tuple[dict[str, Any], list[Path]]:
    """Write the report of a sweep into a folder.

    Parameters
    ----------
    savings : Savings
    source : Path
        The sweep's folder.
    out : Path
        The report's.

    Returns
    -------
    dict
        Of schema tgvdp.sweep-report/1.
    list of Path
    """
    effects = savings._replace(axes=told_apart(savings.axes))
    content = plain(report_object(effects))
    provenance = make_provenance({"margin_pct": savings.margin_pct}, {"scenarios": source / "scenarios.parquet"}, 0.0)
    pictures = _pictures(effects, content)
    files = {
        "report.json": to_json(content),
        "report.md": _page(content, list(pictures)).encode(),
        "savings.csv": to_csv(_savings_columns(savings)),
        "sensitivity.csv": to_csv(_sensitivity_columns(content)),
        **{f"{name}.png": encode(figure, provenance) for name, figure in pictures.items()},
    }
    return content, write_ledger(out, files, provenance)


def _savings_columns(savings: Savings) -> dict[str, Any]:
    """Columns of ``savings.csv``: a row per scenario."""
    return {
        "scenario": savings.number.tolist(),
        **savings.axes,
        "fastest_energy_kwh": savings.fastest_kwh.tolist(),
        "energy_kwh": savings.energy_kwh.tolist(),
        "saved_kwh": savings.saved_kwh.tolist(),
        "saved_pct": savings.saved_pct.tolist(),
        "at_most_above_pct": savings.at_most_above_pct.tolist(),
    }


def _sensitivity_columns(content: Mapping[str, Any]) -> dict[str, Any]:
    """Columns of ``sensitivity.csv``: a row per value of each axis."""
    rows = [{"axis": one["axis"], **level} for one in content["sensitivity"] for level in one["levels"]]
    names = ("axis", *Level._fields)
    return {name: [str(row[name]) if name == "value" else row[name] for row in rows] for name in names}


def _pictures(savings: Savings, content: Mapping[str, Any]) -> dict[str, Picture]:
    margin_pct, network = savings.margin_pct, content["network"]
    detail = f"{len(savings.number)} scenarios, {network['saved_pct']:.1f} % altogether"
    pictures = {"distribution": plot_distribution(savings.saved_pct, margin_pct, detail)}
    ranked = by_effect(savings)
    effects = []
    for axis, found in ranked[:_AXES]:
        low, high = min(found, key=lambda one: one.saved_pct), max(found, key=lambda one: one.saved_pct)
        effects.append(Effect(axis, low.saved_pct, high.saved_pct, low.value, high.value))
    if effects:
        pictures["tornado"] = plot_tornado(effects, network["saved_pct"], margin_pct, detail)
    maps = {
        "map": axes_of_map(savings),
        "network": [axis for axis in ("train", "line") if axis in savings.axes],
    }
    for name, axes in maps.items():
        if len(axes) == 2 and axes not in [drawn for other, drawn in maps.items() if other in pictures]:
            made = grid(savings, *axes)
            rows, columns = (made.row_axis, made.rows), (made.column_axis, made.columns)
            pictures[name] = plot_map(made.saved_pct, rows, columns, margin_pct)
    return pictures


def _page(content: Mapping[str, Any], pictures: list[str]) -> str:
    network = content["network"]
    counts = ", ".join(f"{count} {status}" for status, count in content["scenarios"].items())
    lines = [
        f"# What {content['margin_pct']:g} % more running time saves",
        "",
        f"{network['saved_kwh']:.6g} of {network['fastest_kwh']:.6g} kWh, {network['saved_pct']:.2f} %, over all"
        f" scenarios that are done ({counts}).",
        "",
        markdown_table([{"share of the scenarios below": f"{share} %", "saved %": value}
                        for share, value in content["distribution_pct"].items()]),
    ]  # fmt: skip
    if "warning" in content:
        lines += [f"Warning: {content['warning']}.", ""]
    for note in content.get("notes", ()):
        lines += [f"Note: {note}.", ""]
    for one in content["sensitivity"]:
        rows = [
            {one["axis"]: str(level["value"]), "scenarios": level["scenarios"], "fastest kWh": level["fastest_kwh"],
             "saved kWh": level["saved_kwh"], "saved %": level["saved_pct"]}
            for level in one["levels"][:_LISTED]
        ]  # fmt: skip
        more = len(one["levels"]) - len(rows)
        note = [f"and {more} more in sensitivity.csv", ""] if more else []
        lines += [f"## By {one['axis']}: {one['span_pct']:.2f} points between lowest and highest", ""]
        lines += [markdown_table(rows), *note]
    lines += [f"![{name}]({name}.png)" for name in pictures]
    return "\n".join(lines) + "\n"
