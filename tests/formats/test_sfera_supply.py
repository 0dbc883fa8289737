"""Where SFERA journeys have no traction current: by limits of the current, and by signals."""

import re

import pytest

from tests.helpers.sfera_case import message
from tgvdp.formats import load_track
from tgvdp.model.track import NeutralSection

pytest.importorskip("lxml")


def signal(at_m, inner, more=""):
    return (
        f'<Signal {more}><Signal_ID signal_ID_Physical="x{at_m}" location="{at_m}"/>'
        f"<SignalInformation>{inner}</SignalInformation></Signal>"
    )


def power(at_m, instruction, more=""):
    return signal(at_m, f'<PowerConstraint powerConstraintInstruction="{instruction}"/>', more)


def transition(at_m, kind):
    inner = f"<TractionTypeTransitionElectric><{kind}/></TractionTypeTransitionElectric>"
    return signal(at_m, f"<TractionTypeTransition>{inner}</TractionTypeTransition>")


@pytest.mark.parametrize(
    ("signals", "expected"),
    [
        ((power(100, "Traction_Off"), power(300, "Traction_On")), [(100, 200, False)]),
        ((power(100, "Main_Switch_Off"), power(300, "Main_Switch_On")), [(100, 200, False)]),
        ((transition(100, "Powerless"), transition(300, "Electrical")), [(100, 200, False)]),
        ((power(300, "Traction_On"), power(100, "Traction_Off")), [(100, 200, False)]),
        # One ends where the next one begins.
        (
            (power(100, "Traction_Off"), power(300, "Traction_On"),
             power(300, "Traction_Off"), power(450, "Traction_On")),
            [(100, 350, False)],
        ),
        # Within a stretch without current the pantograph is lowered.
        (
            (power(100, "Main_Switch_Off"), power(200, "Pantograph_Down"), power(250, "Pantograph_Up"),
             power(300, "Main_Switch_On")),
            [(100, 100, False), (200, 50, True), (250, 50, False)],
        ),
        # Signals of the other direction do not count.
        ((power(100, "Traction_Off", 'directionOfApplicationOnSP="Reverse"'), power(300, "Traction_On")), []),
        ((power(100, "HVAC_Off"), power(300, "HVAC_On")), []),
        ((power(3900, "Traction_Off"),), [(3900, 6100, False)]),
    ],
)  # fmt: skip
def test_neutral_sections_by_signals(saved_xml, signals, expected):
    bare = re.sub(r"<Signal>.*</Signal>|<CurrentLimitation>.*</CurrentLimitation>", "", message(), flags=re.DOTALL)
    track = load_track(saved_xml(bare.replace("</SP_Points>", f"{''.join(signals)}</SP_Points>", 1)))
    assert track.neutral_sections == tuple(NeutralSection(*one) for one in expected)
    assert any(note.startswith("no Traction_On after Traction_Off at 3900 m") for note in track.notes) == (
        len(signals) == 1
    )


def test_limits_of_the_current_above_nothing_do_not_act(saved_xml):
    text = message().replace('maxCurValue="0"', 'maxCurValue="400"')
    track = load_track(saved_xml(text))
    assert track.neutral_sections == (NeutralSection(1000.0, 200.0, True),)
    assert "limits of the current above 0 A that are not used: 1" in track.notes
