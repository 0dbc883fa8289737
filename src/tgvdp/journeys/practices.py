"""How timetables split a running-time supplement over the sections today, whatever that costs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.section import SectionRuns
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, profile_of

_Floats = NDArray[np.float64]

#: A ratio that differs from 1 by less differs by rounding.
_SAME = 1e-12


def practices(sections: Sequence[SectionRuns], total_s: _Floats) -> dict[str, _Floats]:
    """Supplements of each section, s, (n, sections), by the practice's name.

    UIC leaflet 451-1 gives supplements as a share of the running time or per distance; many timetables keep what is
    left for the last section, before the train is measured.
    """
    time_s = np.array([section.fastest.duration_s for section in sections])
    distance_m = np.array([section.trip.distance_m for section in sections])
    last = np.zeros(len(sections))
    last[-1] = 1.0
    return {
        "proportional_to_time": np.outer(total_s, time_s / time_s.sum()),
        "proportional_to_distance": np.outer(total_s, distance_m / distance_m.sum()),
        "all_at_the_end": np.outer(total_s, last),
    }


def linear_margin(trip: Trip, fastest: Profile, ratio: float) -> Profile:
    """Run as the linear margin defines it: the fastest run with all speeds divided by one ratio.

    Every stretch then takes that ratio of its fastest time, the whole run included.
    """
    if ratio <= 1.0 + _SAME:
        return fastest
    return profile_of(trip, fastest.position_m - trip.origin_m, (fastest.speed_mps / ratio) ** 2)
