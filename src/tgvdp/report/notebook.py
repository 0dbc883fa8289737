"""Results in notebooks: a picture with a table, and data frames."""

import base64
import html
import io
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from tgvdp.errors import MissingExtraError
from tgvdp.report.columns import decimals
from tgvdp.report.front_plots import energy_name, heading, plot_front
from tgvdp.report.style import Picture, clock, energy_scale
from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.runs.profile import REGIMES
from tgvdp.units import counted, joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult, SearchResult
    from tgvdp.runs.samples import Samples

_ROWS = 6
_DPI = 70


def front_frame(result: "SearchResult") -> Any:
    """Points of the front as a data frame.

    Raises
    ------
    MissingExtraError
        When pandas is not installed.
    """
    fastest, front = result.fastest, result.front
    unknown = np.full(len(front), np.nan)
    columns = {
        "time_s": front.time_s,
        "delay_s": front.time_s - fastest.time_s,
        "margin_pct": np.array([margin_pct(value, fastest.time_s) for value in front.time_s.tolist()]),
        "energy_kwh": np.array([joule_to_kwh(value) for value in front.energy_j.tolist()]),
        "saved_pct": np.array([saved_pct(value, fastest.energy_j) for value in front.energy_j.tolist()]),
        "price_kwh_per_min": unknown if result.price_kwh_per_min is None else result.price_kwh_per_min,
    }
    return _pandas().DataFrame(columns).rename_axis("id")


def samples_frame(samples: "Samples") -> Any:
    """Rows of a run as a data frame.

    Raises
    ------
    MissingExtraError
        When pandas is not installed.
    """
    columns = {**samples._asdict(), "regime": [REGIMES[code] for code in samples.regime.tolist()]}
    return _pandas().DataFrame(columns)


def _pandas() -> Any:
    try:
        return import_module("pandas")
    except ImportError:
        raise MissingExtraError("data frames need pandas: pip install 'tgvdp[tables]'") from None


def result_html(result: "SearchResult") -> str:
    """Name, picture of the front and a few of its points."""
    said = f"method {result.method}, {counted(len(result.front), 'point')}"
    fastest = result.fastest
    return _html(result, (fastest.time_s, fastest.energy_j), said, plot_front(result), "Energy saved over delay")


def journey_html(result: "JourneyResult") -> str:
    """Name, picture of the front beside today's practices, and a few of its points."""
    said = f"{counted(len(result.sections), 'section')}, {counted(len(result.front), 'point')}"
    fastest = (result.fastest_time_s, result.fastest_energy_j)
    return _html(result, fastest, said, result.plot("front"), "Energy over running time")


def _html(
    result: "SearchResult | JourneyResult", fastest: tuple[float, float], said: str, picture: Picture, shows: str
) -> str:
    """Name, picture and a few points of a front, beside the time, s, and energy, J, of the fastest run."""
    buffer = io.BytesIO()
    picture.savefig(buffer, format="png", dpi=_DPI)
    drawn = base64.b64encode(buffer.getvalue()).decode()
    (fastest_s, fastest_j), front = fastest, result.front
    chosen = np.unique(np.linspace(0, len(front) - 1, _ROWS).round().astype(int)).tolist()
    scale = energy_scale(float(np.abs(front.energy_j).max()))
    places = decimals((front.energy_j * scale.factor).tolist(), 5)
    rows = []
    for index in chosen:
        time_s, energy_j = float(front.time_s[index]), float(front.energy_j[index])
        cells = (
            f"{margin_pct(time_s, fastest_s):.1f} %", clock(time_s), f"{energy_j * scale.factor:.{places}f}",
            f"{saved_pct(energy_j, fastest_j):.1f} %",
        )  # fmt: skip
        rows.append("<tr>" + "".join(f'<td style="text-align:right">{cell}</td>' for cell in cells) + "</tr>")
    heads = ("margin", "time", f"{energy_name(result.trip)} ({scale.unit})", "saved")
    head = "".join(f'<th style="text-align:right">{html.escape(name)}</th>' for name in heads)
    notes = "".join(f"<p>{html.escape(warning)}</p>" for warning in result.warnings)
    return (
        f"<div><p><b>{html.escape(heading(result.trip))}</b>: {said}</p>"
        f'<img alt="{shows}" src="data:image/png;base64,{drawn}"/>'
        f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>{notes}</div>"
    )
