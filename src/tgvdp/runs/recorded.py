"""A recorded run as a run of the model: its sections between stands, its speeds averaged, its rows on a line.

Efforts are not recorded. They follow from the train's model: m·a + R(v) + G on each row, negative where the train
brakes. Noise of the speed becomes noise of the effort, and only its positive part is paid for: that is why speeds can
be averaged over a window.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.line.resolved import resolve
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import COASTING, HOLDING
from tgvdp.runs.profile import Profile, profile_of

Floats = NDArray[np.float64]

#: Slower than this is a stand, m/s.
STAND_MPS = 0.3
#: Shorter moves are no section but an adjustment, or a receiver that wanders, m.
_LEAST_SECTION_M = 20.0
#: Positions may go back by this much, the error of a receiver, m.
_BACKWARD_M = 20.0
#: Window of the mean speed where only times and positions are recorded, s.
DEFAULT_WINDOW_S = 10.0
#: Rows as near as this are one, m.
_SAME_M = 1e-6
#: Standard deviation of normal noise, per median of its absolute values; and how many of them tell a value from noise.
_NORMAL_MAD, _TOLD_FROM_NOISE = 1.4826, 3.0


class Motion(NamedTuple):
    """Position, m, speed, m/s, and time, s, of a section from stand to stand, (n,) float64 each."""

    position_m: Floats
    speed_mps: Floats
    time_s: Floats


def sections_of(
    position_m: Floats | None, speed_mps: Floats | None, time_s: Floats | None, window_s: float | None = None
) -> list[Motion]:
    """Sections of a record between its stands.

    Parameters
    ----------
    position_m, speed_mps, time_s : (n,) float64, optional
        At least two of them.
    window_s : float, optional
        Speeds are means over so many seconds; by default as recorded, or over 10 s where no speed is.

    Raises
    ------
    InputError
        When time or position goes back, a speed is negative, or the train never moves.
    """
    t, x, v = _completed(position_m, speed_mps, time_s)
    window_s = (DEFAULT_WINDOW_S if speed_mps is None else 0.0) if window_s is None else window_s
    standing = v < STAND_MPS
    found = []
    edges = np.flatnonzero(np.diff(np.concatenate(([True], standing, [True])).astype(np.int8)))
    for first, last in edges.reshape(-1, 2):
        # It departs and arrives where the stands before and after are slowest next to it.
        start, end = max(first - 1, 0), min(last, t.size - 1)
        while start > 0 and v[start - 1] < v[start]:
            start -= 1
        while end < t.size - 1 and v[end + 1] < v[end]:
            end += 1
        part = Motion(x[start : end + 1], v[start : end + 1].copy(), t[start : end + 1])
        if part.position_m[-1] - part.position_m[0] >= _LEAST_SECTION_M:
            smoothed = _averaged(part, window_s)
            for row, edge in ((0, start), (-1, end)):
                if standing[edge]:
                    smoothed.speed_mps[row] = 0.0
            found.append(smoothed)
    if not found:
        raise InputError(f"recorded run: the train never moves {_LEAST_SECTION_M:g} m faster than {STAND_MPS:g} m/s")
    return found


def _completed(
    position_m: Floats | None, speed_mps: Floats | None, time_s: Floats | None
) -> tuple[Floats, Floats, Floats]:
    """Time, position and speed, the missing one from the other two at constant acceleration between the rows."""
    if speed_mps is not None and float(speed_mps.min()) < 0.0:
        raise InputError(f"recorded run: speed must not be negative, got {float(speed_mps.min()):.6g} m/s")
    if time_s is not None and float(np.diff(time_s).min()) < 0.0:
        raise InputError(f"recorded run: time goes back after {float(time_s[np.diff(time_s).argmin()]):.6g} s")
    if position_m is not None:
        furthest = np.maximum.accumulate(position_m)
        if float((furthest - position_m).max()) > _BACKWARD_M:
            where_m = float(furthest[(furthest - position_m).argmax()])
            raise InputError(f"recorded run: position goes back after {where_m:.6g} m; runs go up the line's positions")
        position_m = furthest
    if time_s is None:
        assert position_m is not None and speed_mps is not None
        step_m, total = np.diff(position_m), speed_mps[:-1] + speed_mps[1:]
        if ((step_m > 0.0) & (total == 0.0)).any():
            raise InputError("recorded run: the speed is 0 at both ends of a stretch, and no time is recorded")
        steps_s = np.divide(2.0 * step_m, total, out=np.zeros_like(step_m), where=total > 0.0)
        return np.concatenate(([0.0], np.cumsum(steps_s))), position_m, speed_mps
    keep = np.concatenate(([True], np.diff(time_s) > 0.0))
    t = time_s[keep]
    if position_m is None:
        assert speed_mps is not None
        v = speed_mps[keep]
        return t, np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t)))), v
    x = position_m[keep]
    return t, x, np.gradient(x, t) if speed_mps is None else speed_mps[keep]


def _averaged(motion: Motion, window_s: float) -> Motion:
    """Mean speeds over a window, narrower next to the ends so that it is centred there too."""
    x, v, t = motion
    if window_s <= 0.0:
        return motion
    half = np.minimum(0.5 * window_s, np.minimum(t - t[0], t[-1] - t))
    wide = half > 0.0
    ahead, behind = np.interp(t + half, t, x), np.interp(t - half, t, x)
    return Motion(x, np.where(wide, np.divide(ahead - behind, 2.0 * half, out=v.copy(), where=wide), v), t)


def placed(motion: Motion, start_m: float | None, end_m: float | None) -> Motion:
    """Shift a section to start at a position of the line, and stretch it to end at one.

    Raises
    ------
    InputError
        When it would end before it starts.
    """
    x = motion.position_m
    if start_m is not None:
        x = x - x[0] + start_m
    if end_m is not None:
        if not end_m > x[0]:
            raise InputError(f"recorded run: must end after its start, got {end_m:.6g} m after {float(x[0]):.6g} m")
        x = x[0] + (x - x[0]) * (end_m - x[0]) / (x[-1] - x[0])
    return motion._replace(position_m=x)


def recorded_profile(trip: Trip, motion: Motion) -> Profile:
    """Run of the model with the speeds of a record: efforts and energy by the trip's train, line and energy model.

    An effort that is not told from none by the noise of the record is coasting.
    """
    x = motion.position_m - trip.origin_m
    keep = np.concatenate(([True], np.diff(x) > _SAME_M))
    keep[-1] = True
    # The last row stands for those that it is the same as.
    keep[:-1] &= (x[-1] - x[:-1] > _SAME_M) | (np.arange(x.size - 1) == 0)
    x, w = x[keep], motion.speed_mps[keep] ** 2
    # A row of standstill within the section would take forever.
    w[1:-1] = np.maximum(w[1:-1], STAND_MPS**2)
    breaks = resolve(trip).break_m
    near = np.abs(breaks - x[np.abs(breaks[:, None] - x).argmin(axis=1)]) <= _SAME_M
    rows = np.union1d(x, breaks[~near])
    w = np.interp(rows, x, w)
    profile = profile_of(trip, rows, w)
    force_n, regime = profile.force_n[:-1], profile.regime[:-1]
    is_noise = (np.abs(force_n) <= _TOLD_FROM_NOISE * _noise_n(force_n)) & (regime != HOLDING)
    return profile_of(trip, rows, w, np.where(is_noise, COASTING, -1).astype(np.int8))


def _noise_n(force_n: Floats) -> float:
    """Standard deviation of the noise in efforts, N: by the median of their changes, few of which are the driver's."""
    if len(force_n) < 2:
        return 0.0
    return _NORMAL_MAD * float(np.median(np.abs(np.diff(force_n)))) / math.sqrt(2.0)
