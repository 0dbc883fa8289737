"""Ends of a record of times and positions alone, whose speeds are means of intervals.

The mean of the first interval is no speed at its beginning: after a stand it is half of what is reached at its end.
Speeds at ends are those of a parabola through the rows next to them; and who stands there departs where a parabola
from a standstill does, which may be between two rows.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Slower than this is a stand, m/s.
STAND_MPS = 0.3
#: How many standard deviations a speed may be wrong by.
_SURE = 3.0
#: No train gains speed faster than this from a stand, m/s².
_QUICKEST_MPS2 = 1.5
#: Later departures than the record's first row are told from changes of the acceleration by this share of an interval.
_LATER = 0.2


class EndSpeed(NamedTuple):
    """Speed at an end of a record, and how uncertain it is by the noise of positions and by changes of acceleration."""

    speed_mps: float
    doubt_mps: float

    def may_be_stand(self, time_s: Floats, position_m: Floats) -> bool:
        """Whether it is not told from a standstill, from which the train can have come to the third row, too."""
        since_s, along_m = time_s[:3][-1] - time_s[0], position_m[:3][-1] - position_m[0]
        return self.speed_mps <= max(STAND_MPS, self.doubt_mps) and 2.0 * along_m <= _QUICKEST_MPS2 * since_s**2


def end_speed(time_s: Floats, position_m: Floats, reach_s: float) -> EndSpeed:
    """Speed at the first row, by the rows within a reach of it, s, or by as few as tell it.

    Of the last row it is told by rows in reverse order, with both signs changed.
    """
    since_s = time_s - time_s[0]
    within = int(np.searchsorted(since_s, reach_s, side="right"))
    parabola, cubic = (
        _fitted(since_s[:rows], position_m[:rows], min(order, rows - 1))
        for order, rows in ((order, min(max(within, order + 1), since_s.size)) for order in (2, 3))
    )
    changes_mps = abs(cubic.speed_mps - parabola.speed_mps)
    return EndSpeed(max(parabola.speed_mps, 0.0), max(changes_mps, parabola.doubt_mps))


def _fitted(time_s: Floats, position_m: Floats, order: int) -> EndSpeed:
    """Speed at time 0 by a polynomial, and how uncertain it is by noise, as far as rows tell that."""
    powers = np.vander(time_s, order + 1, increasing=True)
    inverse = np.linalg.pinv(powers)
    found = inverse @ position_m
    spare = max(time_s.size - order - 1, 1)
    noise_m = np.linalg.norm(position_m - powers @ found) / np.sqrt(spare)
    return EndSpeed(float(found[1]), float(_SURE * noise_m * np.linalg.norm(inverse[1])))


def departure_by_speed_s(time_s: Floats, speed_mps: Floats) -> float:
    """When a train leaves that stands at the first row and moves at the next ones, which may be between two rows.

    It leaves as if it gained speed up to the second row as it does after it, where this is clearly later than the
    first row: a record every 5 s is up to 10 s longer than its run.
    """
    if time_s.size < 3 or not 0.0 < speed_mps[1] < speed_mps[2]:
        return float(time_s[0])
    left_s = float(time_s[1] - speed_mps[1] * (time_s[2] - time_s[1]) / (speed_mps[2] - speed_mps[1]))
    return _clearly_later(left_s, float(time_s[0]), float(time_s[1]))


def departure_s(time_s: Floats, position_m: Floats) -> float:
    """When a train leaves that is at rest at the first row, which may be between two rows, or after some of them.

    It leaves as if it gained speed evenly over the rows after that, where this is clearly later than the first row.
    """
    first = int((np.diff(position_m) >= STAND_MPS * np.diff(time_s)).argmax())
    gone_m = position_m[first + 1 : first + 3] - position_m[0]
    if gone_m.size < 2 or not 0.0 < gone_m[0] < gone_m[1]:
        return float(time_s[0])
    (near, far), (near_s, far_s) = np.sqrt(gone_m), time_s[first + 1 : first + 3]
    left_s = float(near_s - (far_s - near_s) * near / (far - near))
    return _clearly_later(left_s, float(time_s[0]), float(near_s))


def _clearly_later(left_s: float, first_s: float, next_s: float) -> float:
    """A departure, or the first row's time where it is not told from that."""
    return left_s if left_s - first_s > _LATER * (next_s - first_s) else first_s
