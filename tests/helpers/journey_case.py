"""A metro line of four sections for journeys."""

from dataclasses import replace

import numpy as np

from tests.helpers.metro_case import TRAIN
from tgvdp import Gradient, SpeedLimit, Track
from tgvdp.api.methods import continuous_front
from tgvdp.journeys.section import SectionRuns
from tgvdp.methods.budget import SearchBudget
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run

METRO = TRAIN
LINE = Track(
    name="metro line",
    length_m=6000.0,
    stops_m=(0.0, 1200.0, 3400.0, 4300.0, 6000.0),
    speed_limits=(SpeedLimit(0.0, 22.0), SpeedLimit(2000.0, 17.0), SpeedLimit(2500.0, 22.0)),
    gradients=(Gradient(0.0, 0.0), Gradient(1500.0, -15.0), Gradient(2600.0, 20.0), Gradient(3400.0, 0.0)),
)


def method(trip, fastest, target_s, tolerance_s):
    return continuous_front(trip, fastest, target_s, SearchBudget(), tolerance_s)


def sections_of(line=LINE, train=METRO):
    whole = Trip(train=train, track=line, origin_m=0.0, destination_m=line.length_m)
    ends_m = zip(line.stops_m, line.stops_m[1:], strict=False)
    trips = [replace(whole, origin_m=from_m, destination_m=to_m) for from_m, to_m in ends_m]
    return [SectionRuns(trip, fastest_run(trip), method) for trip in trips]


def fine_merge_j(sections, supplement_s, step_s=0.2):
    """Least energy by trying all splits on fine steps, each section's front solved anew: slow, and no multiplier."""
    count = int(supplement_s / step_s) + 1
    energy_j = None
    for section in sections:
        target_s = section.fastest.duration_s + step_s * np.arange(count + 1)
        runs = method(section.trip, section.fastest, target_s, 1e-3)
        own_j = runs.energy_j[np.searchsorted(runs.duration_s, target_s * (1.0 + 1e-9), side="right") - 1]
        if energy_j is None:
            energy_j = own_j
        else:
            sums_j = [(energy_j[: total + 1] + own_j[total::-1]).min() for total in range(count + 1)]
            energy_j = np.array(sums_j)
    return float(np.interp(supplement_s, step_s * np.arange(count + 1), energy_j))
