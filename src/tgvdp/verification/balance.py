"""Conservation of energy along a run: traction = resistance + potential + braking + kinetic.

Each term is summed up from the columns of a profile and the track alone. Along a row v² is linear in position, so v is
linear in time, and the work of the resistance is ∫ R(v)·v dt of a cubic, which Simpson's rule has exactly.
"""

import numpy as np

from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile


def balance_error(trip: Trip, profile: Profile) -> float:
    """What is missing in the balance of a run, as a share of all energy that its terms move.

    Parameters
    ----------
    trip : Trip
        Its convention must take the line at the train's head, without curves and tunnels.
    profile : Profile

    Returns
    -------
    float
        Largest over all rows, of the sums up to them.
    """
    train = trip.train
    step_m, speed_mps = np.diff(profile.position_m), profile.speed_mps
    work_j = profile.force_n[:-1] * step_m
    height_m = np.diff(_height_m(trip, profile.position_m))
    potential_j = train.mass_kg * trip.convention.gravity_mps2 * height_m
    kinetic_j = 0.5 * train.inertia_kg * np.diff(speed_mps**2)
    before, after = speed_mps[:-1], speed_mps[1:]
    second_s = 2.0 * step_m / (before + after)
    middle = 0.5 * (before + after)
    power_w = [_resistance_n(trip, v) * v for v in (before, middle, after)]
    resistance_j = second_s / 6.0 * (power_w[0] + 4.0 * power_w[1] + power_w[2])
    missing_j = np.cumsum(work_j - resistance_j - potential_j - kinetic_j)
    moved_j = sum(float(np.abs(term).sum()) for term in (work_j, resistance_j, potential_j, kinetic_j))
    return float(np.abs(missing_j).max() / moved_j)


def _resistance_n(trip: Trip, speed_mps: np.ndarray) -> np.ndarray:
    train = trip.train
    return train.davis_a_n + speed_mps * (train.davis_b_n_per_mps + speed_mps * train.davis_c_n_per_mps2)


def _height_m(trip: Trip, at_m: np.ndarray) -> np.ndarray:
    """Height above the start of the line, m."""
    rows = trip.track.gradients or ((0.0, 0.0),)
    start_m, permil = np.array(rows, dtype=np.float64).T
    reached_m = np.clip(at_m[:, None] - start_m, 0.0, np.append(np.diff(start_m), np.inf))
    return np.asarray(reached_m @ permil / 1000.0)
