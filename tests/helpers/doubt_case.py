"""A train on hills, and fronts of extremals on one of its meshes."""

import numpy as np

from tests.helpers.fronts import counters
from tgvdp import EffortCurve, Track, Train
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.multipliers import ExtremalFront

TRAIN = Train(
    mass_kg=450e3, traction=EffortCurve.from_caps(300e3, 6e6), friction_brake_n=400e3, davis_a_n=4000.0,
    davis_b_n_per_mps=100.0, davis_c_n_per_mps2=8.0,
)  # fmt: skip


def hills(seed):
    """Forty gradients of 1 km between −20 and 12 ‰, at each of which the best speed is another."""
    permil = np.random.default_rng(seed).uniform(-20.0, 12.0, 40)
    gradients = tuple((1e3 * km, float(value)) for km, value in enumerate(permil))
    return Track(length_m=40e3, speed_limits=((0.0, 75.0),), gradients=gradients)


def targets(fastest_s):
    return fastest_s * np.linspace(1.02, 1.25, 12)


def front_on(mesh, fastest_s):
    front = ExtremalFront(mesh, 1.0, 0.0, counters(), SearchBudget().start())
    front.reach(1.25 * fastest_s)
    front.foresee(targets(fastest_s))
    return front
