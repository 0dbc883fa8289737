"""Runs slower than the thriftiest one, for windows that open later than it arrives: a second less is worth nothing.

What a second costs while nothing is driven, the power of auxiliaries, is left out first: the front method goes on to
slower runs at smaller multipliers then. Where these end as well, as on descents, speeds are capped: the highest cap
under which running longer still saves until the time that is asked for wastes least.
"""

import math
from dataclasses import replace

import numpy as np

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.section import SectionRuns
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.model.track import SpeedRestriction
from tgvdp.model.trip import Trip
from tgvdp.model.variants import restricted_track
from tgvdp.runs.caps import lowest_cap_mps
from tgvdp.runs.fastest import fastest_run

#: Stretches that are capped, as shares of the section: next to where it stands, or with room to brake and speed up.
_WHOLE, _FIRST, _MIDDLE, _LAST = (0.0, 1.0), (0.0, 0.25), (0.25, 0.75), (0.75, 1.0)
#: The lowest cap that is possible, and the highest one under which there is such a run, are known to these factors.
_LEAST_KNOWN, _KNOWN = 1.001, 1.1
#: A run that misses its time by more than this multiple of the tolerance takes another one.
_MISSED = 2.0


def slow_down(section: SectionRuns, supplement_s: float, tolerance_s: float) -> bool:
    """Make a run known to a section that takes a supplement over its fastest one, s; whether there is one.

    Raises
    ------
    NumericalError
        When the search fails.
    """
    if section.takes(supplement_s, tolerance_s):
        return True
    trip = replace(section.trip, train=replace(section.trip.train, auxiliary_power_w=0.0))
    time_s = section.fastest.duration_s + supplement_s
    found = _within(section, trip, time_s, tolerance_s)
    if found is None:
        stretches = _WHOLE, _slowest_stretch(trip)
        capped = [_capped(section, trip, stretch, time_s, tolerance_s) for stretch in stretches]
        found = min(filter(None, capped), key=lambda one: one.energy_j[-1], default=None)
    if found is not None:
        section.add(found)
    return found is not None


def _within(section: SectionRuns, trip: Trip, time_s: float, tolerance_s: float) -> OptimalRuns | None:
    """The run of a trip that takes a time, s, unless running so long saves nothing."""
    found = section.method(trip, fastest_run(trip), np.array([time_s]), tolerance_s)
    met = len(found.duration_s) > 0 and time_s - found.duration_s[-1] <= _MISSED * tolerance_s
    return found if met else None


def _slowest_stretch(trip: Trip) -> tuple[float, float]:
    if trip.start_speed_mps == 0.0:
        return _FIRST
    return _LAST if trip.end_speed_mps == 0.0 else _MIDDLE


def _capped(
    section: SectionRuns, trip: Trip, stretch: tuple[float, float], time_s: float, tolerance_s: float
) -> OptimalRuns | None:
    """The run under the highest cap on the speeds of a stretch that takes a time, s."""
    from_m, to_m = (trip.origin_m + share * trip.distance_m for share in stretch)

    def slow(cap_mps: float) -> Trip:
        return replace(trip, track=restricted_track(trip.track, [SpeedRestriction(from_m, to_m, cap_mps)]))

    def is_possible(cap_mps: float) -> bool:
        try:
            return fastest_run(slow(cap_mps)).duration_s <= time_s
        except InfeasibleError:  # it enters or leaves the stretch faster than that, or needs more speed for a climb
            return False

    top_mps = float(section.fastest.speed_mps.max())
    low_mps = lowest_cap_mps(is_possible, (to_m - from_m) / time_s, top_mps, _LEAST_KNOWN)
    high_mps = top_mps
    best = _within(section, slow(low_mps), time_s, tolerance_s)
    while best is not None and high_mps > _KNOWN * low_mps:
        cap_mps = math.sqrt(low_mps * high_mps)
        found = _within(section, slow(cap_mps), time_s, tolerance_s)
        if found is None:
            high_mps = cap_mps
        else:
            low_mps, best = cap_mps, found
    return best
