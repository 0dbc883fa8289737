"""What a train is to speed limits: categories of SFERA, and the train and brake series of Swiss line speeds."""

from dataclasses import dataclass

from tgvdp.formats.sfera.messages import TRAIN, Messages
from tgvdp.formats.syntax.xml import Node

_ETCS = ("Freight_Train_P_Position", "Freight_Train_G_Position", "Passenger_Train")
_OF_A_TRAIN = ("TC_ID", "TC_VersionMajor", "TC_VersionMinor", "trainLength", "trainWeight", "trainMaxSpeed")
#: Largest braked weight percentage that the schema takes.
_MOST_PCT = 500.0


@dataclass(frozen=True)
class Category:
    """What the train of a journey is, as far as its TrainCharacteristics say; None and empty where they do not.

    Attributes
    ----------
    name : str
        Of the TrainCharacteristics.
    code : str
        ``trainCategoryCode``: a free text, in Switzerland the train series (R, A, D, N, ...).
    braked_pct : float or None
        Braked weight percentage, in Switzerland the brake series.
    etcs : str
        ``NC_Train``.
    cant_mm : float or None
        Cant deficiency that it is made for, mm.
    """

    name: str = ""
    code: str = ""
    braked_pct: float | None = None
    etcs: str = ""
    cant_mm: float | None = None

    def __str__(self) -> str:
        braked = "" if self.braked_pct is None else f"{self.braked_pct:g}"
        return " ".join(filter(None, (self.code, braked))) or "a train of no category"


def category_of(features: Node, name: str) -> Category:
    """Read the categories of a train."""
    braked_pct = features.number("brakedWeightPercentage", "%", at_least=0.0)
    if braked_pct is not None and braked_pct > _MOST_PCT:
        raise features.bad(f"must be at most {_MOST_PCT:g} %, got {braked_pct:g} %", "brakedWeightPercentage")
    etcs = features.choice("NC_Train", _ETCS)
    return Category(
        name, features.text("trainCategoryCode") or "", braked_pct, etcs or "", millimetres(features, "NC_CDTrain")
    )


def millimetres(node: Node, attribute: str) -> float | None:
    """A cant deficiency, written as 150mm; None when absent."""
    text = node.text(attribute)
    if text is None:
        return None
    digits = text.removesuffix("mm")
    if digits == text or not (digits.isascii() and digits.isdigit() and len(digits) < 4):
        raise node.bad(f"must be a cant deficiency such as 150mm, got {text!r:.40}", attribute)
    return float(digits)


def train_of(messages: Messages, journey: Node) -> tuple[Node, Node] | None:
    """The first TrainCharacteristics of a journey, with the reference to it; None when it refers to none."""
    references = references_of(journey)
    return (messages.find(TRAIN, references[0]), references[0]) if references else None


def identity(reference: Node) -> tuple[str | None, ...]:
    """What tells one train of journeys from another: which it is, and what the journey says of it."""
    owners = reference.children("TC_RU_ID", "teltsi_KeeperShortNameVKM")
    return *map(reference.text, _OF_A_TRAIN), *(owner.content for owner in owners)


def references_of(journey: Node) -> list[Node]:
    """All references of a journey to TrainCharacteristics, in the order of the run."""
    return journey.below("SegmentProfileReference", "TrainCharacteristicsRef")
