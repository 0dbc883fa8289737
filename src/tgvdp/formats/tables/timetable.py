"""A timetable from a table: where a train stops, and when it arrives and departs there.

Where that is, positions tell, or names of places that the line has.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from tgvdp.errors import InputError
from tgvdp.formats.calls import FEWEST_STOPS, NO_JOURNEY, Call, RunningClock, journey_of, position_of
from tgvdp.formats.syntax.clocks import clock_s, is_time_of_day
from tgvdp.formats.syntax.reading import bad, shown
from tgvdp.formats.tables.cells import DASHES, Row, is_no, name_in
from tgvdp.formats.tables.line import starts_m
from tgvdp.formats.tables.roles import ARRIVAL, DEPARTURE, POSITION, SPEED, STOP, Role
from tgvdp.formats.tables.table import Table
from tgvdp.model.checks import plain_text
from tgvdp.model.journey import Journey
from tgvdp.units import KILO

#: Columns that make a table a timetable.
ROLES = (ARRIVAL, DEPARTURE)

_BLANK = DASHES | {"", "|"}


def is_timetable(table: Table) -> bool:
    """Whether a table holds times of arrival or departure; beside limits these have to have digits, as times do."""
    texts = [table.text(row, role) for role in ROLES if role in table.columns for row in table.rows]
    if SPEED in table.columns:
        return any(map(str.isdigit, "".join(texts)))
    return any(texts)


def make_journey(
    path: Path,
    table: Table,
    name: str,
    start_m: float,
    places: Sequence[tuple[float, str]],
    notes: tuple[str, ...] = (),
) -> Journey:
    """Make a journey of a table.

    Parameters
    ----------
    path : Path
        The file, for errors about the journey.
    table : Table
    name : str
    start_m : float
        Where the line begins, by the positions of the table, m.
    places : sequence of (float, str)
        Named places of the line, with their positions on it, m: where the table gives none.
    notes : tuple of str
        On the file that the table stands in.

    Raises
    ------
    InputError
        When a cell is no time, position or known place, times or positions decrease, or fewer than two stops have
        times.
    """
    is_placed = POSITION in table.columns
    starts = starts_m(table) if is_placed else list(_named_m(table, places))
    calls = list(_calls(path, table, starts, start_m if is_placed else 0.0))
    journey = journey_of(name, calls, (*table.notes, *notes))
    first_m = journey.points[0].position_m
    if is_placed and start_m == 0.0 and first_m > 0.0:
        told = f"positions count from where the line begins: the journey does at {first_m / KILO:.9g} km"
        journey = replace(journey, notes=(*journey.notes, told))
    return journey


def outlined(table: Table) -> str:
    """From where to where a timetable of names runs, and when.

    Raises
    ------
    InputError
        When a time is none, times decrease, or fewer than two places have any.
    """
    timed = [row for row, times_s in zip(table.rows, _times(table), strict=True) if times_s != (None, None)]
    if not timed:
        raise table.lacks(POSITION)
    if len(timed) < FEWEST_STOPS:
        raise InputError(NO_JOURNEY)
    names = [plain_text(table.text(row, STOP)) for row in (timed[0], timed[-1])]
    clocks = [text for row in timed for role in ROLES if (text := table.text(row, role)) not in _BLANK]
    return f"{' to '.join(names)}, {len(timed)} places, {clocks[0]} to {clocks[-1]}"


def _named_m(table: Table, places: Sequence[tuple[float, str]]) -> Iterator[float]:
    """Positions of rows by their names, m; those of rows without times are those of the rows before them."""
    if not places:
        raise table.lacks(POSITION)
    last_m = 0.0
    for row in table.rows:
        name = plain_text(table.text(row, STOP))
        if any(table.text(row, role) not in _BLANK for role in ROLES):
            try:
                at_m = position_of(name, places)
            except InputError as error:
                raise table.bad(row, STOP, str(error)) from None
            if at_m < last_m:
                raise table.bad(row, STOP, f"{shown(name)} lies before the place above it: is the line to be reversed?")
            last_m = at_m
        yield last_m


def _calls(path: Path, table: Table, starts: Sequence[float], start_m: float) -> Iterator[Call]:
    """Places with times in the order of running; arrival and departure may stand in a row each."""
    said = POSITION if POSITION in table.columns else STOP
    rows = zip(starts, table.rows, _times(table), strict=True)
    for position_m, group in groupby(rows, lambda row: row[0]):
        given = list(group)
        arrivals = [arrival_s for _, _, (arrival_s, _) in given if arrival_s is not None]
        departures = [departure_s for _, _, (_, departure_s) in given if departure_s is not None]
        if not arrivals and not departures:
            continue
        stops = STOP not in table.columns or any(not is_no(table.text(row, STOP)) for _, row, _ in given)
        if position_m < start_m:
            raise table.bad(given[0][1], ARRIVAL if arrivals else DEPARTURE,
                            f"lies before the line, which begins at {start_m / KILO:.9g} km")  # fmt: skip
        departure_s = departures[-1] if departures else arrivals[0]
        row = str(bad(path, table.bad(given[0][1], said, table.told(given[0][1], said))))
        names = (plain_text(name_in(table.text(one, STOP))) for _, one, _ in given if STOP in table.columns)
        name = next(filter(None, names), "")
        yield Call(position_m - start_m, stops, arrivals[0] if arrivals else None, departure_s, row=row, name=name)


def _times(table: Table) -> Iterator[tuple[float | None, float | None]]:
    """Arrival and departure of each row, s, on a clock that goes on past midnight."""
    clock = RunningClock()
    for row in table.rows:
        times: list[float | None] = []
        for role in ROLES:
            time_s = _time_s(table, row, role)
            if time_s is not None:
                text = table.text(row, role)
                time_s = clock.after(time_s, is_time_of_day=is_time_of_day(text))
                if time_s is None:
                    raise table.bad(row, role, f"times must not decrease, got {text} after a later one")
            times.append(time_s)
        yield times[0], times[1]


def _time_s(table: Table, row: Row, role: Role) -> float | None:
    text = table.text(row, role)
    if text in _BLANK:
        return None
    if ":" not in text:
        if not table.columns[role].unit:
            message = f"must be a time of day such as 10:05, or its header needs a unit such as {role.name}_min"
            raise table.bad(row, role, f"{message}, got {shown(text)}")
        return table.number(row, role)
    try:
        return clock_s(text, with_hours=True)
    except InputError as error:
        raise table.bad(row, role, str(error)) from None
