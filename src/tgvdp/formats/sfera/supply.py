"""Where a journey has no traction current: limits of the current to 0 A, and signals that tell to switch off.

A train may run through with its pantograph up, unless a signal tells to lower it.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from tgvdp.formats.sfera.segments import Cap, Segment, lowest
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import LOWERED, NEUTRAL, NeutralSection

#: Instruction that ends each, and what holds in between.
_ENDS = {
    "Traction_Off": ("Traction_On", NEUTRAL),
    "Main_Switch_Off": ("Main_Switch_On", NEUTRAL),
    "Pantograph_Down": ("Pantograph_Up", LOWERED),
    "Powerless": ("Electrical", NEUTRAL),
}
#: What SUBSET-126 says for no limit of the current, A.
_UNLIMITED_A = 1023.0


class _Order(NamedTuple):
    """What a signal tells the driver, and where."""

    at_m: float
    instruction: str


def neutral_sections(segments: Sequence[Segment]) -> tuple[tuple[NeutralSection, ...], list[str]]:
    """Stretches without traction current along the run, and what there is to say of them.

    Raises
    ------
    InputError
        When a location or a current is wrong.
    """
    caps, notes, limited = [], [], 0
    for segment in segments:
        for owner in segment.profile.below("SP_Characteristics", "CurrentLimitation"):
            for from_m, to_m, node in segment.changes(owner):
                current_a = node.required_number("maxCurValue", "A", at_least=0.0)
                limited += 0.0 < current_a != _UNLIMITED_A
                if current_a == 0.0:
                    caps.append(Cap(from_m, to_m, -NEUTRAL))
    orders = [order for segment in segments for order in _orders(segment)]
    for first, (last, state) in _ENDS.items():
        begun_m: float | None = None
        # At one place what ends comes before what begins there.
        for order in sorted(orders, key=lambda one: (one.at_m, one.instruction in _ENDS)):
            if order.instruction == first and begun_m is None:
                begun_m = order.at_m
            elif order.instruction == last and begun_m is not None:
                caps.append(Cap(begun_m, order.at_m, -state))
                begun_m = None
        if begun_m is not None:
            caps.append(Cap(begun_m, segments[-1].end_m, -state))
            notes.append(f"no {last} after {first} at {begun_m:.12g} m: it holds to the end")
    if limited:
        notes.append(f"limits of the current above 0 A that are not used: {limited}")
    length_m = segments[-1].end_m
    ends = pairwise([*lowest(caps, length_m), (length_m, None)])
    held = [(at_m, to_m, state) for (at_m, state), (to_m, _) in ends if state is not None]
    made = tuple(NeutralSection(at_m, to_m - at_m, -state == LOWERED) for at_m, to_m, state in held)
    return made, notes


def _orders(segment: Segment) -> Iterator[_Order]:
    """Instructions of the signals that count in the direction of the run; those that count elsewhere are not read."""
    for signal in segment.profile.below("SP_Points", "Signal"):
        towards = signal.choice("directionOfApplicationOnSP", ("Nominal", "Reverse", "Both")) or "Nominal"
        if signal.child("SignalApplication") is not None or towards == ("Reverse" if segment.forward else "Nominal"):
            continue
        for instruction in _instructions(signal):
            yield _Order(segment.at_m(signal.required("Signal_ID")), instruction)


def _instructions(signal: Node) -> Iterator[str]:
    for node in signal.below("SignalInformation", "PowerConstraint"):
        yield node.required_text("powerConstraintInstruction")
    for node in signal.below("SignalInformation", "TractionTypeTransition", "TractionTypeTransitionElectric"):
        for child in node.children("Powerless", "Electrical"):
            yield child.name
