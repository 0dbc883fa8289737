"""What a file holds, in the figures that a railway engineer checks first."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from tgvdp.formats.detect import KINDS, load_to_describe
from tgvdp.formats.review.figures import Figure, track_figures, train_figures, value_range
from tgvdp.formats.scenario import Scenario
from tgvdp.formats.sources import Source
from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey, Section
from tgvdp.units import KILO, mps_to_kmh


@dataclass(frozen=True, kw_only=True)
class Description:
    """What a file holds.

    Attributes
    ----------
    kind : str
        "train", "track", "map", "journey", "scenario" (several of them), "run options", "timetable" (of a line that the
        file does not hold) or, where a file holds several things to choose from, "choice".
    format : str
        "native", "TTOBench", ...
    name : str
    figures : tuple of Figure
        Headline figures: of the train, then of the track, then of the journey, then the run options. Of a choice, the
        names and their headlines.
    notes : tuple of str
        Sources, doubts, and what was read but is not used.
    """

    kind: str
    format: str
    name: str
    figures: tuple[Figure, ...]
    notes: tuple[str, ...]

    @property
    def headline(self) -> str:
        """One line of figures, for lists."""
        return ", ".join(f"{figure.name} {figure}" for figure in self.figures)

    def __str__(self) -> str:
        """Several lines, for the terminal."""
        width = max((len(figure.name) for figure in self.figures), default=0)
        lines = [f"{self.kind} {self.name} ({self.format})"]
        lines += [f"  {figure.name:<{width}}  {figure}" for figure in self.figures]
        lines += [f"  note: {note}" for note in self.notes]
        return "\n".join(lines)


def describe_file(path_or_name: Source, *, line_speed_mps: float | None = None) -> Description:
    """Say what a file, or a name of the catalog, holds.

    Parameters
    ----------
    path_or_name : str or path
    line_speed_mps : float, optional
        See `tgvdp.formats.load.load_track`.

    Raises
    ------
    InputError
        When it cannot be read or is wrong.
    """
    scenarios = load_to_describe(path_or_name, line_speed_mps=line_speed_mps)
    if len(scenarios) == 1:
        return describe(scenarios[0])
    each = [describe(scenario) for scenario in scenarios]
    return Description(
        kind="choice",
        format=scenarios[0].format,
        name=f"of {len(each)}, taken as FILE#NAME",
        figures=tuple(Figure(one.name, f"{one.kind}: {one.headline}", "") for one in each),
        notes=tuple(dict.fromkeys(note for one in each for note in one.notes)),
    )


def describe(scenario: Scenario) -> Description:
    """Describe what has been loaded."""
    figures: list[Figure] = []
    notes: list[str] = []
    parts = {kind: part for kind in KINDS if (part := getattr(scenario, kind)) is not None}
    for kind, part in parts.items():
        if len(parts) > 1:
            figures.append(Figure(kind, part.name, ""))
        figures += (figure for figure in _FIGURES[kind](part) if figure.is_headline)
        notes += part.notes
    figures += [Figure(f"run {name}", str(value), "") for name, value in scenario.options.items()]
    figures += [Figure(name, text, "") for name, text in scenario.outline.items()]
    alone = "timetable" if scenario.outline else "run options"
    if scenario.outline:
        notes.append("it gives no positions: tgvdp journey takes it with a line that has places of these names")
    return Description(
        kind="scenario" if len(parts) > 1 else next(iter(parts), alone),
        format=scenario.format,
        name=scenario.name,
        figures=tuple(figures),
        notes=tuple(dict.fromkeys(notes)),  # a table that is a line and its timetable has one set of columns
    )


def _map_figures(energy_map: EnergyMap) -> Iterator[Figure]:
    speeds_kmh = [mps_to_kmh(speed_mps) for speed_mps in energy_map.speed_mps]
    powers_kw = [power_w / KILO for row in energy_map.power_w for power_w in row]
    yield Figure("speeds", f"{len(speeds_kmh)}, {value_range(speeds_kmh)}", "km/h")
    yield Figure("demands", f"{len(energy_map.demand)}, {value_range(list(energy_map.demand))}", "")
    yield Figure("power drawn", value_range(powers_kw), "kW")


def _journey_figures(journey: Journey) -> Iterator[Figure]:
    if journey.track is not None:
        yield Figure("line", journey.track, "")
    for section in journey.sections:
        yield Figure(f"section {section.number}", _section_text(section), "")


def _section_text(section: Section) -> str:
    ends = f"{section.origin_m / KILO:.6g} to {section.destination_m / KILO:.6g} km"
    running = f"{section.shortest_s:.6g} to {section.longest_s:.6g} s"
    if math.isinf(section.longest_s):
        running = f"{section.shortest_s:.6g} s and more" if section.shortest_s else "any time"
    count = len(section.passing)
    return f"{ends} in {running}" + (f", {count} passing window{'s' * (count > 1)}" if count else "")


_FIGURES: dict[str, Callable[[Any], Iterator[Figure]]] = {
    "train": train_figures,
    "track": track_figures,
    "map": _map_figures,
    "journey": _journey_figures,
}
