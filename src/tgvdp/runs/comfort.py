"""What passengers feel: accelerations and jerk of a run."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:  # who reports a ride has its profile, and need not load the kernels
    from tgvdp.runs.profile import Profile

#: Jerk is told over a second, as ride comfort is measured: efforts are switched at once in the model.
_WINDOW_S = 1.0


class Ride(NamedTuple):
    """Largest values of a run.

    Attributes
    ----------
    acceleration_mps2, deceleration_mps2 : float
        Largest acceleration and deceleration, both at least 0, m/s².
    jerk_mps3 : float
        Largest change of the acceleration within one second, m/s³; departures from and arrivals at a stop count.
    """

    acceleration_mps2: float
    deceleration_mps2: float
    jerk_mps3: float


def ride_of(profile: "Profile") -> Ride:
    """Accelerations and jerk of a run; between rows the acceleration is constant."""
    time_s = profile.time_s
    lasts_s = np.diff(time_s)
    # The time of a row may be lost in that of a run that takes 10¹⁶ times as long: nobody feels it.
    rows = np.divide(np.diff(profile.speed_mps), lasts_s, out=np.zeros_like(lasts_s), where=lasts_s > 0.0)
    before, after = (
        0.0 if speed_mps == 0.0 else float(row)
        for speed_mps, row in ((profile.speed_mps[0], rows[0]), (profile.speed_mps[-1], rows[-1]))
    )
    values = np.concatenate(([before], rows, [after]))
    # Within a window the difference of a function of steps is largest just after one of them.
    ends_s = np.concatenate((time_s, time_s + _WINDOW_S))
    late = values[np.searchsorted(time_s, ends_s, side="right")]
    early = values[np.searchsorted(time_s, ends_s - _WINDOW_S, side="left")]
    jerk_mps3 = float(np.max(np.abs(late - early))) / _WINDOW_S
    return Ride(max(0.0, float(rows.max())), max(0.0, -float(rows.min())), jerk_mps3)
