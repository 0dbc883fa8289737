"""What a journey and its segments hold that was not used, told by names, without what is for people to see."""

from collections import Counter
from collections.abc import Iterator, Sequence

from tgvdp.formats.sfera.segments import Segment
from tgvdp.formats.sfera.swiss import GROUPS
from tgvdp.formats.syntax.xml import Node, counted

#: Longest note, so that it stays one line that can be read.
LONGEST_NOTE = 400
#: Names, versions, dates, and what is for people to see.
_ELEMENTS = (
    "SP_Zone",
    "SP_ContextInformation",
    "JP_ContextInformation",
    "SP_NextSP",
    "ChangeReason",
    "TrainIdentification",
)
_ATTRIBUTES = (
    "JP_Status", "JP_Version", "SP_ID", "SP_Name", "SP_VersionMajor", "SP_VersionMinor", "SP_Status", "datePublished",
    "dateStartApplication", "dateEndApplication", "UTC_Offset",
    "{http://www.w3.org/2001/XMLSchema-instance}noNamespaceSchemaLocation",
)  # fmt: skip


def unused_notes(journey: Node, segments: Sequence[Segment]) -> Iterator[str]:
    """Say what was not used, after all else has been read."""
    constraints: Counter[str] = Counter()
    groups: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    for segment in segments:
        for one in segment.reference.children("TemporaryConstraints"):
            if one.child("AdditionalSpeedRestriction") is None:
                constraints[one.text("temporaryConstraintType") or "of no type"] += 1
            one.dismiss()
        for point in segment.profile.below("SP_Points", "NetworkSpecificPoint"):
            names = [name.content for name in point.children("NSP_GroupName")]
            groups.update(name for name in names if name not in GROUPS)
            point.dismiss()
        for signal in segment.profile.below("SP_Points", "Signal"):
            for one in signal.children("Signal_ID", "SignalFunction", "SignalPhysicalCharacteristics"):
                one.dismiss()
        for place in segment.profile.below("SP_Areas", "TAF_TAP_Location"):
            place.dismiss()
        for train in segment.reference.children("TrainCharacteristicsRef"):
            train.dismiss()
        _dismiss(segment.reference)
        _dismiss(segment.profile)
        counts += segment.profile.unused_counts()
    _dismiss(journey)
    counts += journey.unused_counts()
    for text, found in (
        ("temporary constraints that are not used", constraints),
        ("network-specific points that are not used", groups),
        ("not used", counts),
    ):
        if found:
            yield f"{text}: {', '.join(counted(found))}"[:LONGEST_NOTE]


def _dismiss(node: Node) -> None:
    for attribute in _ATTRIBUTES:
        node.text(attribute)
    for child in node.children(*_ELEMENTS):
        child.dismiss()
