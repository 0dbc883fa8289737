"""A journey as an object and as files."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tgvdp.report.columns import to_csv
from tgvdp.report.plain import plain
from tgvdp.report.provenance import Input, make_provenance
from tgvdp.report.results import to_json, write_ledger
from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.journeys.bound import JourneyBound
    from tgvdp.report.columns import Columns

SCHEMA = "tgvdp.journey/1"


def journey_object(result: "JourneyResult") -> dict[str, Any]:
    """Build the object of schema tgvdp.journey/1; docs/journeys.md says what each field means."""
    front = result.front
    points = zip(
        front.time_s, front.energy_j, result.price_kwh_per_min, result.section_time_s, result.section_energy_j,
        strict=True,
    )  # fmt: skip
    content = {
        "schema": SCHEMA,
        "sections": [
            {
                "from_m": section.trip.origin_m,
                "to_m": section.trip.destination_m,
                "fastest_time_s": section.fastest.duration_s,
            }
            for section in result.sections
        ],
        "front": [
            {**_figures(time_s, energy_j), "price_kwh_per_min": price, "sections": list(map(_figures, own_s, own_j))}
            for time_s, energy_j, price, own_s, own_j in points
        ],
        "practices": {
            name: list(map(_figures, practice.time_s, practice.energy_j))
            for name, practice in result.found.practices.items()
        },
    }
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _figures(time_s: float, energy_j: float) -> dict[str, float]:
    return {"time_s": float(time_s), "energy_kwh": joule_to_kwh(float(energy_j))}


def front_columns(
    result: "JourneyResult", content: Mapping[str, Any], bound: "JourneyBound | None" = None
) -> "Columns":
    """Columns of ``front.csv``: each point, its bound where there is one, and what the practices take at its time."""
    points = content["front"]
    columns: dict[str, list[Any]] = {
        "margin_pct": [margin_pct(point["time_s"], result.fastest_time_s) for point in points],
        "time_s": [point["time_s"] for point in points],
        "energy_kwh": [point["energy_kwh"] for point in points],
        "saved_pct": [saved_pct(float(energy_j), result.fastest_energy_j) for energy_j in result.front.energy_j],
        "price_kwh_per_min": [point["price_kwh_per_min"] for point in points],
    }
    if bound is not None:
        columns["lower_bound_kwh"] = [joule_to_kwh(bound_j) for bound_j in bound.lower_bound_j.tolist()]
        columns["gap_pct"] = bound.gap_pct(result.front.energy_j).tolist()
    for name, practice in content["practices"].items():
        columns[f"{name}_kwh"] = [row["energy_kwh"] for row in practice]
    return columns


def allocation_columns(content: Mapping[str, Any]) -> "Columns":
    """Columns of ``allocation.csv``: what each section gets at each point."""
    rows = [
        {"point": number, "section": place, **section, **own}
        for number, point in enumerate(content["front"], start=1)
        for place, (section, own) in enumerate(zip(content["sections"], point["sections"], strict=True), start=1)
    ]
    return {name: [row[name] for row in rows] for name in rows[0]}


def write_journey(
    result: "JourneyResult",
    out_dir: str | os.PathLike[str],
    provenance: Mapping[str, Any] | None = None,
    bound: "JourneyBound | None" = None,
    *,
    pictures: bool = True,
) -> list[Path]:
    """Write all files of a journey into a folder, all or none.

    Parameters
    ----------
    result : JourneyResult
    out_dir : path
        Made when absent; files of an earlier run are replaced.
    provenance : mapping, optional
        As `make_provenance` returns it; by default of the result itself.
    bound : JourneyBound, optional
        Of ``result.certify()``; without it front.csv holds no bounds.
    pictures : bool

    Raises
    ------
    InputError
        When the folder cannot be written.
    """
    trip = result.trip
    if provenance is None:
        inputs: dict[str, Input] = {"train": trip.train, "track": trip.track}
        provenance = make_provenance(result.options, inputs, result.elapsed_s)
    content = journey_object(result)
    files = {
        "journey.json": to_json(content),
        "front.csv": to_csv(front_columns(result, content, bound)),
        "allocation.csv": to_csv(allocation_columns(content)),
    }
    if pictures:
        # Here, so that whoever wants no picture does not wait for matplotlib.
        from tgvdp.report.journey_plots import PICTURES, draw
        from tgvdp.report.pictures import encode

        files |= {f"{name}.png": encode(draw(result, name), provenance) for name in PICTURES}
    return write_ledger(out_dir, files, provenance)
