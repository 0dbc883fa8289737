"""Lines that are drawn at random, each named by its seed."""

import numpy as np

from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.units import kmh_to_mps, mps_to_kmh

#: Limits and gradients change after as many metres, evenly drawn.
_LIMIT_M, _GRADIENT_M = (500.0, 8e3), (200.0, 3e3)
_LEAST_KMH, _STEEPEST_PERMIL = 50.0, 12.0


def random_track(seed: int, top_mps: float, length_m: tuple[float, float]) -> Track:
    """A line that trains of the catalog can run on.

    Parameters
    ----------
    seed : int
    top_mps : float
        Limits are drawn from 50 km/h up to this, m/s.
    length_m : (float, float)
        Shortest and longest; drawn by its logarithm.
    """
    random = np.random.default_rng(seed)
    drawn_m = float(np.exp(random.uniform(*np.log(length_m))))
    limit_at, gradient_at = (_breaks_m(random, drawn_m, steps_m) for steps_m in (_LIMIT_M, _GRADIENT_M))
    limits_kmh = 10.0 * np.round(random.uniform(_LEAST_KMH, mps_to_kmh(top_mps), len(limit_at)) / 10.0)
    permil = np.round(random.uniform(-_STEEPEST_PERMIL, _STEEPEST_PERMIL, len(gradient_at)), 1)
    return Track(
        length_m=drawn_m,
        speed_limits=tuple(
            SpeedLimit(at, kmh_to_mps(kmh)) for at, kmh in zip(limit_at, limits_kmh.tolist(), strict=True)
        ),
        gradients=tuple(Gradient(at, value) for at, value in zip(gradient_at, permil.tolist(), strict=True)),
        name=f"random line {seed}",
    )


def _breaks_m(random: np.random.Generator, length_m: float, steps_m: tuple[float, float]) -> list[float]:
    """Positions from 0 on, drawn steps apart."""
    steps = random.uniform(*steps_m, int(length_m / steps_m[0]) + 1)
    at_m = np.concatenate(([0.0], np.cumsum(np.round(steps))))
    return [float(at) for at in at_m[at_m < length_m]]
