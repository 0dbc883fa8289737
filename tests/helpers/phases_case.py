"""Trips on which each cell asks for another speed, of all kinds, and the phases of their runs."""

import numpy as np

import tgvdp
from tests.helpers.trips import commuter

#: Points of a front.
POINTS = 12


def rolling(seed=0, **features):
    """A line on which each cell of the mesh asks for another speed: short ramps and limits."""
    rng = np.random.default_rng(seed)
    at_m = np.arange(0.0, 20e3, 400.0)
    gradients = tuple(zip(at_m.tolist(), rng.uniform(-14.0, 12.0, len(at_m)).tolist(), strict=True))
    limits = ((0.0, 25.0), (5e3, 33.0), (9e3, 22.0), (13e3, 36.0))
    return tgvdp.Track(length_m=20e3, speed_limits=limits, gradients=gradients, **features)


REGENERATES = {"traction_efficiency": 0.87, "regeneration_efficiency": 0.8, "auxiliary_power_w": 5e4}
DROPS = tgvdp.EffortCurve.from_points([(0.0, 2.4e5), (15.0, 2.4e5), (15.0, 1.8e5), (20.0, 1.7e5), (44.0, 7e4)])
CASES = {
    "wheel": (commuter(), rolling(), {}),
    "pantograph": (commuter(**REGENERATES), rolling(), {"energy": "pantograph"}),
    "drops of effort": (commuter(traction=DROPS), rolling(1), {}),
    "tunnels": (commuter(tunnel_drag=((50.0, 6.0),)), rolling(2, tunnels=((4e3, 3e3, 50.0),)), {}),
    "neutral sections": (
        commuter(**REGENERATES),
        rolling(3, neutral_sections=((7e3, 300.0, False), (15e3, 200.0, True))),
        {"energy": "pantograph"},
    ),
    "braking rates": (commuter(braking_rates=((0.0, 0.8), (15.0, 0.6))), rolling(4), {}),
    "strips": (commuter(length_m=200.0), rolling(8), {"mass_model": "strip", "limits": "tail"}),
    "ends at speed": (commuter(), rolling(6), {"start_speed_mps": 20.0, "end_speed_mps": 15.0}),
}


def phases_s(profile):
    """Durations of the phases of one regime."""
    starts = np.concatenate(([0], np.flatnonzero(np.diff(profile.regime[:-1])) + 1, [len(profile.regime) - 1]))
    return np.diff(profile.time_s[starts])


def surveyed(seed):
    """A line with a gradient of its own every 10 m, as surveys have it, and limits in small steps."""
    rng = np.random.default_rng(seed)
    at_m = np.arange(0.0, 8e3, 10.0)
    gradients = tuple(zip(at_m.tolist(), (4.0 * rng.standard_normal(len(at_m))).tolist(), strict=True))
    limits_m = np.arange(0.0, 8e3, 400.0).tolist()
    limits = tuple(zip(limits_m, rng.choice([16.0, 18.0, 20.0, 22.0], len(limits_m)).tolist(), strict=True))
    return tgvdp.Track(length_m=8e3, speed_limits=limits, gradients=gradients)
