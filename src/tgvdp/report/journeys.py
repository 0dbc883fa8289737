"""A journey as an object and as files."""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.report.advice import journey_advice, names_of, step_columns
from tgvdp.report.columns import to_csv
from tgvdp.report.journey_columns import allocation_columns, front_columns, robustness_columns
from tgvdp.report.margins import margins_columns, margins_object
from tgvdp.report.plain import plain, to_json
from tgvdp.report.provenance import Input, make_provenance, write_ledger
from tgvdp.report.tables import margin_pct
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.api.margins import Margins
    from tgvdp.journeys.bound import JourneyBound
    from tgvdp.journeys.delays import Robustness

SCHEMA = "tgvdp.journey/1"
#: A front may end a hundredth of a second before the margin that was asked for.
_MARGIN_SLACK_PCT = 0.1


class Extras(NamedTuple):
    """What stands beside a journey where it is asked for.

    Attributes
    ----------
    bound : JourneyBound, optional
        Of ``result.certify()``: adds bounds to front.csv and journey.json.
    robustness : Robustness, optional
        Of ``result.robustness()``: adds robustness.csv, its picture, and robustness to journey.json.
    margins : mapping of str to Margins
        Of ``result.margins()``, as they were asked for: adds margins.csv, its picture, and margins to journey.json.
    ended : tuple of str
        What else the time limit ended, for people: part of ``warning`` in journey.json.
    beside : mapping of str to bytes
        More files, by their names, such as the advice of the run in the format that its line came in.
    """

    bound: "JourneyBound | None" = None
    robustness: "Robustness | None" = None
    margins: Mapping[str, "Margins"] = MappingProxyType({})
    ended: tuple[str, ...] = ()
    beside: Mapping[str, bytes] = MappingProxyType({})


NO_EXTRAS = Extras()


class JourneyFiles(NamedTuple):
    """What was written: the files, the object that journey.json holds, and what the time limit ended, for people."""

    files: list[Path]
    content: dict[str, Any]
    ended: tuple[str, ...]


def journey_object(
    result: "JourneyResult", extras: Extras = NO_EXTRAS, expired: Callable[[], bool] = bool
) -> dict[str, Any]:
    """Build the object of schema tgvdp.journey/1; docs/journeys.md says what each field means.

    Without ``practices.linear_margin`` and ``advice`` where the time for them is up.
    """
    front = result.front
    points = zip(
        front.time_s, front.energy_j, result.price_kwh_per_min, result.section_time_s, result.section_energy_j,
        strict=True,
    )  # fmt: skip
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "sections": [
            {
                "from_m": section.trip.origin_m,
                "to_m": section.trip.destination_m,
                **names_of(section.trip),
                "fastest_time_s": section.fastest.duration_s,
            }
            for section in result.sections
        ],
        "fastest": _figures(result.fastest_time_s, result.fastest_energy_j),
        "front": [
            {**_figures(time_s, energy_j), "price_kwh_per_min": price, "sections": list(map(_figures, own_s, own_j))}
            for time_s, energy_j, price, own_s, own_j in points
        ],
        "practices": {
            name: list(map(_figures, practice.time_s, practice.energy_j))
            for name, practice in result.found.practices.items()
        },
        "complete": result.found.complete,
    }
    if not result.windows.are_open:
        for point, waiting_s in zip(content["front"], result.found.waiting_s, strict=True):
            point["waiting"] = _figures(waiting_s, result.found.waiting_w * waiting_s)
    elif not expired():
        content["practices"]["linear_margin"] = list(map(_figures, front.time_s, result.linear_margin_j))
    if extras.bound is not None:
        gaps_pct = extras.bound.gap_pct(front.energy_j).tolist()
        for point, bound_j, gap_pct in zip(
            content["front"], extras.bound.lower_bound_j.tolist(), gaps_pct, strict=True
        ):
            point |= {"lower_bound_kwh": joule_to_kwh(bound_j), "gap_pct": gap_pct}
    if not expired():
        content["advice"] = journey_advice(result)
    if extras.robustness is not None:
        content["robustness"] = _robustness_rows(extras.robustness)
    if extras.margins:
        content["margins"] = margins_object(list(extras.margins), list(extras.margins.values()))
    if warnings := (*result.warnings, *extras.ended):
        content["warning"] = "; ".join(warnings)
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _figures(time_s: float, energy_j: float) -> dict[str, float]:
    return {"time_s": float(time_s), "energy_kwh": joule_to_kwh(float(energy_j))}


def _robustness_rows(robustness: "Robustness") -> list[dict[str, Any]]:
    """What each allocation is planned and expected to take."""
    return [
        {
            "allocation": name,
            "planned_kwh": joule_to_kwh(float(robustness.planned_j[at])),
            "expected_kwh": joule_to_kwh(float(robustness.energy_j[at])),
            "expected_delay_s": float(robustness.delay_s[at]),
            "punctual_pct": 100.0 * float(robustness.punctual[at]),
            "on_the_second_front": at in robustness.front.source,
        }
        for at, name in enumerate(robustness.names)
    ]


def write_journey(
    result: "JourneyResult",
    out_dir: str | os.PathLike[str],
    provenance: Mapping[str, Any] | None = None,
    extras: Extras = NO_EXTRAS,
    *,
    pictures: bool = True,
    expired: Callable[[], bool] = bool,
) -> JourneyFiles:
    """Write all files of a journey into a folder, all or none.

    Parameters
    ----------
    result : JourneyResult
    out_dir : path
        Made when absent; files of an earlier run are replaced.
    provenance : mapping, optional
        As `make_provenance` returns it; by default of the result itself.
    extras : Extras
    pictures : bool
    expired : callable, optional
        Whether the time is up: no picture is begun then.

    Raises
    ------
    InputError
        When the folder cannot be written.
    """
    trip = result.trip
    if provenance is None:
        inputs: dict[str, Input] = {"train": trip.train, "track": trip.track}
        provenance = make_provenance(result.options, inputs, result.elapsed_s)
    drawn = _drawn(result, provenance, extras, expired) if pictures else {}
    if undrawn := sum(picture is None for picture in drawn.values()):
        extras = extras._replace(ended=(*extras.ended, f"the time limit left no time for {undrawn} pictures"))
    content = journey_object(result, extras, expired)
    files = {
        "journey.json": to_json(content),
        "front.csv": to_csv(front_columns(result, content)),
        "allocation.csv": to_csv(allocation_columns(content)),
    }
    if "advice" in content:
        sections = content["advice"]["sections"]
        steps = ((str(number), one["steps"]) for number, one in enumerate(sections, 1))
        files["advice.csv"] = to_csv(step_columns(steps, "section"))
    if extras.robustness is not None:
        files["robustness.csv"] = to_csv(robustness_columns(content["robustness"]))
    if extras.margins:
        files["margins.csv"] = to_csv(margins_columns(content["margins"]))
    files |= extras.beside
    files |= {name: picture for name, picture in drawn.items() if picture is not None}
    return JourneyFiles(write_ledger(out_dir, files, provenance), content, extras.ended)


def _drawn(
    result: "JourneyResult", provenance: Mapping[str, Any], extras: Extras, expired: Callable[[], bool]
) -> dict[str, bytes | None]:
    """Pictures by name; None where the time was up before one was begun."""
    # Here, so that whoever wants no picture does not wait for matplotlib.
    from tgvdp.report.journey_plots import PICTURES, draw, plot_robustness
    from tgvdp.report.margin_plots import plot_margins
    from tgvdp.report.pictures import encode

    plots: dict[str, Callable[[], Any]] = {name: partial(draw, result, name) for name in PICTURES}
    if extras.robustness is not None:
        plots["robustness"] = partial(plot_robustness, result, extras.robustness)
    if extras.margins:
        plots["margins"] = partial(plot_margins, list(extras.margins.values()))
    return {f"{name}.png": None if expired() else encode(plot(), provenance) for name, plot in plots.items()}


def trains_object(results: Sequence["JourneyResult"]) -> dict[str, Any]:
    """Compare the journeys of several trains at equal margins: an object of schema tgvdp.compare/1.

    With windows margins count from each train's earliest journey.
    """
    from tgvdp.report.comparison import MARGINS_PCT, compare_object, names_of

    contents = list(map(_comparable, results))
    reach_pct = min(margin_pct(one["front"][-1]["time_s"], one["fastest"]["time_s"]) for one in contents)
    asked_pct = tuple(100.0 * margin for margin in results[0].options["at_margin"]) or MARGINS_PCT
    margins_pct = [margin for margin in asked_pct if margin <= reach_pct + _MARGIN_SLACK_PCT] or [0.0]
    return compare_object(contents, names_of(contents), margins_pct)


def write_trains(
    results: Sequence["JourneyResult"], out_dir: str | os.PathLike[str], beneath: Sequence[Path]
) -> list[Path]:
    """Write the comparison of several trains: an object, a table and a picture; their own files lie beneath.

    Raises
    ------
    InputError
        When the folder cannot be written.
    """
    from tgvdp.report.comparison import compare_columns, names_of, plot_comparison
    from tgvdp.report.pictures import encode

    contents = list(map(_comparable, results))
    inputs = {f"train-{number}": one.trip.train for number, one in enumerate(results, start=1)}
    options = results[0].options
    provenance = make_provenance(
        options, {**inputs, "track": results[0].trip.track}, sum(one.elapsed_s for one in results)
    )
    content = trains_object(results)
    files = {
        "compare.json": to_json({**content, "provenance": provenance}),
        "compare.csv": to_csv(compare_columns(content)),
        "compare.png": encode(plot_comparison(contents, names_of(contents)), provenance),
    }
    return write_ledger(out_dir, files, provenance, beneath)


def _comparable(result: "JourneyResult") -> dict[str, Any]:
    """What a comparison reads of a result, the fastest journey first."""
    trip = result.trip
    points: list[dict[str, Any]] = list(map(_figures, result.front.time_s, result.front.energy_j))
    fastest = points[0]  # ... that windows allow, whose prices are not those of running times
    if result.windows.are_open:
        fastest = _figures(result.fastest_time_s, result.fastest_energy_j)
        for point, price in zip(points, result.price_kwh_per_min.tolist(), strict=True):
            point["price_kwh_per_min"] = price if math.isfinite(price) else None  # of the fastest journey
    return {
        "method": "front",
        "trip": {
            "train": trip.train.name,
            "track": trip.track.name,
            "origin_m": trip.origin_m,
            "destination_m": trip.destination_m,
        },
        "energy": {"model": trip.energy.kind if trip.energy.map is None else trip.energy.map.name},
        "fastest": fastest,
        "front": points,
    }
