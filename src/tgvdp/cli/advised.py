"""Advice in the format that a line came in: that of SFERA goes back to a driver advisory system."""

from typing import TYPE_CHECKING

from tgvdp.cli.search_case import Case

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.formats.sfera.write import AdvisableJourney

#: The journey with the advice of its middle point.
_MESSAGE = "sfera.xml"
#: Why there is none.
UNADVISED = f"no {_MESSAGE}: the journey that the line was read from has other stops, or the other direction"


def advisable(case: Case) -> "AdvisableJourney | None":
    """Read the message that a line came in, where that is a journey of SFERA."""
    if case.line is None or case.line.format != "SFERA":
        return None
    from tgvdp.formats.sfera.write import AdvisableJourney
    from tgvdp.formats.sources import Target

    return AdvisableJourney(Target(case.line.path, case.line.part))


def advised(journey: "AdvisableJourney | None", result: "JourneyResult") -> dict[str, bytes]:
    """Files with the advice of a journey's middle point, by name: one, or none where it is run otherwise."""
    if journey is None or result.options["reverse"]:
        return {}
    from tgvdp.report.advice import journey_advice, journey_passing

    steps = [step for section in journey_advice(result)["sections"] for step in section["steps"]]
    message = journey.advised(result.options["stops_m"], steps, journey_passing(result))
    return {} if message is None else {_MESSAGE: message}
