"""Accelerate, coast without friction, brake: the three-phase formulation, in closed form.

With accelerations a and a', running time T and distance D, the cruising speed V solves c·V² − T·V + D = 0, c = (1/a +
1/a')/2; the smaller root is the run, because the other would brake before it has stopped accelerating. Two corrections:
the braking phase is V − (t − t2)·a' (t1 is printed in one place), and the energy is m·V²/(2η): a motor of efficiency η
needs more, not less, so η divides.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.model.checks import require_number

_OWNER = "three-phase run"


@dataclass(frozen=True)
class ThreePhaseRun:
    """A run in three phases.

    Attributes
    ----------
    acceleration_mps2, deceleration_mps2 : float
        a and a', both positive.
    running_time_s : float
        T.
    cruising_speed_mps : float
        V.
    """

    acceleration_mps2: float
    deceleration_mps2: float
    running_time_s: float
    cruising_speed_mps: float

    @property
    def end_of_traction_s(self) -> float:
        """Switching time t1 = V/a, s."""
        return self.cruising_speed_mps / self.acceleration_mps2

    @property
    def start_of_braking_s(self) -> float:
        """Switching time t2 = T − V/a', s."""
        return self.running_time_s - self.cruising_speed_mps / self.deceleration_mps2

    @property
    def distance_m(self) -> float:
        """Area below v(t), m."""
        return 0.5 * self.cruising_speed_mps * (self.running_time_s + self.start_of_braking_s - self.end_of_traction_s)

    def speed_mps(self, time_s: ArrayLike) -> NDArray[np.float64]:
        """v(t): (...) s → (...) m/s; 0 before the start and after the end."""
        t = np.asarray(time_s, dtype=np.float64)
        rising = self.acceleration_mps2 * t
        falling = self.deceleration_mps2 * (self.running_time_s - t)
        return np.maximum(0.0, np.minimum(np.minimum(rising, falling), self.cruising_speed_mps))

    def energy_j(self, mass_kg: float = 1.0, efficiency: float = 1.0) -> float:
        """Energy m·V²/(2η) that traction draws, J; per kg of train by default."""
        require_number(_OWNER, "mass_kg", mass_kg, "kg", above=0.0)
        require_number(_OWNER, "efficiency", efficiency, "1", above=0.0)
        return mass_kg * self.cruising_speed_mps**2 / (2.0 * efficiency)


def three_phase_run(
    distance_m: float,
    running_time_s: float,
    acceleration_mps2: float,
    deceleration_mps2: float,
    max_speed_mps: float = math.inf,
) -> ThreePhaseRun:
    """Find the run that covers a distance in a given time.

    Raises
    ------
    InputError
        When a number is not positive and finite (the largest speed may be infinite).
    InfeasibleError
        When the time is too short for the accelerations (T² < 4·c·D) or for the largest speed.
    """
    for name, value, unit in (
        ("distance_m", distance_m, "m"),
        ("running_time_s", running_time_s, "s"),
        ("acceleration_mps2", acceleration_mps2, "m/s^2"),
        ("deceleration_mps2", deceleration_mps2, "m/s^2"),
    ):
        require_number(_OWNER, name, value, unit, above=0.0)
    require_number(_OWNER, "max_speed_mps", max_speed_mps, "m/s", above=0.0, infinite_ok=True)
    c = 0.5 * (1.0 / acceleration_mps2 + 1.0 / deceleration_mps2)
    root = running_time_s**2 - 4.0 * c * distance_m
    if root < 0.0:
        least_s = 2.0 * math.sqrt(c * distance_m)
        raise InfeasibleError(f"{_OWNER}: {distance_m:g} m take at least {least_s:.6g} s, got {running_time_s:g} s")
    # (T − √(T² − 4cD))/(2c), written so that nothing cancels where T is ample.
    speed = 2.0 * distance_m / (running_time_s + math.sqrt(root))
    if speed > max_speed_mps:
        raise InfeasibleError(f"{_OWNER}: needs {speed:.6g} m/s, above the largest speed {max_speed_mps:g} m/s")
    return ThreePhaseRun(acceleration_mps2, deceleration_mps2, running_time_s, speed)
