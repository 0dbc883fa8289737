"""Adhesion: how much of the effort the driven wheels can put on the rail.

The coefficient of dry rail falls with speed V in km/h as µ = 7.5/(V + 44) + 0.161 (Curtius and Kniffler, Elektrische
Bahnen 1944, p. 25); a constant coefficient stands for other rail, or for what an operator counts on.
"""

from typing import NamedTuple

import numpy as np

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.units import kmh_to_mps

#: Cubic pieces of the curve, ever longer, up to the speed from which it is held: 3e-5 of it off at most.
_PIECES = 16
_LAST_KMH = 500.0
_POLE_KMH = 44.0


class Adhesion(NamedTuple):
    """Mass on the driven axles, and the coefficient there; None means that of Curtius and Kniffler for dry rail."""

    adhesive_mass_kg: float
    coefficient: float | None = None

    def limit(self) -> EffortCurve:
        """Largest effort that the driven wheels put on the rail."""
        weight_n = self.adhesive_mass_kg * GRAVITY_MPS2
        if self.coefficient is not None:
            return EffortCurve.from_caps(weight_n * self.coefficient)
        growth = (_LAST_KMH / _POLE_KMH + 1.0) ** (np.arange(_PIECES + 1) / _PIECES)
        speed_mps = kmh_to_mps(1.0) * _POLE_KMH * (growth - 1.0)
        falling = weight_n * 7.5 / (_POLE_KMH * growth)
        slope = -falling / (kmh_to_mps(1.0) * _POLE_KMH * growth)
        pieces = []
        for k in range(_PIECES):  # cubic by value and slope at both ends
            a, b = speed_mps[k], speed_mps[k + 1]
            chord = (falling[k + 1] - falling[k]) / (b - a)
            bend = (3.0 * chord - 2.0 * slope[k] - slope[k + 1]) / (b - a)
            twist = (slope[k] + slope[k + 1] - 2.0 * chord) / (b - a) ** 2
            cubic = np.poly1d([twist, bend, slope[k], falling[k] + 0.161 * weight_n])(np.poly1d([1.0, -a]))
            pieces.append(EffortPiece(float(a), 0.0, *(float(value) for value in cubic.coeffs[::-1])))
        pieces.append(EffortPiece(float(speed_mps[-1]), c0_n=float(falling[-1] + 0.161 * weight_n)))
        return EffortCurve(tuple(pieces))
