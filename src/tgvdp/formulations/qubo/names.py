"""Names of the encodings and of the rules for the penalty, as the command line takes them; loads nothing."""

from typing import Literal, TypeAlias, get_args

Encoding: TypeAlias = Literal["bits", "bits+slack", "unary"]
#: Encodings of the binary model as a QUBO.
ENCODINGS: tuple[Encoding, ...] = get_args(Encoding)

PenaltyName: TypeAlias = Literal["sufficient", "tenfold"]
PENALTIES: tuple[PenaltyName, ...] = get_args(PenaltyName)
#: A rule, or the weight itself in (m/s)² per squared unit of violation.
PenaltyRule: TypeAlias = PenaltyName | float


def parse_penalty(text: str) -> PenaltyRule:
    """Read a rule's name or a weight.

    Raises
    ------
    ValueError
        When it is neither a name nor a positive number.
    """
    for name in PENALTIES:
        if text == name:
            return name
    weight = float(text)
    if not 0.0 < weight < 1e30:
        raise ValueError(f"{text!r} is no positive number")
    return weight
