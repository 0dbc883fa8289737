"""``tgvdp search --journey``: a section of a timetable as origin, destination and longest running time."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tgvdp.options.search import BY_FIELD
from tgvdp.units import mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.formats.scenario import Read
    from tgvdp.model.journey import Section, TimingPoint
    from tgvdp.model.track import Track

#: What a journey decides instead.
_DECIDED = ("from_m", "to_m", "start_speed_kmh", "end_speed_kmh", "max_margin_pct", "reverse")
_SHOWN = 3  # windows that a warning spells out


class TimetableSection(NamedTuple):
    """A section of a journey on a track."""

    journey: str
    section: "Section"
    note: str

    def broken_by(self, fastest_s: float) -> tuple[str, ...]:
        """What the search does not keep of the timetable, as warnings."""
        return tuple(self._warnings(fastest_s))

    def _warnings(self, fastest_s: float) -> Iterator[str]:
        name = f"journey {self.journey}, section {self.section.number}"
        if self.note:
            yield f"{name}: {self.note}"
        if fastest_s < self.section.shortest_s:
            yield f"{name}: runs shorter than {self.section.shortest_s:.6g} s arrive before the window opens"
        count = len(self.section.passing)
        if count:
            texts = ", ".join(_window(point) for point in self.section.passing[:_SHOWN])
            more = f" and {count - _SHOWN} more" if count > _SHOWN else ""
            yield f"{name}: the search does not keep what is asked of passing: {texts}{more}; tgvdp journey does"


def section_on(read: "Read", track: "Track", options: dict[str, Any], given: Mapping[str, Any]) -> TimetableSection:
    """Choose a section of a journey that was read, and put what it decides into the options.

    Raises
    ------
    InputError
        When there is no such section, or it does not lie on the track.
    """
    from tgvdp.formats import section_of

    flags = ", ".join(BY_FIELD[name].flag for name in _DECIDED if given[name] is not None)
    if flags:
        raise click.UsageError(f"--journey and {flags} exclude each other", click.get_current_context())
    timetable, section = read.value, section_of(read, track)
    timetable.require_on(track, until_m=section.destination_m)
    for name in _DECIDED:
        options.pop(name, None)
    options |= {"from_m": section.origin_m, "to_m": section.destination_m}
    if math.isfinite(section.longest_s):
        options["max_time_s"] = section.longest_s
    foreign = timetable.track not in (None, track.name)
    other = f"it belongs to track {timetable.track}, not to {track.name}" if foreign else ""
    return TimetableSection(timetable.name, section, other)


def _window(point: "TimingPoint") -> str:
    asked = (
        _range(point.earliest_s, point.latest_s, "s"),
        _range(mps_to_kmh(point.lowest_mps) or -math.inf, mps_to_kmh(point.highest_mps), "km/h"),
    )
    return f"at {point.position_m:.6g} m {' and '.join(filter(None, asked))}"


def _range(low: float, high: float, unit: str) -> str:
    if math.isfinite(low) and math.isfinite(high):
        return f"{low:.6g} to {high:.6g} {unit}"
    if math.isfinite(low):
        return f"at least {low:.6g} {unit}"
    return f"at most {high:.6g} {unit}" if math.isfinite(high) else ""
