"""A journey's segments as a line: gradients, curves, tunnels, limits, neutral sections, and places with names."""

import math
from collections.abc import Sequence

from tgvdp.errors import InputError
from tgvdp.formats.sfera.category import Category, category_of, identity, references_of, train_of
from tgvdp.formats.sfera.limits import speed_limits
from tgvdp.formats.sfera.messages import Messages, journey_name
from tgvdp.formats.sfera.segments import Segment, joined, segments_of
from tgvdp.formats.sfera.supply import neutral_sections
from tgvdp.formats.sfera.timetable import calls_of
from tgvdp.formats.sfera.train import NO_TRAIN, lacking, lacks_note
from tgvdp.formats.sfera.unused import LONGEST_NOTE, unused_notes
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import Curve, Gradient, Place, Track, Tunnel


def read_line(messages: Messages, journey: Node, line_speed_kmh: float | None) -> Track:
    """Make the line of a journey.

    Raises
    ------
    InputError
        When a segment is not at hand, or something in it is wrong or not within it; when there is no limit somewhere,
        and no line speed.
    """
    journey = journey.fresh()
    segments = segments_of(messages, journey)
    category, category_notes, train_notes = _category(messages, journey)
    limits, limit_notes = speed_limits(segments, category, line_speed_kmh)
    neutral, neutral_notes = neutral_sections(segments)
    gradients, gradient_notes = _gradients(segments)
    tunnels, tunnel_notes = _tunnels(segments)
    curves, curve_notes = _curves(segments)
    calls = calls_of(segments)
    # Of many notes the first ones are shown: what was assumed comes first, and last what another train makes up for.
    notes = [*category_notes, *limit_notes, *gradient_notes, *curve_notes, *tunnel_notes, *neutral_notes]
    notes += [*unused_notes(journey, segments), *train_notes]
    try:
        return Track(
            name=journey_name(journey),
            length_m=segments[-1].end_m,
            speed_limits=limits,
            gradients=gradients,
            curves=curves,
            tunnels=tunnels,
            neutral_sections=neutral,
            stops_m=tuple(call.position_m for call in calls if call.stops),
            places=tuple(Place(call.position_m, call.name) for call in calls),
            notes=tuple(notes),
        )
    except InputError as error:
        raise journey.bad(str(error)) from None


def _category(messages: Messages, journey: Node) -> tuple[Category, list[str], list[str]]:
    """What the train of a journey is, what is to be said of that, and what it lacks to be run."""
    found = train_of(messages, journey)
    if found is None:
        return Category(), [], [NO_TRAIN]
    train, reference = found
    features = train.required("TC_Features")
    category = category_of(features, f"TrainCharacteristics {reference.text('TC_ID')}")
    changes = len(set(map(identity, references_of(journey)))) > 1
    return (
        category,
        [f"the train changes on the way: {category.name} is taken all along"] if changes else [],
        [lacks_note(train, reference)] if lacking(features, reference) else [],
    )


def _gradients(segments: Sequence[Segment]) -> tuple[tuple[Gradient, ...], list[str]]:
    """Gradients in ‰, + uphill as the train runs; segments without any are level."""
    rows: list[tuple[float, float]] = []
    level = []
    for segment in segments:
        owners = segment.profile.below("SP_Characteristics", "Gradient")
        if not owners:
            level.append(segment)
            rows.append((segment.offset_m, 0.0))
        for owner in owners:
            rows += ((at_m, _permil(node, segment.forward)) for at_m, _, node in segment.changes(owner))
    kept = [row for at, row in enumerate(rows) if at == 0 or row[1] != rows[at - 1][1]]
    made = () if len(level) == len(segments) else tuple(Gradient(*row) for row in kept)
    return made, _absent("gradients", "level", level, segments)


def _absent(what: str, instead: str, without: Sequence[Segment], segments: Sequence[Segment]) -> list[str]:
    """Say which segments say nothing of something."""
    if len(without) == len(segments):
        return [f"no {what}: the line is taken as {instead}"]
    names = ", ".join(segment.profile.required_text("SP_ID") for segment in without)
    return [f"no {what} on {names}: taken as {instead}"[:LONGEST_NOTE]] if without else []


def _permil(node: Node, forward: bool) -> float:
    permil = node.required_number("gradientValue", "‰", at_least=0.0)
    direction = node.choice("gradientDirection", ("Downhill", "Uphill"))
    if permil and direction is None:
        raise node.bad("missing attribute", "gradientDirection")
    return permil if (direction == "Uphill") == forward else -permil


def _curves(segments: Sequence[Segment]) -> tuple[tuple[Curve, ...], list[str]]:
    """Curves of constant radius; 0 m is straight, and so are segments that say nothing of curves."""
    made: list[Curve] = []
    straight = []
    for segment in segments:
        owners = segment.profile.below("SP_Characteristics", "Curves")
        if not owners:
            straight.append(segment)
            made.append(Curve(segment.offset_m, math.inf, math.inf))
        for owner in owners:
            for at_m, _, node in segment.changes(owner):
                radius_m = node.required_number("curveRadius", "m", at_least=0.0) or math.inf
                node.choice("curveDirection", ("Unknown", "Left", "Right"))
                made.append(Curve(at_m, radius_m, radius_m))
    notes = _absent("curves", "straight", straight, segments)
    return () if all(math.isinf(curve.radius_start_m) for curve in made) else tuple(made), notes


def _tunnels(segments: Sequence[Segment]) -> tuple[tuple[Tunnel, ...], list[str]]:
    """Tunnels whose cross section is known."""
    stretches = sorted((one for segment in segments for one in segment.areas("Tunnel")), key=lambda one: one[:2])
    areas = [(one, one.node.number("tunnelFactor", "m²", above=0.0)) for one in stretches]
    known = [(one.from_m, one.to_m, area_m2) for one, area_m2 in areas if area_m2 is not None]
    made = tuple(Tunnel(from_m, to_m - from_m, area_m2) for from_m, to_m, area_m2 in joined(known))
    unknown = len(stretches) - len(known)
    return made, [f"tunnels without tunnelFactor (cross section) that are not used: {unknown}"] if unknown else []
