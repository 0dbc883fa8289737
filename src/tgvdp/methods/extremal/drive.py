"""Where a drive over commands is, and what it writes: rows, where commands begin, and what happened without one."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.command import AT, HOLDS_FROM, REGIME
from tgvdp.methods.extremal.rows import ENVELOPE, SAME_M, Rows, account_rows, clip

#: Relative difference of squared speeds below which a run is on the envelope, or at a speed that is held.
ON_CURVE = 1e-9
#: Ends of a drive that goes no farther: too little room, or a train that stalls.
GOES_ON, NO_ROOM, STALLS = 0, -1, -2
#: Whole numbers of a drive: the command that it is under, the regime that this or an event set, what the train does, a
#: regime or `ENVELOPE`; the cell and the row of the envelope that it is on; how many rows and events there are.
COMMAND, DRIVEN, MODE, CELL, EDGE, COUNT, HAPPENED = range(7)
NUMBERS = 7
#: Columns of an event, (n, 3): the regime that took over, where, and w if that was on the envelope, else 0.
MOST_EVENTS = 64


class Drive(NamedTuple):
    """Where a drive is: position and squared speed, (2,) float64, its whole numbers, (7,) int64, and what it writes."""

    place: NDArray[np.float64]
    now: NDArray[np.int64]
    rows: Rows
    starts: NDArray[np.int64]
    events: NDArray[np.float64]


@leaf
def tell(drive, regime, x, w):
    """Note that a regime takes over without a command; ``w`` if that is on the envelope, else 0."""
    happened = drive.now[HAPPENED]
    if happened < drive.events.shape[0]:
        drive.events[happened, 0] = regime
        drive.events[happened, 1] = x
        drive.events[happened, 2] = w
        drive.now[HAPPENED] = happened + 1


@leaf
def begin(course, commands, start_w, drive):
    """Stand at the start, under the first command."""
    now, rows = drive.now, drive.rows
    for i in range(now.shape[0]):
        now[i] = 0
    for i in range(drive.starts.shape[0]):
        drive.starts[i] = -1
    drive.starts[0] = 0
    now[DRIVEN] = int(commands[0, REGIME])
    now[MODE] = ENVELOPE if start_w >= course.w[0] * (1.0 - ON_CURVE) else now[DRIVEN]
    now[COUNT] = 1
    drive.place[0] = 0.0
    drive.place[1] = start_w
    rows.x[0] = 0.0
    rows.w[0] = start_w
    rows.time[0] = 0.0
    rows.energy[0] = 0.0
    rows.effort[0] = 0.0
    rows.regime[0] = ENVELOPE
    rows.cell[0] = 0


@leaf
def stretch(course, commands, count, drive):
    """Take in the cell and the command that begin here; where the next of them does, and whether speeds are held."""
    now = drive.now
    x = drive.place[0]
    station = course.station_m
    while now[CELL] < station.shape[0] - 2 and x >= station[now[CELL] + 1] - SAME_M:
        now[CELL] += 1
    while now[COMMAND] + 1 < count and x >= commands[now[COMMAND] + 1, AT] - SAME_M:
        now[COMMAND] += 1
        drive.starts[now[COMMAND]] = now[COUNT] - 1
        now[DRIVEN] = int(commands[now[COMMAND], REGIME])
        if now[MODE] != ENVELOPE:
            now[MODE] = now[DRIVEN]
    c = now[COMMAND]
    until = station[now[CELL] + 1]
    if c + 1 < count:
        until = min(until, max(commands[c + 1, AT], x + SAME_M))
    enabled = x >= commands[c, HOLDS_FROM] - SAME_M
    if not enabled:
        until = min(until, max(commands[c, HOLDS_FROM], x + SAME_M))
    return until, enabled


@part
def taken(train, course, first, end, drive):
    """Take in rows first … end − 1, cut where they pass above the envelope; returns whether they do."""
    now, rows = drive.now, drive.rows
    k = now[CELL]
    n, e, hit = clip(course, now[EDGE], rows.x, rows.w, first, end, ON_CURVE)
    account_rows(train, course.returned, course.grade[k], course.air[k], rows, first, n)
    now[COUNT] = n
    now[EDGE] = e
    drive.place[0] = rows.x[n - 1]
    drive.place[1] = rows.w[n - 1]
    return hit
