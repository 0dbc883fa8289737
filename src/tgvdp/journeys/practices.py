"""How timetables split a running-time supplement over the sections today, whatever that costs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.section import SectionRuns

_Floats = NDArray[np.float64]


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
