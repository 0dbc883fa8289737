"""A sentence for the driver: where to drive, coast and brake along a run."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.runs.instructions import Instruction, instructions_of
from tgvdp.runs.samples import passing_s
from tgvdp.units import KILO, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.model.track import Track
    from tgvdp.model.trip import Trip
    from tgvdp.report.columns import Columns

#: Up to this length of a run places are told to ten metres, beyond it to a hundred.
_SHORT_M = 20_000.0
#: Full traction that gains less than this, km/h, is no acceleration: it climbs.
_GAINS_KMH = 1.0


def sentence(track: "Track", steps: Sequence[Instruction]) -> str:
    """Say the steps of a run as one sentence.

    Parameters
    ----------
    track : Track
        Whose places have names.
    steps : sequence of Instruction
        As of `instructions_of`, one at least.
    """
    parts = list(_parts(track, steps))
    text = parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])}, then {parts[-1]}"
    return f"{text[0].upper()}{text[1:]}."


def step_object(step: Instruction) -> dict[str, str | float]:
    """A step in plain types, speeds in km/h."""
    return {
        "action": step.action,
        "from_m": step.from_m,
        "to_m": step.to_m,
        "from_s": step.from_s,
        "to_s": step.to_s,
        "from_kmh": mps_to_kmh(step.from_mps),
        "to_kmh": mps_to_kmh(step.to_mps),
    }


def step_columns(runs: Iterable[tuple[str, Sequence[Mapping[str, Any]]]], name: str = "id") -> "Columns":
    """Columns of ``advice.csv``: one row per step of each run, from what runs are told apart by and their steps."""
    rows = [{name: run, "step": number, **step} for run, steps in runs for number, step in enumerate(steps, 1)]
    return {name: [row[name] for row in rows] for name in rows[0]}


def names_of(trip: "Trip") -> dict[str, str]:
    """Names of the two ends of a trip, ``from`` and ``to``, as far as the line has them."""
    ends = {"from": trip.origin_m, "to": trip.destination_m}
    return {end: name for end, at_m in ends.items() if (name := trip.track.name_at(at_m))}


def journey_advice(result: "JourneyResult") -> dict[str, Any]:
    """What the driver does at the middle point of a journey: its number from 1 on, and each section's advice."""
    index = len(result.front) // 2
    steps = [instructions_of(profile) for profile in result.section_profiles(index)]
    sections = [{"advice": sentence(result.trip.track, own), "steps": list(map(step_object, own))} for own in steps]
    return {"point": index + 1, "sections": sections}


def journey_passing(result: "JourneyResult") -> Callable[[float], tuple[float, float]]:
    """When the middle point of a journey arrives at a position and departs, s on the clock of its timetable."""
    index = len(result.front) // 2
    profile, start_s = result.profile(index), float(result.found.departure_s[index, 0])

    def passing(position_m: float) -> tuple[float, float]:
        arrival_s, departure_s = passing_s(profile, position_m)
        return start_s + arrival_s, start_s + departure_s

    return passing


def _parts(track: "Track", steps: Sequence[Instruction]) -> Iterator[str]:
    last = len(steps) - 1
    decimals = 2 if steps[-1].to_m - steps[0].from_m < _SHORT_M else 1
    for index, step in enumerate(steps):
        before, after = _kmh(step.from_mps), _kmh(step.to_mps)
        until = _place(track, step.to_m, decimals)
        to_place = f"to {until} ({after} km/h)"
        if step.action == "power":
            gains = after - before >= _GAINS_KMH and index < last
            is_held = index < last and steps[index + 1].action == "hold"
            reached = _held_kmh(steps[index + 1]) if is_held else after
            yield f"accelerate to {reached} km/h" if gains else f"full power {to_place}"
        elif step.action == "hold":
            yield f"hold {_held_kmh(step)} km/h to {until}"
        elif step.action == "partial":
            yield f"partial effort {to_place}"
        elif step.to_mps == 0.0:
            yield f"{step.action} to stop at {until}"
        elif step.action == "brake" and after <= before:
            yield f"brake to {after} km/h by {until}"
        else:  # under brakes, too, a train may gain speed downhill
            yield f"{step.action} {to_place}"


def _held_kmh(step: Instruction) -> int:
    """The speed that a step holds, which takes the time that it takes."""
    return _kmh((step.to_m - step.from_m) / (step.to_s - step.from_s))


def _kmh(speed_mps: float) -> int:
    return round(mps_to_kmh(speed_mps))


def _place(track: "Track", at_m: float, decimals: int) -> str:
    kilometre = f"km {at_m / KILO:.{decimals}f}"
    name = track.name_at(at_m)
    return f"{name} ({kilometre})" if name else kilometre
