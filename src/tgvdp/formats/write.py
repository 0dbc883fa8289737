"""From trains, tracks, journeys and scenarios to the bytes of a file, and the list of what that file cannot hold.

What is written is read back by the reader of the format and compared, field by field: nothing is lost in silence.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

from tgvdp.errors import InputError
from tgvdp.formats.detect import read_scenario
from tgvdp.formats.native.write import SYNTAXES, as_json, native_tree, same_effort
from tgvdp.formats.scenario import Scenario
from tgvdp.formats.syntax.reading import parse_document, shown
from tgvdp.formats.ttobench.write import ttobench_tree
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey
from tgvdp.model.track import Track
from tgvdp.model.train import Train

Target = Literal["toml", "json", "ttobench"]
TARGETS: tuple[Target, ...] = get_args(Target)
PARTS = ("train", "track", "journey", "map")

#: Numbers that differ by less read back as the same: a unit of people holds float64 to 1 in 10¹⁶.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Written:
    """A file to be: its bytes, and what it does not hold of what was to be written, a line each."""

    data: bytes
    losses: tuple[str, ...]


def scenario_of(part: Train | Track | Journey | EnergyMap | Scenario) -> Scenario:
    """Return a scenario that holds one part; a scenario as it is."""
    if isinstance(part, Scenario):
        return part
    held: dict[str, Any] = {"map" if isinstance(part, EnergyMap) else type(part).__name__.lower(): part}
    return Scenario(name=part.name, format="memory", **held)


def write_bytes(part: Train | Track | Journey | Scenario, target: Target) -> Written:
    """Make the bytes of a file.

    Parameters
    ----------
    part : Train, Track, Journey or Scenario
    target : {"toml", "json", "ttobench"}
        The native format as TOML or JSON, or TTOBench JSON, which holds one train, track or journey.

    Returns
    -------
    Written

    Raises
    ------
    InputError
        When the format cannot hold the part at all: several parts in TTOBench, an effort curve of another shape.
    """
    scenario = scenario_of(part)
    if target == "ttobench":
        held = [one for one in (scenario.train, scenario.track, scenario.journey) if one is not None]
        if len(held) != 1:
            kinds = " and ".join(kind for kind in PARTS if getattr(scenario, kind) is not None) or "run options"
            raise InputError(f"{scenario.name}: a TTOBench file holds one of train, track and journey, got {kinds}")
        kind = type(held[0]).__name__.lower()
        text = as_json(ttobench_tree(held[0]) | dict(scenario.kept.get(kind, {})))
    else:
        if not (scenario.train or scenario.track or scenario.map or scenario.options):
            raise InputError(f"{scenario.name}: the native format holds no journey; TTOBench does")
        text = SYNTAXES[target](native_tree(scenario))
    data = text.encode("utf-8")
    again = read_scenario(parse_document(Path(f"{scenario.name}.{target}"), data))
    return Written(data, tuple(_losses(scenario, again, target)))


def _losses(before: Scenario, after: Scenario, target: Target) -> Iterator[str]:
    for kind in PARTS:
        one, other = getattr(before, kind), getattr(after, kind)
        if one is not None and other is None:
            yield f"{kind} {one.name}: not held by this format"
        elif one is not None:
            yield from (f"{kind} {one.name}: {loss}" for loss in _lost_fields(one, other, target))
            lost = before.kept.get(kind, {}).keys() - after.kept.get(kind, {}).keys()
            yield from (f"{kind} {one.name}: {name}: not held by this format" for name in sorted(lost))
    for name in before.options.keys() - after.options.keys():
        yield f"run option {name}: not held by this format"


def _lost_fields(one: Any, other: Any, target: Target) -> Iterator[str]:
    top_mps = getattr(one, "max_speed_mps", 0.0)
    for field in fields(one):
        before, after = getattr(one, field.name), getattr(other, field.name)
        if field.name == "notes":
            if before and not after and target != "ttobench":
                yield "notes: not held by this format"
        elif not field.compare:  # where it was read from
            continue
        elif isinstance(before, EffortCurve):
            if not same_effort(before, after, top_mps):
                yield f"{field.name}: differs when read back"
        elif not _same(before, after):
            yield f"{field.name}: {shown(before)} reads back as {shown(after)}"


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return one == other or abs(one - other) <= _ROUNDING * max(abs(one), abs(other))
    return bool(one == other)
