"""Speed limits of a journey: static profiles of its segments, Swiss line speeds, and what lowers them for a time.

Speeds are in km/h. Where several hold the lowest one counts.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from tgvdp.formats.sfera.category import Category, millimetres
from tgvdp.formats.sfera.segments import Cap, Segment, lowest
from tgvdp.formats.sfera.swiss import swiss_speeds
from tgvdp.formats.syntax.xml import Node, counted
from tgvdp.model.track import SpeedLimit
from tgvdp.units import kmh_to_mps

#: How to run over a line of which the file does not say how fast.
_HINT = "--line-speed KMH gives a limit where the file has none"
_CANT, _REPLACES, _LOWERS = _KINDS = ("Cant_Deficiency_SSP", "Other_SSP_Replaces_CDSSP", "Other_SSP_Noreplace_CDSSP")
#: What else may lower the speed.
_NOT_READ = (("SP_Areas", "AxleLoadSpeedProfile"), ("SP_Points", "Signal", "SignalInformation", "MaxSpeed"))


class _Speed(NamedTuple):
    """A limit, and whether it holds for the train's front alone; None where that is not said."""

    cap: Cap
    front: bool | None


def speed_limits(
    segments: Sequence[Segment], category: Category, line_speed_kmh: float | None
) -> tuple[tuple[SpeedLimit, ...], list[str]]:
    """Limits along the run, and what there is to say of them.

    Parameters
    ----------
    segments : sequence of Segment
    category : Category
        Of the train that the journey is for.
    line_speed_kmh : float or None
        Limit where the file has none.

    Raises
    ------
    InputError
        When a speed is wrong, or there is a place without limit, and no line speed.
    """
    static = [speed for segment in segments for speed in _static(segment, category)]
    restricted = list(_restrictions(segments))
    swiss = swiss_speeds(segments, category)
    length_m = segments[-1].end_m
    rows = lowest([*(speed.cap for speed in static), *swiss.line], length_m)
    filled, missing_m = [], 0.0
    for (from_m, kmh), (to_m, _) in pairwise([*rows, (length_m, None)]):
        if kmh is None:
            missing_m += to_m - from_m
            kmh = _line_speed_kmh(segments, from_m, to_m, line_speed_kmh)
        filled.append(Cap(from_m, to_m, kmh))
    final = lowest([*filled, *swiss.curves, *(speed.cap for speed in restricted)], length_m)
    limits = tuple(SpeedLimit(at_m, kmh_to_mps(kmh)) for at_m, kmh in final if kmh is not None)
    asked = f"no limit on {missing_m:.6g} m: limit is the line speed asked for, {line_speed_kmh or 0.0:g} km/h"
    return limits, [
        *((asked,) if missing_m else ()),
        *swiss.notes,
        *_notes(segments, category, [*static, *restricted], len(restricted)),
    ]


def _line_speed_kmh(segments: Sequence[Segment], from_m: float, to_m: float, line_speed_kmh: float | None) -> float:
    if line_speed_kmh is not None:
        return line_speed_kmh
    where = next(segment for segment in segments if segment.end_m > from_m)
    raise where.reference.bad(f"no speed limit from {from_m:.12g} m to {to_m:.12g} m of the journey: {_HINT}")


def _static(segment: Segment, category: Category) -> Iterator[_Speed]:
    for profile in segment.profile.below("SP_Characteristics", "StaticSpeedProfile"):
        for from_m, to_m, node in segment.changes(profile):
            kmh = _kmh_for(node, category)
            if kmh is not None:
                yield _Speed(Cap(from_m, to_m, kmh), node.flag("SSP_Front"))


def _kmh_for(node: Node, category: Category) -> float | None:
    """Speed for a train: that of its category where there is one (SUBSET-026, 3.11.3), else the basic one."""
    kmh = node.number("SSP_Speed", "km/h", above=0.0)
    cant_mm, others = -1.0, []
    for specific in node.children("SpecificSSP"):
        kind = specific.choice("specific_SSP_Category", _KINDS)
        own_kmh = specific.required_number("V_DIFF", "km/h", above=0.0)
        for cant in specific.children("CantDeficiencySSP"):
            own_mm = millimetres(cant, "SSP_NC_CDDIFF")
            if own_mm is not None and category.cant_mm is not None and cant_mm < own_mm <= category.cant_mm:
                cant_mm, kmh = own_mm, own_kmh
        for other in specific.children("OtherSpecificSSP"):
            etcs, code = other.text("SSP_NC_DIFF"), other.text("trainCategoryCode")
            if (etcs and etcs == category.etcs) or (code and code == category.code):
                others.append((kind, own_kmh))
    replacing = [own_kmh for kind, own_kmh in others if kind == _REPLACES]
    lowering = [own_kmh for kind, own_kmh in others if kind != _REPLACES]
    kmh = min(replacing) if replacing else kmh
    return min(filter(None, (kmh, *lowering)), default=None)


def _restrictions(segments: Sequence[Segment]) -> Iterator[_Speed]:
    """Additional speed restrictions, from segment to segment.

    One that ends in a segment, and goes on from none before it, starts in that segment, where an element says so.
    """
    goes_on: set[float] = set()
    for segment in segments:
        found: dict[str, list[_Speed]] = {"Starts": [], "Ends": [], "StartsEnds": [], "WholeSP": []}
        for constraint in segment.reference.children("TemporaryConstraints"):
            for node in constraint.children("AdditionalSpeedRestriction"):
                from_m, to_m, _ = segment.stretch(constraint)
                cap = Cap(from_m, to_m, node.required_number("ASR_Speed", "km/h", above=0.0))
                found[constraint.required_text("startEndQualifier")].append(_Speed(cap, node.flag("ASR_Front")))
        for end in found["Ends"]:
            starts = [
                one for one in found["Starts"] if one.cap.value == end.cap.value and one.cap.from_m < end.cap.to_m
            ]
            if starts and end.cap.value not in goes_on:
                found["Starts"].remove(starts[-1])
                end = end._replace(cap=end.cap._replace(from_m=starts[-1].cap.from_m))
            yield end
        goes_on = {one.cap.value for one in (*found["Starts"], *found["WholeSP"])}
        yield from (*found["Starts"], *found["StartsEnds"], *found["WholeSP"])


def _notes(
    segments: Sequence[Segment], category: Category, speeds: Sequence[_Speed], restrictions: int
) -> Iterator[str]:
    if restrictions:
        constraints = [one for segment in segments for one in segment.reference.children("TemporaryConstraints")]
        lowering = [one for one in constraints if one.child("AdditionalSpeedRestriction") is not None]
        timed = any(one.text("startTime") or one.text("endTime") for one in lowering)
        when = ", at any time (startTime and endTime are not used)" if timed else ""
        yield f"additional speed restrictions (ASR) that lower the limit{when}: {restrictions}"
    fronts = Counter(speed.front for speed in speeds)
    if fronts[False]:
        which = "limits that hold until the train's rear has left them (SSP_Front, ASR_Front; --limits tail)"
        yield f"{which}: {fronts[False]} of {len(speeds)}"
    profiles = [segment.profile.below("SP_Characteristics", "StaticSpeedProfile") for segment in segments]
    if any(len(own) > 1 for own in profiles):
        yield "several StaticSpeedProfiles on one segment, as for train protection systems: the lowest speed counts"
    specific = sum(
        len(row.children("SpecificSSP"))
        for own in profiles for profile in own
        for row in profile.children("StaticSpeedProfileStart", "StaticSpeedProfileChange")
    )  # fmt: skip
    if specific:
        yield f"speeds for categories of trains, taken for {category}: {specific}"
    found = {path[-1]: sum(len(segment.profile.below(*path)) for segment in segments) for path in _NOT_READ}
    if any(found.values()):
        names = ", ".join(counted(Counter({name: count for name, count in found.items() if count})))
        yield f"not read, though it may lower the speed: {names}"
