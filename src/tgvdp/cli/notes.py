"""What ``tgvdp search`` says about its input and result, a line each: what does not act, and what looks like a slip."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.units import counted, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.model.track import Track
    from tgvdp.model.train import Train
    from tgvdp.model.trip import Trip

#: From this gap on, in percent, a point is not as good as proven; and further below its bound than this is no rounding.
_LARGE_GAP_PCT = 0.1
_BELOW_PCT = 0.01
#: So many notes of readers are shown, and so much of each: a railML file may have dozens.
_REMARKS = 4
_LONGEST_REMARK = 240
#: Speeds that differ by less differ by rounding.
_SAME_MPS = 1e-9


def unusual(train: "Train", track: "Track") -> Iterator[str]:
    """Figures outside the ranges that they usually lie in."""
    from tgvdp.formats.review.plausibility import check_text, check_track, check_train

    for kind, owner, checks in (("train", train, check_train(train)), ("track", track, check_track(track))):
        for check in checks:
            if not check.ok:
                yield f"{kind} {owner.name}: {check_text(check)}"


def remarked(remarks: Sequence[str]) -> Iterator[str]:
    """What the readers of files noted, which `tgvdp validate` says in full: what is not used, and what was assumed."""
    shown = remarks if len(remarks) <= _REMARKS else remarks[: _REMARKS - 1]
    for remark in shown:
        yield remark if len(remark) <= _LONGEST_REMARK else f"{remark[:_LONGEST_REMARK]}…"
    if len(shown) < len(remarks):
        yield f"{len(remarks) - len(shown)} more notes on what was read: tgvdp validate tells them"


def idle_restrictions(trip: "Trip", restrictions: Sequence[tuple[float, float, float]]) -> Iterator[str]:
    """Say which speed restrictions (from, to, m; speed, m/s) of a trip make nothing slower."""
    limits = trip.track.speed_limits
    ends_m = [*(row.position_m for row in limits[1:]), trip.track.length_m]
    for from_m, to_m, speed_mps in restrictions:
        low_m, high_m = max(from_m, trip.origin_m), min(to_m, trip.destination_m)
        held_mps = [
            row.speed_mps
            for row, end_m in zip(limits, ends_m, strict=True)
            if row.position_m < high_m and end_m > low_m
        ]
        where = f"the speed restriction from {from_m:.12g} to {to_m:.12g} m"
        if low_m >= high_m:
            yield f"{where} lies outside the trip"
        elif min(max(held_mps), trip.train.max_speed_mps) < speed_mps - _SAME_MPS:
            yield f"{where} changes nothing: {mps_to_kmh(speed_mps):.6g} km/h are not reached there anyway"


def idle(trip: "Trip") -> Iterator[str]:
    """What the line holds between origin and destination and the search passes over."""
    track, convention = trip.track, trip.convention

    def on_the_way(from_m: float, to_m: float) -> bool:
        return from_m < trip.destination_m and to_m > trip.origin_m

    stops = sum(trip.origin_m < stop_m < trip.destination_m for stop_m in track.stops_m)
    if stops:
        are = "is" if stops == 1 else "are"
        yield f"{counted(stops, 'stop')} between origin and destination {are} passed: tgvdp journey stops there"
    ends_m = [*(row.position_m for row in track.curves[1:]), track.length_m]
    curves = sum(
        on_the_way(row.position_m, end_m) and not math.isinf(min(abs(row.radius_start_m), abs(row.radius_end_m)))
        for row, end_m in zip(track.curves, ends_m if track.curves else (), strict=True)
    )
    if curves and convention.curves == "none":
        yield f"{counted(curves, 'curve')} of the line {_acts(curves)} nothing: --curves is none"
    tunnels = sum(on_the_way(row.position_m, row.position_m + row.length_m) for row in track.tunnels)
    if tunnels and not convention.tunnels:
        yield f"{counted(tunnels, 'tunnel')} of the line {_acts(tunnels)} nothing without --tunnels"
    elif tunnels and not trip.train.tunnel_drag:
        without = f"train {trip.train.name} has no tunnel drag"
        yield f"{counted(tunnels, 'tunnel')} of the line {_acts(tunnels)} nothing: {without}"


def large_gaps(content: Mapping[str, Any]) -> Iterator[str]:
    """Points that may be far from the optimum, or are below their bound, of an object of schema tgvdp.search/1."""
    front = [point for point in content["front"] if point["gap_pct"] is not None]
    points = counted(len(content["front"]), "point")
    large = [point for point in front if point["gap_pct"] > _LARGE_GAP_PCT]
    if large:
        worst = max(large, key=lambda point: float(point["gap_pct"]))
        energy_kwh = worst["energy_kwh"] - worst["lower_bound_kwh"]
        yield (
            f"{len(large)} of {points} may be more than {_LARGE_GAP_PCT:g} % above the optimum, "
            f"at most {worst['gap_pct']:.3g} % ({energy_kwh:.3g} kWh) at margin {worst['margin_pct']:.2f} %"
        )
    below = [point["gap_pct"] for point in front if point["gap_pct"] < -_BELOW_PCT]
    if below:
        yield (
            f"{len(below)} of {points} are below their lower bound, by {-min(below):.2g} % at most: "
            "it is one of a line whose resistance is constant between breaks"
        )


def _acts(count: int) -> str:
    return "counts" if count == 1 else "count"
