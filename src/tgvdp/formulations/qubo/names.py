"""Words for encodings and penalties, as the command line takes them; loads nothing."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias, get_args

if TYPE_CHECKING:
    from tgvdp.formulations.problem.binary import DistanceRule

#: Word for an encoding of the binary model as a QUBO, as `parse_encoding` reads it.
Encoding: TypeAlias = str
#: Domain walls; with the distance as a square, or as a linear term.
UNARY, MULTIPLIER = "unary", "unary+multiplier"
#: Those in the corrected form: ``bits`` alone holds no speed limits, the others hold all constraints.
ENCODINGS: tuple[Encoding, ...] = ("bits", "bits+slack", "unary")

SpeedLimits: TypeAlias = Literal["none", "slack", "total", "total-equality"]
#: Parts of a word.
_LIMITS = get_args(SpeedLimits)[1:]
_DISTANCE_RULES = ("left", "right")


@dataclass(frozen=True)
class BitsForm:
    """Which of the printed and of the corrected forms of the two-bit encoding to build.

    Attributes
    ----------
    limits : str
        Of speeds: ``none``; ``slack``, one register per step, as corrected; ``total``, a·Σx ≤ h as printed; or
        ``total-equality``, the same as an equality.
    distance : str
        ``trapezoid`` (method 2 of the binary formulation), ``left``, or ``right`` (method 1).
    mccormick : bool
        Whether to forbid x_i·y_i by z_i rather than directly.
    cubic : bool
        For the efficiency model: the intended objective Σ x_i·a·v_avg·(η0 − Δη·s_i), reduced to degree two.
    """

    limits: SpeedLimits = "none"
    distance: "DistanceRule" = "trapezoid"
    mccormick: bool = False
    cubic: bool = False

    @property
    def word(self) -> Encoding:
        """``bits`` and what differs from it, in the order of the attributes."""
        parts: list[str] = [part for part in (self.limits, self.distance) if part not in ("none", "trapezoid")]
        parts += [name for name in ("mccormick", "cubic") if getattr(self, name)]
        return "+".join(("bits", *parts))


def bits_form(word: Encoding) -> BitsForm:
    """Read ``bits[+slack|+total|+total-equality][+left|+right][+mccormick][+cubic]``, its parts in any order.

    Raises
    ------
    ValueError
        When it is none of these.
    """
    start, *parts = word.split("+")
    fields: dict[str, str | bool] = {}
    for part in parts:
        field = {**dict.fromkeys(_LIMITS, "limits"), **dict.fromkeys(_DISTANCE_RULES, "distance")}.get(part, part)
        if field in fields or part in ("limits", "distance") or field not in BitsForm.__dataclass_fields__:
            raise ValueError(f"{word!r} is no encoding")
        fields[field] = part if part != field else True
    if start != "bits":
        raise ValueError(f"{word!r} is no encoding")
    return BitsForm(**fields)  # type: ignore[arg-type]


def parse_encoding(text: str) -> Encoding:
    """Read a word, and write its parts in one order.

    Raises
    ------
    ValueError
        When it is none.
    """
    return text if text in (UNARY, MULTIPLIER) else bits_form(text).word


class Weights(NamedTuple):
    """Weights of squared violations of one unit, by kind: λ₁ to λ₄ of the three-phase formulation.

    Attributes
    ----------
    logic : float
        Of what bits may not be at once: both accelerate and brake, unary bits out of order.
    distance, stop, limit : float
        Of distances in Δv·Δt, of the speed at the end and of speed limits, both in Δv. Of trains at one substation the
        limit is that of its power, in the whole units of the equation of a step.
    """

    logic: float = 1.0
    distance: float = 1.0
    stop: float = 1.0
    limit: float = 1.0


def kinds_of(encoding: Encoding, *, shared: bool = False) -> tuple[str, ...]:
    """Kinds of violations that an encoding can have, fields of `Weights`; ``shared`` is of trains at a substation."""
    if shared:
        return ("logic", "distance", "limit")
    if encoding in (UNARY, MULTIPLIER):
        return Weights._fields[: 2 if encoding == UNARY else 1]
    return Weights._fields[: 3 if bits_form(encoding).limits == "none" else 4]


PenaltyName: TypeAlias = Literal["sufficient", "tenfold"]
PENALTIES: tuple[PenaltyName, ...] = get_args(PenaltyName)
#: A rule, the weight of all violations in (m/s)² per squared unit, or one for each of `kinds_of` the encoding.
PenaltyRule: TypeAlias = PenaltyName | float | tuple[float, ...]


def parse_penalty(text: str) -> PenaltyRule:
    """Read a rule's name, a weight, or two to four of them with slashes between.

    Raises
    ------
    ValueError
        When it is none of these.
    """
    for name in PENALTIES:
        if text == name:
            return name
    weights = tuple(float(part) for part in text.split("/"))
    if len(weights) > len(Weights._fields) or not all(0.0 < weight < 1e30 for weight in weights):
        raise ValueError(f"{text!r} holds no positive numbers, or too many")
    return weights if len(weights) > 1 else weights[0]


def penalty_word(penalty: PenaltyRule) -> str:
    """What `parse_penalty` reads."""
    weights = penalty if isinstance(penalty, tuple) else (penalty,)
    return "/".join(one if isinstance(one, str) else f"{one:.12g}" for one in weights)
