"""SFERA messages (UIC IRS 90940, schema 4.00): a journey over segments is a line and a timetable, and may be a train.

A file is a journey (JourneyProfile), a train (TrainCharacteristics), or a message that holds several of them. Segments
and trains that a journey refers to stand in the same file or beside it; see docs/formats.md. Source: the published
schema and its documentation; network-specific parameters as Swiss messages use them.
"""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.sfera.category import identity, train_of
from tgvdp.formats.sfera.line import read_line
from tgvdp.formats.sfera.messages import (
    JOURNEY,
    TRAIN,
    Messages,
    is_message,
    journey_name,
    journey_version,
    nothing_to_run,
)
from tgvdp.formats.sfera.timetable import has_times, read_journey
from tgvdp.formats.sfera.train import NO_TRAIN, lacking, lacks_note, read_train, variants
from tgvdp.formats.syntax.reading import Document, shown
from tgvdp.formats.syntax.xml import Node, root_name
from tgvdp.units import mps_to_kmh

FORMAT = "SFERA"
_UNUSABLE = ("Invalid", "Unavailable")


class _Run(NamedTuple):
    """Number of a journey, its train, and how it refers to that."""

    journey: str
    train: Node
    reference: Node


def open_document(document: Document) -> Content | None:
    """Return what a SFERA message holds; None when it is none.

    Raises
    ------
    InputError
        When it is not well formed, holds neither a journey nor a train, or what a journey refers to is not at hand.
    """
    if document.syntax != "XML" or not is_message(root_name(document.path, document.data)):
        return None
    messages = Messages(document)
    speed_mps = document.line_speed_mps
    line_speed_kmh = None if speed_mps is None else mps_to_kmh(speed_mps)
    missing: dict[Kind, str] = {"train": NO_TRAIN, "journey": "none of its points has a time"}
    items: dict[Kind, list[Item]] = {"train": [], "track": [], "journey": []}
    runs: list[_Run] = []
    for journey in messages.each(JOURNEY):
        if journey.text("JP_Status") in _UNUSABLE:
            raise journey.bad(f"must be of a journey to run, got {journey.text('JP_Status')!r}", "JP_Status")
        journey_version(journey)  # advice that goes back has the next one: not to be found wrong after a search
        name = journey_name(journey)
        if any(name == item.id for item in items["track"]):
            raise journey.bad(f"a second journey of train {shown(name)}: leave one")
        items["track"].append(Item(name, partial(read_line, messages, journey, line_speed_kmh)))
        if has_times(journey):
            items["journey"].append(Item(name, partial(read_journey, messages, journey)))
        found = train_of(messages, journey)
        if found is not None and not lacking(found[0].required("TC_Features"), found[1]):
            runs.append(_Run(name, *found))
        elif found is not None:
            missing["train"] = lacks_note(*found)
    items["train"] = _trains_of(runs)
    if not items["track"]:
        items["train"] = [
            item for train in messages.each(TRAIN) for item in _trains(train, None, train.required_text("TC_ID"))
        ]
    held = {kind: tuple(some) for kind, some in items.items() if some}
    if not held:
        raise nothing_to_run(messages)
    return Content(format=FORMAT, items=held, takes_line_speed=True, inputs=messages.inputs, lacking=missing)


def _trains_of(runs: Sequence[_Run]) -> list[Item]:
    """Trains of journeys; those that the same TrainCharacteristics become are told apart by their journeys."""
    alike: dict[tuple[str | None, ...], list[_Run]] = {}
    for run in runs:
        alike.setdefault(identity(run.reference), []).append(run)
    counts = Counter(own[0].train.required_text("TC_ID") for own in alike.values())
    items: list[Item] = []
    for own in alike.values():
        run, name = own[0], own[0].train.required_text("TC_ID")
        made = _trains(run.train, run.reference, name if counts[name] == 1 else f"{name}:{run.journey}")
        items += [one._replace(names=tuple(run.journey for run in own)) for one in made] if len(made) == 1 else made
    return items


def _trains(train: Node, reference: Node | None, name: str) -> list[Item]:
    """A train, with each of its tractions where there are several."""
    names = variants(train)
    if not names:
        return [Item(name, partial(read_train, train, reference, None))]
    return [Item(f"{name}:{one}", partial(read_train, train, reference, one)) for one in names]
