"""Several results side by side: the same margins, one table, one picture."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tgvdp.errors import InputError
from tgvdp.report import style
from tgvdp.report.plain import plain
from tgvdp.report.tables import SCHEMA as SEARCH_SCHEMA
from tgvdp.report.tables import saved_pct
from tgvdp.units import JOULE_PER_KWH

if TYPE_CHECKING:
    from tgvdp.report.columns import Columns

SCHEMA = "tgvdp.compare/1"
#: Margins that are compared where nobody names any, %.
MARGINS_PCT = (0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0)
#: Columns of ``compare.csv``.
COMPARE_COLUMNS = ("name", "margin_pct", "time_s", "energy_kwh", "saved_pct", "against_first_pct")
_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE, style.SKY, style.BLACK)
_DASHES = ("-", "--", ":", "-.")


def read_result(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the result.json of a folder that ``tgvdp search`` has written, or such a file.

    Raises
    ------
    InputError
        When there is none, or it is not of schema tgvdp.search/1.
    """
    path = Path(folder)
    path = path / "result.json" if path.is_dir() else path
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{path}: is not JSON: {error}") from None
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema != SEARCH_SCHEMA or "trip" not in content:
        raise InputError(f"{path}: must be a result of this tgvdp, schema {SEARCH_SCHEMA}, got {schema!r:.40}")
    return dict(content)


def names_of(contents: Sequence[Mapping[str, Any]], given: Sequence[str] = ()) -> list[str]:
    """Names of results: what tells them apart of train and line, or else the names that are given."""
    trains, tracks = ([content["trip"][part] for content in contents] for part in ("train", "track"))
    for names in (trains, tracks, [f"{train} on {track}" for train, track in zip(trains, tracks, strict=True)]):
        if len(set(names)) == len(names):
            return list(names)
    if given and len(set(given)) == len(given):
        return list(given)
    return [f"result {number}" for number in range(1, len(contents) + 1)]


def compare_object(
    contents: Sequence[Mapping[str, Any]], names: Sequence[str], margins_pct: Sequence[float] = MARGINS_PCT
) -> dict[str, Any]:
    """Compare results at equal margins.

    Parameters
    ----------
    contents : sequence of mapping
        Objects of schema tgvdp.search/1.
    names : sequence of str
    margins_pct : sequence of float
        Running time supplements, %, each over the fastest run of its own trip.

    Returns
    -------
    dict
        Schema tgvdp.compare/1; docs/results.md says what each field means. Between two points of a front a straight
        line is taken, which is not below the front.
    """
    runs, rows = [], []
    first: dict[float, float] = {}
    for name, content in zip(names, contents, strict=True):
        fastest = content["fastest"]
        time_s, energy_kwh = _front(content)
        model = content["energy"]
        runs.append(
            {
                "name": name,
                **{part: content["trip"][part] for part in ("train", "track", "origin_m", "destination_m")},
                "energy": model.get("map", model["model"]),
                "fastest_time_s": fastest["time_s"],
                "fastest_energy_kwh": fastest["energy_kwh"],
            }
        )
        for margin in margins_pct:
            at_s = fastest["time_s"] * (1.0 + margin / 100.0)
            # A front may end a hundredth of a second before the margin that was asked for.
            known = time_s[0] <= at_s <= time_s[-1] + 1e-3 * time_s[0]
            energy = float(np.interp(at_s, time_s, energy_kwh)) if known else None
            first.setdefault(margin, np.nan if energy is None else energy)
            rows.append(
                {
                    "name": name,
                    "margin_pct": margin,
                    "time_s": at_s,
                    "energy_kwh": energy,
                    "saved_pct": None if energy is None else saved_pct(energy, fastest["energy_kwh"]),
                    "against_first_pct": None if energy is None else -saved_pct(energy, first[margin]),
                }
            )
    content = {"schema": SCHEMA, "runs": runs, "rows": rows}
    if len({run["energy"] for run in runs}) > 1:
        content["warning"] = "the results count different energies: " + ", ".join(
            f"{run['name']} {run['energy']}" for run in runs
        )
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _front(content: Mapping[str, Any]) -> tuple[Any, Any]:
    """Running times and energies, the fastest run first."""
    points = [content["fastest"], *content["front"]]
    time_s = np.array([point["time_s"] for point in points])
    energy_kwh = np.array([point["energy_kwh"] for point in points])
    # On a grid the front begins well after the fastest run: no straight line leads from the one to the other.
    gap = content["method"] != "front" or time_s.size == 1
    return (time_s[1:], energy_kwh[1:]) if gap and time_s.size > 1 else (time_s, energy_kwh)


def compare_columns(content: Mapping[str, Any]) -> "Columns":
    """Columns of ``compare.csv``."""
    return {name: [row[name] for row in content["rows"]] for name in COMPARE_COLUMNS}


def plot_comparison(contents: Sequence[Mapping[str, Any]], names: Sequence[str]) -> style.Picture:
    """Draw the fronts of several results: energy saved over margin above, energy over running time below.

    Parameters
    ----------
    contents : sequence of mapping
        Objects of schema tgvdp.search/1.
    names : sequence of str

    Returns
    -------
    matplotlib.figure.Figure
    """
    height_in = 8.6
    figure = style.new_figure(height_in, bottom_in=0.62)
    upper, lower = figure.subplots(2, 1)
    figure.subplots_adjust(hspace=0.28)
    fronts = [_front(content) for content in contents]
    scale = style.time_scale(max(float(time_s.max()) for time_s, _ in fronts))
    energy = style.energy_scale(JOULE_PER_KWH * max(float(np.abs(kwh).max()) for _, kwh in fronts))
    for index, (content, name, (time_s, kwh)) in enumerate(zip(contents, names, fronts, strict=True)):
        fastest = content["fastest"]
        look = {
            "color": _COLORS[index % len(_COLORS)], "linestyle": _DASHES[index % len(_DASHES)], "linewidth": 2.0,
        }  # fmt: skip
        margin = 100.0 * (time_s / fastest["time_s"] - 1.0)
        upper.plot(margin, [saved_pct(value, fastest["energy_kwh"]) for value in kwh.tolist()], **look, label=name)
        lower.plot(time_s * scale.factor, kwh * JOULE_PER_KWH * energy.factor, **look)
        start = (fastest["time_s"] * scale.factor, fastest["energy_kwh"] * JOULE_PER_KWH * energy.factor)
        lower.plot(*start, "*", markersize=12, color=look["color"], markeredgecolor="white")
    style.dress(upper, "Running time supplement (%)", "Energy saved (%)")
    style.dress(lower, f"Running time ({scale.unit}); a star is the fastest run", f"Energy ({energy.unit})")
    lower.set_ylim(bottom=min(0.0, lower.get_ylim()[0]))
    upper.set_xlim(left=0.0)
    style.title(
        upper, "Who saves what at equal margins?", "Each against its own fastest run; below, the energies themselves"
    )
    style.legend(upper, "lower right")
    return figure
