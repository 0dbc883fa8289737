"""Runs as tables for people and other tools: every row, or one every so many metres, with limit and gradient."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.line.piecewise import as_table
from tgvdp.line.resolved import resolve
from tgvdp.model.checks import require_number
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, profile_of

Floats = NDArray[np.float64]

#: More rows of one run than this are a slip of the unit.
MOST_SAMPLES = 1_000_000
#: Samples as near to a row as this share of the trip are that row: a sliver between them would have no duration.
_SAME_POSITION = 1e-9


class Samples(NamedTuple):
    """A run in columns of shape (n,), as tables hold it.

    Attributes
    ----------
    position_m, speed_mps, time_s, energy_j : float64
        As in `Profile`.
    limit_mps : float64
        Speed limit of line and train from here on, by the trip's convention; infinite where there is none.
    gradient_permil : float64
        Gradient of the line from here on, ‰, positive uphill.
    force_n : float64
        Mean effort at the wheel up to the next sample, N; the last one repeats.
    regime : int8
        Index into `tgvdp.runs.profile.REGIMES`.
    """

    position_m: Floats
    speed_mps: Floats
    limit_mps: Floats
    gradient_permil: Floats
    time_s: Floats
    force_n: Floats
    energy_j: Floats
    regime: NDArray[np.int8]


def rows_of(trip: Trip, profile: Profile) -> Samples:
    """All rows of a profile, with limit and gradient."""
    x_m = profile.position_m
    return Samples(
        x_m, profile.speed_mps, limit_at(trip, x_m), gradient_at(trip, x_m), profile.time_s, profile.force_n,
        profile.energy_j, profile.regime,
    )  # fmt: skip


def sample_count(trip: Trip, every_m: float) -> int:
    """Number of samples of a run, its two ends included.

    Raises
    ------
    InputError
        When the distance is not positive, or so small that a run would have more than `MOST_SAMPLES`.
    """
    require_number("samples", "every_m", every_m, "m", above=0.0)
    count = int(np.ceil(trip.distance_m / every_m * (1.0 - _SAME_POSITION))) + 1
    if count > MOST_SAMPLES:
        raise InputError(f"samples: every {every_m:g} m makes {count} rows of one run, at most {MOST_SAMPLES} are made")
    return count


def sampled(trip: Trip, profile: Profile, every_m: float) -> Samples:
    """Sample a run at its origin, every ``every_m`` from there, and at its destination.

    v² is linear within a row, so that speed and time are exact; the energy of a part of a row is integrated as that of
    a row, and its sum over the row is that of the profile.
    """
    x, w = profile.position_m - trip.origin_m, profile.speed_mps**2
    at = np.append(every_m * np.arange(sample_count(trip, every_m) - 1), x[-1])
    nearest = _nearest(x, at)
    at = np.where(np.abs(nearest - at) <= _SAME_POSITION * trip.distance_m, nearest, at)
    fine_x = np.union1d(x, at)
    fine = profile_of(trip, fine_x, np.interp(fine_x, x, w))
    row = (np.searchsorted(x, at, side="right") - 1).clip(0, x.size - 2)
    here, start, end = (np.searchsorted(fine_x, position) for position in (at, x[row], x[row + 1]))
    # Parts of a row in which the effort changes its sign may cost more than the row, which counts its mean.
    claimed_j, in_parts_j = (np.diff(profile.energy_j)[row], fine.energy_j[end] - fine.energy_j[start])
    share = (at - x[row]) / (x[row + 1] - x[row])
    energy_j = profile.energy_j[row] + fine.energy_j[here] - fine.energy_j[start] + share * (claimed_j - in_parts_j)
    position_m = trip.origin_m + at
    work_j = np.concatenate(([0.0], np.cumsum(fine.force_n[:-1] * np.diff(fine_x))))[here]
    force_n = np.diff(work_j) / np.diff(at)
    return Samples(
        position_m, fine.speed_mps[here], limit_at(trip, position_m), gradient_at(trip, position_m), fine.time_s[here],
        np.append(force_n, force_n[-1]), energy_j, profile.regime[row],
    )  # fmt: skip


def passing_s(profile: Profile, position_m: float) -> tuple[float, float]:
    """When a run comes to a position and leaves it, s: the same but at a stop. v² is linear within a row.

    Parameters
    ----------
    profile : Profile
    position_m : float
        Between the two ends of the run.
    """
    x = profile.position_m
    at = float(_nearest(x, np.array([position_m]))[0])
    if abs(at - position_m) > _SAME_POSITION * float(x[-1] - x[0]):
        at = position_m
    first, last = int(np.searchsorted(x, at)), int(np.searchsorted(x, at, side="right")) - 1
    if last >= first:
        return float(profile.time_s[first]), float(profile.time_s[last])
    (from_m, to_m), (from_mps, to_mps) = x[last : last + 2], profile.speed_mps[last : last + 2]
    share = (at - from_m) / (to_m - from_m)
    here_mps = np.sqrt(from_mps**2 + share * (to_mps**2 - from_mps**2))
    time_s = float(profile.time_s[last] + 2.0 * (at - from_m) / (from_mps + here_mps))
    return time_s, time_s


def _nearest(x: Floats, at: Floats) -> Floats:
    """Nearest of the increasing values x to each of ``at``."""
    after = np.searchsorted(x, at).clip(1, x.size - 1)
    return np.where(at - x[after - 1] < x[after] - at, x[after - 1], x[after])


def limit_at(trip: Trip, position_m: Floats) -> Floats:
    """Speed limit of line and train from positions on the track on, m/s."""
    line = resolve(trip)
    return np.asarray(line.limit_mps[line.step_at(position_m - trip.origin_m)])


def gradient_at(trip: Trip, position_m: Floats) -> Floats:
    """Gradient of the line from positions on the track on, ‰."""
    rows = as_table(trip.track.gradients or ((0.0, 0.0),))
    return np.asarray(rows[np.searchsorted(rows[:, 0], position_m, side="right") - 1, 1])
