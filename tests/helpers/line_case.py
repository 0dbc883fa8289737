"""A train and a line with curves, tunnels and gradients."""

import math

from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train

TRAIN = Train(
    mass_kg=2e5,
    traction=EffortCurve.from_caps(1.8e5, 2.5e6),
    braking=EffortCurve.from_caps(1.2e5, 2e6),
    friction_brake_n=5e4,
    rotating_mass_factor=1.06,
    length_m=150.0,
    davis_a_n=2e3,
    davis_b_n_per_mps=40.0,
    davis_c_n_per_mps2=7.0,
    tunnel_drag=((30.0, 6.0),),
    traction_efficiency=0.85,
    regeneration_efficiency=0.7,
    auxiliary_power_w=1e5,
)


TRACK = Track(
    length_m=6000.0,
    speed_limits=((0.0, 32.0), (2500.0, 20.0), (3100.0, 30.0)),
    gradients=((0.0, 0.0), (1000.0, 12.0), (2200.0, -15.0), (4000.0, 3.0)),
    curves=((0.0, math.inf, math.inf), (600.0, math.inf, 400.0), (800.0, 400.0, 400.0), (1500.0, math.inf, math.inf)),
    tunnels=((1800.0, 900.0, 30.0),),
)
