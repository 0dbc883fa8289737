"""What railML 2.x and 3.x tracks have in common: rows along a run, pieces of line, and how pieces join."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, SpeedLimit, Track, Tunnel
from tgvdp.units import KILO, kmh_to_mps

#: Value of a row at which a limit ends without a new one.
NO_LIMIT_KMH = math.inf

#: Positions are written with millimetres at best.
SLACK_M = 1e-3

#: How to run over a line of which the file does not say how fast.
LINE_SPEED_HINT = "--line-speed KMH gives a limit where the file has none"

#: Attributes of an element that tell where and who it is.
_WHERE = ("id", "name", "pos", "absPos")
#: Longest note, so that it stays one line that can be read.
_LONGEST_NOTE = 400


class Row(NamedTuple):
    """A value that holds from a position of the run to the next row, and the line of the file it comes from."""

    position_m: float
    value: float
    line: int


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A stretch of line as one track or path of net elements describes it; positions count from its start.

    Rows of limits are in km/h and need not start at 0 m; one of `NO_LIMIT_KMH` ends the limit before it, and one at the
    end of the piece holds on the next one. Those of gradients (‰, + uphill in the direction of the run) do start there,
    unless there are none.
    """

    name: str
    length_m: float
    line: int
    limits_kmh: list[Row]
    gradients_permil: list[Row] = field(default_factory=list)
    curves: list[tuple[Curve, int]] = field(default_factory=list)
    tunnels: list[tuple[Tunnel, int]] = field(default_factory=list)
    neutral_sections: list[tuple[NeutralSection, int]] = field(default_factory=list)
    stops: list[Place] = field(default_factory=list)
    #: Places where no train stops, and those at the ends.
    others: list[Place] = field(default_factory=list)
    #: Ids of what lies at the start and at the end of the piece, as far as the file names it.
    joints: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())
    notes: list[str] = field(default_factory=list)


def filled(rows: list[Row], value: float) -> list[Row]:
    """Rows that start at 0 m: with a value of their own where the first one does not."""
    if rows and rows[0].position_m > 0.0:
        return [Row(0.0, value, rows[0].line), *rows]
    return rows


def turned(rows: list[Row], length_m: float) -> list[Row]:
    """Rows from 0 m as the opposite direction meets them; values stay as they are."""
    ends_m = [*(row.position_m for row in rows[1:]), length_m]
    return [Row(length_m - end_m, row.value, row.line) for row, end_m in zip(rows[::-1], ends_m[::-1], strict=True)]


def one_at_each_place(rows: Iterable[tuple[Row, Node]]) -> list[Row]:
    """Rows in the order of the run; of several at one place that agree, the first.

    Raises
    ------
    InputError
        When two rows at one position differ.
    """
    kept: list[tuple[Row, Node]] = []
    for row, node in sorted(rows, key=lambda row: row[0].position_m):
        again = bool(kept) and row.position_m - kept[-1][0].position_m < SLACK_M
        if again and row.value != kept[-1][0].value:
            before, first = kept[-1]
            values = f"and another value, got {_told(node)} after {_told(first)}"
            raise node.bad(f"a second {node.name} at the position of line {before.line}, {values}", "pos")
        if not again:
            kept.append((row, node))
    return [row for row, _ in kept]


def _told(node: Node) -> str:
    """What an element says, but for where and who it is."""
    return ", ".join(f"{name} {shown(text)}" for name, text in node.element.attrib.items() if name not in _WHERE)


def before(rows: list[Row], length_m: float) -> list[Row]:
    """Rows without those at the very end of a run."""
    return [row for row in rows if row.position_m < length_m - SLACK_M]


def unused_notes(names: list[str]) -> list[str]:
    """Say what a file holds that was not used, in lines of a bearable length."""
    notes: list[str] = []
    for name in names:
        if notes and len(notes[-1]) + len(name) < _LONGEST_NOTE:
            notes[-1] += f", {name}"
        else:
            notes.append(f"not used: {name}"[:_LONGEST_NOTE])
    return notes


def other_profiles_note(what: str, counts: Counter[str]) -> list[str]:
    """Say that there are limits for other trains, by the names of their profiles."""
    named = ", ".join(f"{name} ({count})" for name, count in sorted(counts.items()))
    return [f"{what} of other profiles or train categories are not used: {named}"[:_LONGEST_NOTE]] if counts else []


def join(node: Node, pieces: list[Piece], line_speed_kmh: float | None = None) -> tuple[Track, dict[str, int]]:
    """Put pieces one after the other and make a track of them.

    Limits and gradients go on from piece to piece where a piece does not start with its own; where the first one does
    not, and where a limit ends that lowered none, the line speed is the limit.

    Returns
    -------
    track : Track
    lines : dict of str to int
        Line of the file by field of the track: ``speed_limits[3]``.

    Raises
    ------
    InputError
        When there is no limit at the start, or the model refuses the values.
    """
    limits: list[Row] = []
    gradients: list[Row] = []
    curves: list[tuple[Curve, int]] = []
    tunnels: list[tuple[Tunnel, int]] = []
    neutral: list[tuple[NeutralSection, int]] = []
    names: dict[float, str] = {}  # of stops
    others: list[Place] = []
    offset_m = 0.0
    for piece in pieces:
        if piece.limits_kmh and piece.limits_kmh[0].position_m <= SLACK_M:
            limits = before(limits, offset_m)
        limits += (row._replace(position_m=offset_m + row.position_m) for row in piece.limits_kmh)
        gradients += (row._replace(position_m=offset_m + row.position_m) for row in _started(piece, bool(gradients)))
        straight = [] if piece.curves else [(Curve(0.0, math.inf, math.inf), piece.line)]
        for curve, line in piece.curves or straight:
            curves.append((curve._replace(position_m=offset_m + curve.position_m), line))
        tunnels += ((t._replace(position_m=offset_m + t.position_m), line) for t, line in piece.tunnels)
        neutral += ((n._replace(position_m=offset_m + n.position_m), line) for n, line in piece.neutral_sections)
        names |= {offset_m + stop.position_m: stop.name for stop in piece.stops}
        others += (Place(offset_m + place.position_m, place.name) for place in piece.others)
        offset_m += piece.length_m
    limits = before(limits, offset_m)
    first = pieces[0]
    notes = [note for piece in pieces for note in piece.notes]
    notes += _joint_notes(pieces)
    if not limits or limits[0].position_m > SLACK_M:
        until_m = limits[0].position_m if limits else offset_m
        if line_speed_kmh is None:
            raise node.bad(f"no speed limit from 0 m to {until_m:.12g} m of {first.name}: {LINE_SPEED_HINT}")
        limits.insert(0, Row(0.0, line_speed_kmh, first.line))
        notes.append(f"no limit before {until_m:.12g} m: limit is the line speed asked for, {line_speed_kmh:g} km/h")
    limits, end_notes = _ended(node, limits, line_speed_kmh)
    notes += end_notes
    if gradients and gradients[0].position_m > 0.0:
        gradients = filled(gradients, 0.0)
    if all(curve[1:] == (math.inf, math.inf) for curve, _ in curves):
        curves = []
    lines = {"length_m": first.line}
    lines |= {f"speed_limits[{i}]": row.line for i, row in enumerate(limits)}
    lines |= {f"gradients[{i}]": row.line for i, row in enumerate(gradients)}
    lines |= {f"curves[{i}]": line for i, (_, line) in enumerate(curves)}
    lines |= {f"tunnels[{i}]": line for i, (_, line) in enumerate(tunnels)}
    lines |= {f"neutral_sections[{i}]": line for i, (_, line) in enumerate(neutral)}
    stops_m = _stops(set(names), offset_m)
    try:
        track = Track(
            name=" + ".join(piece.name for piece in pieces),
            length_m=offset_m,
            speed_limits=tuple(SpeedLimit(max(row.position_m, 0.0), kmh_to_mps(row.value)) for row in limits),
            gradients=tuple(Gradient(row.position_m, row.value) for row in gradients),
            stops_m=stops_m,
            places=tuple(_named(stops_m, names, others)),
            curves=tuple(curve for curve, _ in curves),
            tunnels=tuple(tunnel for tunnel, _ in tunnels),
            neutral_sections=tuple(section for section, _ in neutral),
            notes=tuple(dict.fromkeys(notes)),
        )
    except InputError as error:
        raise node.bad(str(error)) from None
    return track, lines


def _joint_notes(pieces: list[Piece]) -> list[str]:
    """Say where pieces do not seem to join, and which of them say nothing of the ground that others describe."""
    notes = []
    for one, other in pairwise(pieces):
        end, start = one.joints[1], other.joints[0]
        if end and start and end.isdisjoint(start):
            notes.append(f"{one.name} and {other.name} follow each other, but the file has no connection of their ends")
    for piece in pieces:
        if not piece.gradients_permil and any(other.gradients_permil for other in pieces):
            notes.append(f"no gradients on {piece.name}: taken as level")
        if not piece.curves and any(other.curves for other in pieces):
            notes.append(f"no curves on {piece.name}: taken as straight")
    return notes


def _ended(node: Node, limits: list[Row], line_speed_kmh: float | None) -> tuple[list[Row], list[str]]:
    """Put what holds again where a limit ends: the limit that it had lowered; else the line speed.

    What ends without a new limit is a restriction (``vMax="end"``, 999.9 before railML 2.3), so that a limit that had
    lowered none does not say what holds behind it.
    """
    rows: list[Row] = []
    open_kmh: list[float] = []  # limits in force, each of which lowers the one before it
    restored = at_line_speed = 0
    for row in limits:
        if row.value < NO_LIMIT_KMH:
            while open_kmh and open_kmh[-1] <= row.value:
                open_kmh.pop()
            open_kmh.append(row.value)
            rows.append(row)
            continue
        open_kmh = open_kmh[:-1]
        if not open_kmh and line_speed_kmh is None:
            ended = f"speedChange in line {row.line} ends a limit that lowered none before it, and does not say"
            raise node.bad(f"{ended} what holds from there: {LINE_SPEED_HINT}")
        restored += bool(open_kmh)
        at_line_speed += not open_kmh
        rows.append(row._replace(value=open_kmh[-1] if open_kmh else line_speed_kmh or 0.0))
    notes = []
    if restored:
        notes.append(f"{restored} speed changes end a limit (vMax end or 999.9): the one that it lowered holds again")
    if at_line_speed:
        ended = f"{at_line_speed} speed changes end a limit that lowered none (vMax end or 999.9)"
        notes.append(f"{ended}: from there the line speed, {line_speed_kmh:g} km/h, holds")
    return rows, notes


def _started(piece: Piece, after_another: bool) -> list[Row]:
    """Gradients of a piece; a piece without any is level, also after a piece that was not."""
    return piece.gradients_permil or ([Row(0.0, 0.0, piece.line)] if after_another else [])


def _stops(given_m: set[float], length_m: float) -> tuple[float, ...]:
    """Stops in order, the two ends among them; what lies at an end is the end."""
    inner = sorted(stop_m for stop_m in given_m if SLACK_M < stop_m < length_m - SLACK_M)
    apart = [stop_m for i, stop_m in enumerate(inner) if i == 0 or stop_m - inner[i - 1] > SLACK_M]
    return (0.0, *apart, length_m)


def _named(stops_m: tuple[float, ...], names: dict[float, str], others: list[Place]) -> list[Place]:
    """Stops that have a name, where they are taken to be, and other places with names that no stop has."""
    found: list[Place] = []
    for stop_m in stops_m:
        name = next((name for at_m, name in names.items() if name and abs(at_m - stop_m) <= SLACK_M), "")
        found += [Place(stop_m, name)] if name else []
    called = {place.name for place in found}
    for place in others:
        if place.name not in {"", *called} and all(abs(place.position_m - one.position_m) > SLACK_M for one in found):
            found.append(place)
    return sorted(found)


def uncovered_note(what: str, uncovered_m: float, instead: str) -> list[str]:
    """Say that something is not described everywhere."""
    return [f"{what} are not given on {uncovered_m:.6g} m ({uncovered_m / KILO:.4g} km): taken as {instead}"]
