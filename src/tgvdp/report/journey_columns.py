"""Tables of a journey, from the object that `report.journeys` makes of it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.report.tables import margin_pct, saved_pct

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.report.columns import Columns


def front_columns(result: "JourneyResult", content: Mapping[str, Any]) -> "Columns":
    """Columns of ``front.csv``: each point, its bound where there is one, and what the practices take at its time."""
    points = content["front"]
    columns: dict[str, list[Any]] = {
        "margin_pct": [margin_pct(point["time_s"], result.fastest_time_s) for point in points],
        "time_s": [point["time_s"] for point in points],
        "energy_kwh": [point["energy_kwh"] for point in points],
        "saved_pct": [saved_pct(float(energy_j), result.fastest_energy_j) for energy_j in result.front.energy_j],
        "price_kwh_per_min": [point["price_kwh_per_min"] for point in points],
    }
    if not result.windows.are_open:
        columns["waiting_s"] = [point["waiting"]["time_s"] for point in points]
        columns["waiting_kwh"] = [point["waiting"]["energy_kwh"] for point in points]
    for name in ("lower_bound_kwh", "gap_pct"):
        if name in points[0]:
            columns[name] = [point[name] for point in points]
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
    names = dict.fromkeys(name for row in rows for name in row)  # not all ends have a name
    return {name: [row.get(name) for row in rows] for name in names}


def robustness_columns(rows: Sequence[Mapping[str, Any]]) -> "Columns":
    """Columns of ``robustness.csv``: an allocation per row."""
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    return columns | {"on_the_second_front": [str(on).lower() for on in columns["on_the_second_front"]]}
