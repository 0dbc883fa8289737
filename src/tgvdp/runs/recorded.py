"""A recorded run as a run of the model: its sections between stands, its speeds averaged, its rows on a line.

Efforts are not recorded. They follow from the train's model: m·a + R(v) + G on each row, negative where the train
brakes. Noise of the speed becomes noise of the effort, and only its positive part is paid for: that is why speeds can
be averaged over a window.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.line.resolved import resolve
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import COASTING, HOLDING
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.recorded_ends import STAND_MPS, departure_by_speed_s, departure_s, end_speed
from tgvdp.runs.recorded_means import Motion, averaged, with_slopes

Floats = NDArray[np.float64]

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
        has_speeds = speed_mps is not None
        rows = slice(start, end + 1)
        part = Motion(x[rows], v[rows].copy(), t[rows], window_s, has_speeds)
        # At its first and last row a record without speeds tells them by extrapolation only.
        known = (has_speeds or start > 0, has_speeds or end < t.size - 1)
        stands = (bool(standing[start]) and known[0], bool(standing[end]) and known[1])
        if part.position_m[-1] - part.position_m[0] >= _LEAST_SECTION_M:
            if has_speeds and time_s is not None:  # else times follow from speeds: it leaves at a row
                part = _between_stands(part, stands, position_m is None)
            found.append(_standing(averaged(part), stands) if has_speeds else _with_ends(part, stands))
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
    if t.size < 2:
        raise InputError("recorded run: all rows have the same time")
    if position_m is None:
        assert speed_mps is not None
        v = speed_mps[keep]
        return t, np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t)))), v
    x = position_m[keep]
    return t, x, _mean_speeds(t, x) if speed_mps is None else speed_mps[keep]


def _mean_speeds(t: Floats, x: Floats) -> Floats:
    """Speeds by parabolas through three rows each, at the ends as well: a mean would tell no standstill there."""
    return np.maximum(np.gradient(x, t, edge_order=2 if t.size > 2 else 1), 0.0)


def _standing(motion: Motion, stands: tuple[bool, bool]) -> Motion:
    """Speeds of 0 at the ends at which it stands."""
    for row, is_stand in zip((0, -1), stands, strict=True):
        if is_stand:
            motion.speed_mps[row] = 0.0
    return motion


def _between_stands(motion: Motion, stands: tuple[bool, bool], is_integrated: bool) -> Motion:
    """A section of recorded speeds without the time that it stands between two rows, at either end."""
    if stands[0]:
        motion = _left_at(motion, is_integrated)
    return _backward(_left_at(_backward(motion), is_integrated)) if stands[1] else motion


def _left_at(motion: Motion, is_integrated: bool) -> Motion:
    """The same from when it leaves its first row, which is where it stood, or where positions are integrals before it.

    There the way up to the second row is shorter, too.
    """
    x, v, t = (column.copy() for column in motion[:3])
    t[0] = departure_by_speed_s(t, v)
    if is_integrated:
        x[0] = x[1] - 0.5 * (v[0] + v[1]) * (t[1] - t[0])
    return motion._replace(position_m=x, time_s=t)


def _with_ends(motion: Motion, stands: tuple[bool, bool]) -> Motion:
    """A section without recorded speeds, whose ends are told by the rows next to them."""
    ahead = _with_start(motion, stands[0])
    return averaged(_backward(_with_start(_backward(ahead), stands[1])))


def _with_start(motion: Motion, stands: bool) -> Motion:
    """Tell the speed at the start, where one that is not told from a standstill is one; standing there is left out.

    Parameters
    ----------
    motion : Motion
    stands : bool
        Whether that it stands at its start is known.
    """
    x, v, t = motion[:3]
    stands |= bool(x[1] - x[0] < STAND_MPS * (t[1] - t[0]))
    told = end_speed(t, x, 0.5 * motion.window_s)
    doubt_mps = motion.doubt_mps if stands else max(motion.doubt_mps, told.doubt_mps)
    if not (stands or told.may_be_stand(t, x)):
        return motion._replace(speed_mps=np.append(told.speed_mps, v[1:]), doubt_mps=doubt_mps)
    left_s = departure_s(t, x)
    moves = t > left_s
    x, v, t = np.append(x[0], x[moves]), np.append(0.0, v[moves]), np.append(left_s, t[moves])
    return motion._replace(position_m=x, speed_mps=v, time_s=t, doubt_mps=doubt_mps)


def _backward(motion: Motion) -> Motion:
    """The same motion from its end to its start."""
    x, v, t = motion[:3]
    return motion._replace(position_m=-x[::-1], speed_mps=v[::-1], time_s=-t[::-1])


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

    Between two rows the effort is even, as far as what slopes do goes. One that is not told from none by the noise of
    the record is coasting.
    """
    line = resolve(trip)
    motion = with_slopes(motion, line, trip.origin_m)
    x = motion.position_m - trip.origin_m
    keep = np.concatenate(([True], np.diff(x) > _SAME_M))
    keep[-1] = True
    # The last row stands for those that it is the same as.
    keep[:-1] &= (x[-1] - x[:-1] > _SAME_M) | (np.arange(x.size - 1) == 0)
    x, w = x[keep], motion.speed_mps[keep] ** 2
    breaks = line.break_m
    near = np.abs(breaks - x[np.abs(breaks[:, None] - x).argmin(axis=1)]) <= _SAME_M
    rows = np.union1d(x, breaks[~near])
    climbed_w = 2.0 / line.inertia_kg * np.interp(rows, breaks, line.force_nm)
    w = np.interp(rows, x, w + np.interp(x, rows, climbed_w)) - climbed_w
    # A row of standstill within the section would take forever.
    w[1:-1] = np.maximum(w[1:-1], STAND_MPS**2)
    profile = profile_of(trip, rows, w)
    force_n, regime = profile.force_n[:-1], profile.regime[:-1]
    is_noise = (np.abs(force_n) <= _TOLD_FROM_NOISE * _noise_n(force_n)) & (regime != HOLDING)
    return profile_of(trip, rows, w, np.where(is_noise, COASTING, -1).astype(np.int8))


def _noise_n(force_n: Floats) -> float:
    """Standard deviation of the noise in efforts, N: by the median of their changes, few of which are the driver's."""
    if len(force_n) < 2:
        return 0.0
    return _NORMAL_MAD * float(np.median(np.abs(np.diff(force_n)))) / math.sqrt(2.0)
