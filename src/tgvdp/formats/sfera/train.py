"""TrainCharacteristics as a train, where they hold all that running takes.

Masses in t, forces in N over speeds in km/h, rollout coefficients in N, N/(m/s) and N/(m/s)². Forces are linear between
points and constant after the last one.
"""

import math

from tgvdp.errors import InputError
from tgvdp.formats.sfera.messages import KEYS, TRAIN
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.checks import plain_text
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate, Train
from tgvdp.units import KILO, kmh_to_mps

_ANOTHER = "the train comes from another file (--train FILE)"
#: What a journey says that refers to no train.
NO_TRAIN = f"no TrainCharacteristics: {_ANOTHER}"
_COEFFICIENTS = (("rolloutCoefficientA", "N"), ("rolloutCoefficientB", "N/(m/s)"), ("rolloutCoefficientC", "N/(m/s)²"))
#: Factors of rotating mass are 1 and a bit; twice the mass is a slip of the pen.
_MOST_FACTOR = 2.0


def lacking(features: Node, reference: Node | None = None) -> list[str]:
    """What a train needs to be run and its features do not say."""

    def given(name: str) -> bool:
        return features.has(name) or (reference is not None and reference.has(name))

    braked = bool(features.children("BrakingForceCurve")) or features.has("comfortableBraking")
    known = {
        "trainWeight": given("trainWeight"),
        "TractionForceCurve": bool(features.children("TractionForceCurve")),
        "rolloutCoefficientA, B and C": any(features.has(one) for one, _ in _COEFFICIENTS),
        "BrakingForceCurve or comfortableBraking": braked,
    }
    return [name for name, is_there in known.items() if not is_there]


def lacks_note(train: Node, reference: Node | None) -> str:
    """Say what a train lacks to be run, and what helps."""
    lacks = ", ".join(lacking(train.required("TC_Features"), reference))
    return f"TrainCharacteristics {train.text('TC_ID')} lacks {lacks}: {_ANOTHER}"


def variants(train: Node) -> list[str]:
    """Names of the tractions of a train: identifiers of its curves, or their numbers; none where there is one curve."""
    curves = train.required("TC_Features").children("TractionForceCurve")
    names = [curve.text("identifier") or str(number) for number, curve in enumerate(curves, 1)]
    return names if len(names) > 1 else []


def read_train(train: Node, reference: Node | None, variant: str | None) -> Train:
    """Make a train of its characteristics, and of what a journey's reference to it overrides.

    Parameters
    ----------
    train : Node
    reference : Node or None
    variant : str or None
        One of `variants`, where there are any.

    Raises
    ------
    InputError
        When something that running takes is missing, or a value is wrong.
    """
    train = train.fresh()
    features = train.required("TC_Features")
    name = train.required_text("TC_ID")
    if lacking(features, reference):
        raise features.bad(lacks_note(train, reference))

    def number(attribute: str, unit: str) -> float | None:
        value = features.number(attribute, unit, above=0.0)
        own = None if reference is None else reference.number(attribute, unit, above=0.0)
        return value if own is None else own

    curves, brakes = features.children("TractionForceCurve"), features.children("BrakingForceCurve")
    if len(brakes) > 1:
        raise brakes[1].bad(f"{len(brakes)} BrakingForceCurves, of which none is chosen: leave one")
    mass_t, length_m, top_kmh = number("trainWeight", "t"), number("trainLength", "m"), number("trainMaxSpeed", "km/h")
    comfort_mps2 = features.number("comfortableBraking", "m/s²", above=0.0)
    factor, notes = _rotating_mass(features)
    notes += [f"no {one}: {instead}" for one, value, instead in (
        ("trainMaxSpeed", top_kmh, "the train has no top speed"), ("trainLength", length_m, "the train is a point"),
    ) if value is None]  # fmt: skip
    notes += [f"traction is the TractionForceCurve {variant}, one of {len(curves)}"] if variant else []
    notes += [] if brakes else ["full braking is comfortableBraking: there is no BrakingForceCurve"]
    davis = [features.number(*one, at_least=0.0) or 0.0 for one in _COEFFICIENTS]
    traction = _effort(curves[variants(train).index(variant) if variant else 0], "traction")
    braking = _effort(brakes[0], "braking") if brakes else EffortCurve.from_caps(0.0)
    most_mps2 = features.number("comfortableAcceleration", "m/s²", above=0.0)
    try:
        return Train(
            name=plain_text(features.text("displayName") or "") or name,
            mass_kg=(mass_t or 0.0) * KILO,
            rotating_mass_factor=factor,
            length_m=length_m or 0.0,
            max_speed_mps=math.inf if top_kmh is None else kmh_to_mps(top_kmh),
            traction=traction,
            braking=braking,
            braking_rates=(BrakingRate(0.0, comfort_mps2),) if comfort_mps2 is not None and not brakes else (),
            max_deceleration_mps2=math.inf if comfort_mps2 is None or not brakes else comfort_mps2,
            max_acceleration_mps2=math.inf if most_mps2 is None else most_mps2,
            notes=(*notes, *_unused(train)),
            davis_a_n=davis[0],
            davis_b_n_per_mps=davis[1],
            davis_c_n_per_mps2=davis[2],
        )
    except InputError as error:
        raise features.bad(str(error)) from None


def _rotating_mass(features: Node) -> tuple[float, list[str]]:
    """Factor of rotating mass, which some write without the 1 before it."""
    value = features.number("rotatingMassFactor", "-", at_least=0.0)
    if value is None:
        return 1.0, ["no rotatingMassFactor: taken as 1"]
    if value >= _MOST_FACTOR:
        raise features.bad(f"must be below {_MOST_FACTOR:g}, got {value:g}", "rotatingMassFactor")
    if value < 1.0:
        return 1.0 + value, [f"rotatingMassFactor {value:g} is below 1: taken as {1.0 + value:g}"]
    return value, []


def _effort(curve: Node, kind: str) -> EffortCurve:
    """Force over speed of traction or braking."""
    points: list[tuple[float, float]] = []
    for point in curve.children(f"{kind.title()}ForceCurveDataPoint"):
        kmh = point.required_number("speed", "km/h", at_least=0.0)
        force_n = point.required_number(f"{kind}Force", "N", at_least=0.0)
        if kmh > 0.0 if not points else kmh_to_mps(kmh) < points[-1][0]:
            raise point.bad(f"speeds must start at 0 km/h and not decrease, got {kmh:g} km/h", "speed")
        points.append((kmh_to_mps(kmh), force_n))
    if not points:
        raise curve.bad(f"missing element {kind.title()}ForceCurveDataPoint")
    for aside in ("TFC_TractionType", "BFC_TractionType", "TFC_NSPs", "BFC_NSPs"):
        for node in curve.children(aside):
            node.dismiss()
    try:
        return EffortCurve.from_points(points)
    except InputError as error:
        raise curve.bad(str(error)) from None


def _unused(train: Node) -> tuple[str, ...]:
    for aside in train.children("TC_RU_ID", "teltsi_KeeperShortNameVKM"):
        aside.dismiss()
    for attribute in (*KEYS[TRAIN], "datePublished", "dateStartApplication", "dateEndApplication"):
        train.text(attribute)
    names = train.unused()
    return (f"not used: {', '.join(names)}",) if names else ()
