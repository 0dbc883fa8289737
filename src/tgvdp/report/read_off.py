"""Energies between two points of a front: off a straight line, and how far above the front that can be."""

from bisect import bisect_left
from typing import Any, NamedTuple

import numpy as np

from tgvdp.report.tables import saved_pct
from tgvdp.units import SECONDS_PER_MINUTE

#: Figures that may lie further above their front than this are said to, %.
TELLING_PCT = 0.1
#: A front may end a hundredth of a second before the margin that was asked for.
_END_SHARE = 1e-3


class Read(NamedTuple):
    """An energy read off a front, kWh, and how far above the front it can be, %."""

    energy_kwh: float
    at_most_above_pct: float


class Front(NamedTuple):
    """Running times, s, energies, kWh, and prices, kWh/min (NaN where unknown), the fastest run first, (n,)."""

    time_s: Any
    energy_kwh: Any
    price_kwh_per_min: Any

    def at(self, at_s: float) -> Read | None:
        """Energy at a running time, s; None where the front does not reach."""
        time_s, energy_kwh = self.time_s, self.energy_kwh
        if not time_s[0] <= at_s <= time_s[-1] * (1.0 + _END_SHARE):
            return None
        energy = float(np.interp(at_s, time_s, energy_kwh))
        after = bisect_left(time_s, at_s)
        if after in (0, len(time_s)) or time_s[after] == at_s:
            return Read(energy, 0.0)
        # No run of a convex front is below the tangents at its points, nor dearer than a faster one.
        minutes = (np.array([at_s, at_s]) - time_s[after - 1 : after + 1]) / SECONDS_PER_MINUTE
        tangents = energy_kwh[after - 1 : after + 1] - self.price_kwh_per_min[after - 1 : after + 1] * minutes
        least = max(float(np.nanmax(tangents, initial=-np.inf)), float(energy_kwh[after]))
        return Read(energy, max(saved_pct(least, energy), 0.0))
