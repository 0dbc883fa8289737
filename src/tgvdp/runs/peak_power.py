"""The largest power of a run at the wheel: what a contract for power and the size of a substation ask for."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # who reports a power has its profile, and need not load the kernels
    from tgvdp.model.train import Train
    from tgvdp.runs.profile import Profile


def peak_power_w(profile: "Profile", train: "Train") -> float:
    """Largest traction power at the wheel, W.

    A row's effort is a mean, and its power is largest at its faster end, where it is no more than the train has: a
    row at full power has that at both ends.
    """
    speed_mps = np.maximum(profile.speed_mps[:-1], profile.speed_mps[1:])
    power_w = profile.force_n[:-1] * speed_mps
    # Few rows can be the largest: the limit is asked for these only.
    peak_w = 0.0
    for row in np.argsort(-power_w):
        if power_w[row] <= peak_w:
            break
        speed = float(speed_mps[row])
        peak_w = max(peak_w, min(float(power_w[row]), train.traction_limit.effort_n(speed) * speed))
    return peak_w
