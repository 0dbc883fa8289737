"""What of a run can be dragged on the page: the mass, and speed limits where the trip meets them."""

from typing import TYPE_CHECKING, Any

from tgvdp.units import KILO, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.model.track import Track
    from tgvdp.model.trip import Trip


def editable_of(trip: "Trip", track: "Track", mass_kg: float, *, reverse: bool) -> dict[str, Any]:
    """Describe what can be edited, at the places where the page shows it.

    Parameters
    ----------
    trip : Trip
        As it was searched.
    track : Track
        The line as its file has it, edits included: in its own direction, without speed restrictions.
    mass_kg : float
        Mass of the train before edits, kg.
    reverse : bool
        Whether the trip runs against the direction of the file.

    Returns
    -------
    dict
        ``limits`` has the rows of the line that the trip meets, in its order; positions count as in its pictures,
        ``row`` as in the file.
    """
    rows = track.speed_limits
    ends_m = [*(row.position_m for row in rows[1:]), track.length_m]
    limits = []
    for index, (row, end_m) in enumerate(zip(rows, ends_m, strict=True)):
        stretch_m = (row.position_m, end_m)
        from_m, to_m = sorted(track.length_m - at_m for at_m in stretch_m) if reverse else stretch_m
        if to_m > trip.origin_m and from_m < trip.destination_m:
            limits.append(
                {
                    "row": index,
                    "from_m": max(from_m, trip.origin_m),
                    "to_m": min(to_m, trip.destination_m),
                    "now_kmh": mps_to_kmh(row.speed_mps),
                }
            )
    return {
        "mass_t": mass_kg / KILO,
        "mass_now_t": trip.train.mass_kg / KILO,
        "top_kmh": mps_to_kmh(trip.train.max_speed_mps),
        "limits": sorted(limits, key=lambda limit: limit["from_m"]),
    }
