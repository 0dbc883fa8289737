"""Runs of a section with timing points on its way, one for each arrival at the end of the journey."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.section import SectionRuns
from tgvdp.model.journey import TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, profile_of

_Floats = NDArray[np.float64]

#: Speeds that differ by less than this share are one: so well do runs keep to limits.
_SAME = 1e-9


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

    def keeps(self, points: Sequence[TimingPoint], tolerance_s: float) -> bool:
        """Whether all windows are kept, of speeds as well; those of time count from the departure."""
        in_time = all(
            point.earliest_s - tolerance_s <= end_s <= point.latest_s + tolerance_s
            for point, end_s in zip(points, self.ends_s.tolist(), strict=True)
        )
        # At the last point the train stands. A rounding of its position before that it does not.
        passed = points[:-1]
        speed_mps = passing(self.profile, np.array([point.position_m for point in passed]))[1]
        return in_time and all(
            point.lowest_mps * (1.0 - _SAME) <= own_mps <= point.highest_mps * (1.0 + _SAME)
            for point, own_mps in zip(passed, speed_mps.tolist(), strict=True)
        )


def passing(profile: Profile, at_m: _Floats) -> tuple[_Floats, _Floats]:
    """When a run passes positions, s, and how fast, m/s: between two rows squared speeds are linear in position."""
    row = np.clip(np.searchsorted(profile.position_m, at_m, side="right") - 1, 0, len(profile.position_m) - 2)
    speed_mps = np.sqrt(np.interp(at_m, profile.position_m, profile.speed_mps**2))
    way_m = at_m - profile.position_m[row]
    mean_mps = 0.5 * (profile.speed_mps[row] + speed_mps)
    since_s = np.divide(way_m, mean_mps, out=np.zeros(len(at_m)), where=way_m > 0.0)
    return profile.time_s[row] + since_s, speed_mps


def run_in_one_piece(
    profile: Profile, points: Sequence[TimingPoint], multiplier_j_per_s: _Floats, time_s: float, tolerance_s: float
) -> PassedRun:
    """The run of a section that is not parted at its points, the last of which is its end, to a planned time, s."""
    ends_s = passing(profile, np.array([point.position_m for point in points]))[0]
    spare_s = time_s - profile.duration_s
    if spare_s > tolerance_s:
        return PassedRun(profile, ends_s, multiplier_j_per_s, 0.0)
    # Who leaves later passes later.
    left_s = (point.latest_s - end_s for point, end_s in zip(points[:-1], ends_s[:-1].tolist(), strict=True))
    room_s = min(left_s, default=math.inf)
    return PassedRun(profile, ends_s, multiplier_j_per_s, min(spare_s, max(room_s, 0.0)))


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
