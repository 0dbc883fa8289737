"""The timetable of an OSRD train: its schedule, with the positions that the pathfinding found for its path.

Times are ISO 8601 durations since the departure, positions mm from the start of the path. Source: openapi.yaml of
OSRD's editoast (Open Rail Association).
"""

from collections.abc import Iterator, Sequence
from datetime import timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

from msgspec import Struct

from tgvdp.formats.calls import Call, journey_of
from tgvdp.formats.syntax.reading import bad, shown
from tgvdp.formats.syntax.typed import suggestion
from tgvdp.model.journey import Journey
from tgvdp.units import KILO

_NO_TIME = timedelta()
#: Margins that add nothing.
_NO_MARGINS = {"none", "0%", "0min/100km"}


class _PathItem(Struct):
    id: str | None = None  # until 2026
    key: str | None = None  # since then
    # Where it lies, which the pathfinding has found.
    deleted: Any = None
    location: Any = None
    offset: Any = None
    operational_point: Any = None
    secondary_code: Any = None
    track: Any = None
    track_reference: Any = None
    trigram: Any = None
    uic: Any = None


class _ScheduleItem(Struct):
    at: str
    arrival: timedelta | None = None
    stop_for: timedelta | None = None
    # What does not act on a run.
    locked: Any = None
    reception_signal: Any = None


class _Margins(Struct):
    values: list[str] = []
    boundaries: Any = None


class TrainSchedule(Struct):
    """A train of a timetable, as OSRD's services answer."""

    path: list[_PathItem]
    schedule: list[_ScheduleItem] = []
    initial_speed: float = 0.0
    margins: _Margins | None = None
    # What does not act on a timetable.
    category: Any = None
    comfort: Any = None
    constraint_distribution: Any = None
    id: Any = None
    labels: Any = None
    options: Any = None
    power_restrictions: Any = None
    rolling_stock_name: Any = None
    speed_limit_tag: Any = None
    start_time: Any = None
    timetable_id: Any = None
    train_name: Any = None


def make_journey(
    path: Path, name: str, train: TrainSchedule, position_mm: Sequence[float], told: tuple[str, ...]
) -> Journey:
    """Make a journey of a schedule.

    Parameters
    ----------
    path : Path
        The file, for errors.
    name : str
    train : TrainSchedule
    position_mm : (n,) sequence of float
        Where each item of its path lies, mm.
    told : tuple of str
        Notes on its fields.

    Raises
    ------
    InputError
        When positions are not those of the path, an item is not on it, or times decrease.
    """
    if len(position_mm) != len(train.path):
        found = f"{len(position_mm)} positions for {len(train.path)} items of train_schedule.path"
        raise bad(path, f"pathfinding.path_item_positions: must be one for each item, got {found}")
    for at, (before_mm, at_mm) in enumerate(pairwise(position_mm), 1):
        if at_mm < before_mm:
            got = f"got {at_mm:.12g} mm after {before_mm:.12g} mm"
            raise bad(path, f"pathfinding.path_item_positions[{at}]: must not decrease, {got}")
    keys = [item.key if item.key is not None else item.id for item in train.path]
    items = _by_key(path, train, keys)
    calls = [
        _call(items.get(key or ""), at_mm / KILO, is_first=index == 0, is_last=index == len(keys) - 1)._replace(
            row=str(bad(path, f"pathfinding.path_item_positions[{index}]: {at_mm:.12g} mm"))
        )
        for index, (key, at_mm) in enumerate(zip(keys, position_mm, strict=True))
    ]
    asked = [call for call in calls if call.stops or call.arrival_s is not None]
    _require_order(path, asked)
    return journey_of(name, asked, (*_notes(train, asked), *told))


def _by_key(path: Path, train: TrainSchedule, keys: Sequence[str | None]) -> dict[str, _ScheduleItem]:
    """What is asked for at items of the path, by their keys."""
    items: dict[str, _ScheduleItem] = {}
    for index, item in enumerate(train.schedule):
        field = f"train_schedule.schedule[{index}]"
        if keys.count(item.at) != 1:
            hint = suggestion(item.at, [key for key in keys if key])
            which = f"{keys.count(item.at)} items of the path" if item.at in keys else "no item of the path"
            raise bad(path, f"{field}.at: {which}, got {shown(item.at)}{'' if item.at in keys else hint}")
        if item.at in items:
            raise bad(path, f"{field}.at: {shown(item.at)} is there already: leave one")
        if item.stop_for is not None and item.stop_for < _NO_TIME:
            raise bad(path, f"{field}.stop_for: must be at least 0 s, got {item.stop_for.total_seconds():g} s")
        if item.at == keys[0] and item.arrival:
            got = f"got {item.arrival.total_seconds():g} s"
            raise bad(path, f"{field}.arrival: must be 0 s where the train starts, {got}")
        items[item.at] = item
    return items


def _require_order(path: Path, calls: Sequence[Call]) -> None:
    """No arrival lies before what is known of an earlier place, and no two are asked for at one."""
    for one, other in pairwise(calls):
        if one.position_m == other.position_m:
            raise bad(path, f"train_schedule.schedule: two items at {one.position_m:.9g} m: leave one")
    last_s = 0.0
    for call in calls:
        if call.arrival_s is None:
            continue
        if call.arrival_s < last_s:
            where = f"arrival {call.arrival_s:g} s at {call.position_m:.9g} m"
            raise bad(path, f"train_schedule.schedule: times must not decrease, got {where} after {last_s:g} s")
        last_s = call.arrival_s if call.departure_s is None else call.departure_s


def _call(item: _ScheduleItem | None, position_m: float, *, is_first: bool, is_last: bool) -> Call:
    arrival, stop_for = (None, None) if item is None else (item.arrival, item.stop_for)
    arrival_s = 0.0 if is_first else None if arrival is None else arrival.total_seconds()
    stands_s = None if stop_for is None else stop_for.total_seconds()
    departure_s = None if arrival_s is None else arrival_s + (stands_s or 0.0)
    return Call(position_m, is_first or is_last or stands_s is not None, arrival_s, departure_s)


def _notes(train: TrainSchedule, calls: Sequence[Call]) -> Iterator[str]:
    untimed = sum(call.stops and call.arrival_s is None for call in calls[1:-1])
    if untimed:
        yield f"stops without arrival ({untimed}): how long the train stands there is what --dwell says"
    if train.initial_speed > 0.0:
        yield f"initial_speed {train.initial_speed:g} m/s is not used: the train starts from a stand"
    if train.margins is not None and not _NO_MARGINS.issuperset(train.margins.values):
        yield "margins are not used: --at and --margins take some"
