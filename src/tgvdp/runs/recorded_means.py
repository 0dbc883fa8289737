"""Speeds of a record as means over some seconds, from which slopes are kept out.

A mean rounds what changes within its window. Where slopes begin is known exactly, and so is their force: were their
effect on the speed rounded, efforts would have to make up for it, first driving, then braking or the reverse. Means are
taken of the motion on a level line, which differs by what climbs have taken.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import ResolvedLine

Floats = NDArray[np.float64]


class Motion(NamedTuple):
    """A section from stand to stand.

    Attributes
    ----------
    position_m, speed_mps, time_s : (n,) float64
        Position, m, speed, m/s, and time, s.
    window_s : float
        Speeds are means over so many seconds.
    has_speeds : bool
        Whether speeds were recorded; else they are means between positions as well.
    doubt_mps : float
        How uncertain the speed at an end is that was not recorded, m/s.
    """

    position_m: Floats
    speed_mps: Floats
    time_s: Floats
    window_s: float = 0.0
    has_speeds: bool = True
    doubt_mps: float = 0.0

    def blurred_s(self) -> Floats:
        """How far from each row, s, lies what its speed is a mean of."""
        steps_s = np.diff(self.time_s, prepend=self.time_s[0], append=self.time_s[-1])
        between_s = np.zeros(len(self.time_s)) if self.has_speeds else np.maximum(steps_s[1:], steps_s[:-1])
        return np.maximum(0.5 * self.window_s, between_s)


def averaged(motion: Motion) -> Motion:
    """Mean speeds over its window, narrower next to the ends so that it is centred there too."""
    if motion.window_s <= 0.0:
        return motion
    x, v, t = motion[:3]
    half = np.minimum(0.5 * motion.window_s, np.minimum(t - t[0], t[-1] - t))
    wide = half > 0.0
    ahead, behind = np.interp(t + half, t, x), np.interp(t - half, t, x)
    return motion._replace(speed_mps=np.divide(ahead - behind, 2.0 * half, out=v.copy(), where=wide))


def with_slopes(motion: Motion, line: ResolvedLine, origin_m: float) -> Motion:
    """Speeds as slopes change them, between the ends of a section whose means have rounded that."""
    if motion.has_speeds and motion.window_s <= 0.0:
        return motion
    x, t = motion.position_m - origin_m, motion.time_s
    knots_s = np.unique(np.concatenate((t, np.interp(line.break_m[1:-1], x, t))))
    knots_m, step_s = np.interp(knots_s, t, x), np.diff(knots_s)
    work_nm, step_m = np.diff(np.interp(knots_m, line.break_m, line.force_nm)), np.diff(knots_m)
    force_n = np.divide(work_nm, step_m, out=np.zeros_like(work_nm), where=step_m > 0.0)
    taken_mps = np.concatenate(([0.0], np.cumsum(force_n * step_s))) / line.inertia_kg
    taken_m = np.concatenate(([0.0], np.cumsum(0.5 * (taken_mps[1:] + taken_mps[:-1]) * step_s)))
    exact_mps, exact_m = np.interp(t, knots_s, taken_mps), np.interp(t, knots_s, taken_m)
    between_mps = exact_mps if motion.has_speeds else np.gradient(exact_m, t)
    rounded_mps = averaged(motion._replace(position_m=exact_m, speed_mps=between_mps)).speed_mps
    speed_mps = np.maximum(motion.speed_mps + rounded_mps - exact_mps, 0.0)
    speed_mps[[0, -1]] = motion.speed_mps[[0, -1]]
    return motion._replace(speed_mps=speed_mps)
