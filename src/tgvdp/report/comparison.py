"""Several results side by side: the same margins, one table, one picture."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from tgvdp.errors import InputError
from tgvdp.report import palette, style
from tgvdp.report.plain import plain
from tgvdp.report.read_off import TELLING_PCT, Front
from tgvdp.report.tables import SCHEMA as SEARCH_SCHEMA
from tgvdp.report.tables import saved_pct
from tgvdp.report.written import read_object, require_schema
from tgvdp.units import JOULE_PER_KWH, KILO

if TYPE_CHECKING:
    from tgvdp.report.columns import Columns

SCHEMA = "tgvdp.compare/1"
#: Margins that are compared where nobody names any, %.
MARGINS_PCT = (0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0)
#: Columns of ``compare.csv``.
COMPARE_COLUMNS = ("name", "margin_pct", "time_s", "energy_kwh", "saved_pct", "against_first_pct", "at_most_above_pct")
_COLORS = (palette.BLUE, palette.VERMILION, palette.GREEN, palette.PURPLE, palette.ORANGE, palette.SKY, palette.BLACK)
_DASHES = ("-", "--", ":", "-.")
#: What a folder of results is read by.
_MAIN = "result.json"


class _Trip(msgspec.Struct):
    train: str
    track: str
    origin_m: float
    destination_m: float


class _Energy(msgspec.Struct):
    model: str


class _Point(msgspec.Struct):
    time_s: float
    energy_kwh: float


class _Result(msgspec.Struct):
    """What is read of a result.json; all else that it holds passes."""

    method: str
    trip: _Trip
    energy: _Energy
    fastest: _Point
    front: list[_Point]


def read_result(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the result.json of a folder that ``tgvdp search`` has written, or such a file.

    Raises
    ------
    InputError
        When there is none, it is not of schema tgvdp.search/1, or lacks a field that is compared.
    """
    path = Path(folder)
    if path.is_dir() and not (path / _MAIN).exists():
        raise InputError(f"{path}: holds no {_MAIN}, which tgvdp search writes")
    path = path / _MAIN if path.is_dir() else path
    content = read_object(path)
    require_schema(path, content, SEARCH_SCHEMA)
    try:
        msgspec.convert(content, _Result)
    except msgspec.ValidationError as error:
        raise InputError(f"{path}: is no whole result: {error}") from None
    return content


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
        line is taken, which is not below the front; ``at_most_above_pct`` says how far it can be above, and ``warning``
        where that is much.
    """
    runs, rows = [], []
    first: dict[float, float] = {}
    for name, content in zip(names, contents, strict=True):
        fastest = content["fastest"]
        front = _front(content)
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
            read = front.at(at_s)
            energy = None if read is None else read.energy_kwh
            first.setdefault(margin, np.nan if energy is None else energy)
            rows.append(
                {
                    "name": name,
                    "margin_pct": margin,
                    "time_s": at_s,
                    "energy_kwh": energy,
                    "saved_pct": None if energy is None else saved_pct(energy, fastest["energy_kwh"]),
                    "against_first_pct": None if energy is None else 0.0 - saved_pct(energy, first[margin]),
                    "at_most_above_pct": None if read is None else read.at_most_above_pct,
                }
            )
    content = {"schema": SCHEMA, "runs": runs, "rows": rows}
    if warnings := _warnings(runs, rows):
        content["warning"] = "; ".join(warnings)
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _warnings(runs: Sequence[Mapping[str, Any]], rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What figures beside each other do not say."""
    warnings = []
    if len({run["energy"] for run in runs}) > 1:
        counted = ", ".join(f"{run['name']} {run['energy']}" for run in runs)
        warnings.append(f"the results count different energies: {counted}")
    above_pct = max((row["at_most_above_pct"] or 0.0 for row in rows), default=0.0)
    if above_pct > TELLING_PCT:
        warnings.append(
            f"margins between two points of a front are read off a straight line, which may be {above_pct:.2g} % too"
            " dear: --at puts points there"
        )
    return warnings


def differences(contents: Sequence[Mapping[str, Any]]) -> str:
    """Say in what the trips of objects of schema tgvdp.search/1 differ; empty where they do in nothing.

    Results of folders need not be of what somebody believes them to be of.
    """
    trips = [content["trip"] for content in contents]
    fields = [content.get("provenance", {}).get("options", {}).get("set", []) for content in contents]
    values = {
        "trains": [trip["train"] for trip in trips],
        "lines": [trip["track"] for trip in trips],
        "stretches": [f"{trip['origin_m'] / KILO:.6g} to {trip['destination_m'] / KILO:.6g} km" for trip in trips],
        "fields set": [", ".join(changes) or "none" for changes in fields],
    }
    told = {name: one for name, every in values.items() if len(one := dict.fromkeys(every)) > 1}
    if not told:
        return ""
    parts = " and ".join(f"{name} ({', '.join(one)})" for name, one in told.items())
    beware = "" if not {"lines", "stretches"} & set(told) else ": their shares compare, their energies do not"
    return f"the results are of different {parts}{beware}"


def _front(content: Mapping[str, Any]) -> Front:
    """The front of a result."""
    points = [content["fastest"], *content["front"]]
    names = ("time_s", "energy_kwh", "price_kwh_per_min")
    columns = (np.array([point.get(name) for point in points], dtype=np.float64) for name in names)
    front = Front(*columns)
    # On a grid the front begins well after the fastest run: no straight line leads from the one to the other.
    gap = content["method"] != "front" and len(points) > 1
    return Front(*(column[1:] for column in front)) if gap else front


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
    scale = style.time_scale(max(float(front.time_s.max()) for front in fronts))
    energy = style.energy_scale(JOULE_PER_KWH * max(float(np.abs(front.energy_kwh).max()) for front in fronts))
    for index, (content, name, (time_s, kwh, _)) in enumerate(zip(contents, names, fronts, strict=True)):
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
