"""Runs of a section with timing points on its way, one for each arrival at the end of the journey."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.section import SectionRuns
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, profile_of

_Floats = NDArray[np.float64]


class PassedRun(NamedTuple):
    """One run of a section that its timing points cut into parts.

    Attributes
    ----------
    profile : Profile
    ends_s : (parts,) float64
        When each part ends after the departure, s.
    multiplier_j_per_s : (parts,) float64
        Multiplier of each part, J/s: what a second more of running in place of waiting saves.
    spare_s : float
        By how much it is faster than planned, s: the train leaves so much later. 0 where it comes earlier on purpose.
    """

    profile: Profile
    ends_s: _Floats
    multiplier_j_per_s: _Floats
    spare_s: float

    def cost_j(self, waiting_w: float) -> float:
        """Energy less what would be drawn in waiting as long, J."""
        return self.profile.total_energy_j - waiting_w * self.profile.duration_s


def run_of_parts(
    trip: Trip, parts: Sequence[SectionRuns], supplement_s: _Floats, multiplier_j_per_s: _Floats
) -> PassedRun:
    """The run of a section whose parts share their speeds: of each part the slowest within its supplement, s."""
    columns: list[tuple[_Floats, _Floats, NDArray[np.int8]]] = []
    own_s = np.empty(len(parts))
    for at, (part, taken_s) in enumerate(zip(parts, supplement_s, strict=True)):
        run = int(part.slowest_within(taken_s))
        x_m, w, regime = part.rows(run)
        x_m = x_m + (part.trip.origin_m - trip.origin_m)
        moves = np.diff(x_m) > 0.0  # rows may have come so near to each other that this rounds them to one place
        kept = np.append(not columns, moves)  # where a part begins the one before it ends
        columns.append((x_m[kept], w[kept], regime[moves]))
        own_s[at] = part.time_s[run]
    profile = profile_of(trip, *map(np.concatenate, zip(*columns, strict=True)))
    # The train waits for what the first part is faster than planned; the others follow as they are.
    spare_s = float(parts[0].fastest.duration_s + supplement_s[0] - own_s[0])
    return PassedRun(profile, np.cumsum(own_s), multiplier_j_per_s, spare_s)


class PassedRuns:
    """Runs of one section, one for each arrival.

    Attributes
    ----------
    trip, fastest
        As of `SectionRuns`.
    runs : sequence of PassedRun
    time_s, energy_j, multiplier_j_per_s : (n,) float64
        Running times, s, energies, J, and multipliers of the last parts, J/s: what a second more of running saves.
    """

    def __init__(self, trip: Trip, fastest: Profile, runs: Sequence[PassedRun], waiting_w: float) -> None:
        self.trip = trip
        self.fastest = fastest
        self.runs = runs
        self.time_s = np.array([run.profile.duration_s for run in runs])
        self.energy_j = np.array([run.profile.total_energy_j for run in runs])
        self.multiplier_j_per_s = np.array([run.multiplier_j_per_s[-1] for run in runs]) - waiting_w

    def profile(self, index: int) -> Profile:
        """Speed profile of one run."""
        return self.runs[index].profile
