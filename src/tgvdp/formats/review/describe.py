"""What a file holds, in the figures that a railway engineer checks first."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tgvdp.formats.detect import KINDS, Scenario, load_all
from tgvdp.formats.sources import Source
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey, Section
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.units import KILO, mps_to_kmh

_SPEEDS = 2001  # at which the largest power is looked for


class Figure(NamedTuple):
    """One headline figure; the value is text where it is a range or a name."""

    name: str
    value: float | str
    unit: str

    def __str__(self) -> str:
        value = self.value if isinstance(self.value, str) else f"{self.value:.6g}"
        return f"{value} {self.unit}".strip()


@dataclass(frozen=True, kw_only=True)
class Description:
    """What a file holds.

    Attributes
    ----------
    kind : str
        "train", "track", "map", "journey", "scenario" (several of them), "run options" or, where a file holds several
        things to choose from, "choice".
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


def describe_file(path_or_name: Source) -> Description:
    """Say what a file, or a name of the catalog, holds.

    Raises
    ------
    InputError
        When it cannot be read or is wrong.
    """
    scenarios = load_all(path_or_name)
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
        figures += _FIGURES[kind](part)
        notes += part.notes
    figures += [Figure(f"run {name}", str(value), "") for name, value in scenario.options.items()]
    return Description(
        kind="scenario" if len(parts) > 1 else next(iter(parts), "run options"),
        format=scenario.format,
        name=scenario.name,
        figures=tuple(figures),
        notes=tuple(notes),
    )


def _journey_figures(journey: Journey) -> Iterator[Figure]:
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


def _train_figures(train: Train) -> Iterator[Figure]:
    start_n = train.traction.effort_n(0.0)
    start_mps2 = min((start_n - train.davis_a_n) / train.inertia_kg, train.max_acceleration_mps2)
    yield Figure("mass", train.mass_kg / KILO, "t")
    yield Figure("rotating mass factor", train.rotating_mass_factor, "")
    if train.length_m:
        yield Figure("length", train.length_m, "m")
    if math.isfinite(train.max_speed_mps):
        power_w = _largest_power_w(train.traction, train.max_speed_mps)
        yield Figure("top speed", mps_to_kmh(train.max_speed_mps), "km/h")
        yield Figure("power at the wheel", power_w / KILO, "kW")
        yield Figure("power to mass", power_w / train.mass_kg, "W/kg")
        yield Figure("resistance at top speed", train.resistance_n(train.max_speed_mps) / KILO, "kN")
    yield Figure("starting effort", start_n / KILO, "kN")
    yield Figure("starting acceleration", start_mps2, "m/s²")
    if train.braking_rates:
        yield Figure("full braking", _range([rate.deceleration_mps2 for rate in train.braking_rates]), "m/s²")
    else:
        yield Figure("friction brake", train.friction_brake_n / KILO, "kN")


def _largest_power_w(curve: EffortCurve, top_mps: float) -> float:
    """Largest effort times speed up to the top speed, W; looked for on a fine grid and at the curve's breaks."""
    table = curve.table
    v = np.union1d(np.linspace(0.0, top_mps, _SPEEDS), table[table[:, 0] <= top_mps, 0])
    _, power_w, *c = table[np.searchsorted(table[:, 0], v, side="right") - 1].T
    return float(np.max(power_w + v * (c[0] + v * (c[1] + v * (c[2] + v * c[3])))))


def _track_figures(track: Track) -> Iterator[Figure]:
    limits_kmh = [mps_to_kmh(row.speed_mps) for row in track.speed_limits]
    yield Figure("length", track.length_m / KILO, "km")
    yield Figure("stops", float(len(track.stops_m)), "")
    yield Figure("speed limits", f"{len(limits_kmh)}, {_range(limits_kmh)}", "km/h")
    if track.gradients:
        permil = [row.gradient_permil for row in track.gradients]
        yield Figure("gradients", f"{len(permil)}, {_range(permil)}", "‰")
        yield Figure("net height", _net_height_m(track), "m")
    if track.curves:
        radii_m = [abs(radius_m) for row in track.curves for radius_m in row[1:]]
        yield Figure("curves", f"{len(track.curves)}, tightest {min(radii_m):.6g}", "m")
    if track.tunnels:
        total_m = sum(tunnel.length_m for tunnel in track.tunnels)
        yield Figure("tunnels", f"{len(track.tunnels)}, together {total_m:.6g}", "m")


def _range(values: list[float]) -> str:
    low, high = f"{min(values):.6g}", f"{max(values):.6g}"
    return low if low == high else f"{low} to {high}"


def _net_height_m(track: Track) -> float:
    ends_m = [*(row.position_m for row in track.gradients[1:]), track.length_m]
    return sum(
        (end_m - row.position_m) * row.gradient_permil / KILO
        for row, end_m in zip(track.gradients, ends_m, strict=True)
    )


def _map_figures(energy_map: EnergyMap) -> Iterator[Figure]:
    speeds_kmh = [mps_to_kmh(speed_mps) for speed_mps in energy_map.speed_mps]
    powers_kw = [power_w / KILO for row in energy_map.power_w for power_w in row]
    yield Figure("speeds", f"{len(speeds_kmh)}, {_range(speeds_kmh)}", "km/h")
    yield Figure("demands", f"{len(energy_map.demand)}, {_range(list(energy_map.demand))}", "")
    yield Figure("power drawn", _range(powers_kw), "kW")


_FIGURES: dict[str, Callable[[Any], Iterator[Figure]]] = {
    "train": _train_figures,
    "track": _track_figures,
    "map": _map_figures,
    "journey": _journey_figures,
}
