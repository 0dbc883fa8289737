"""The documented example of OSRD's running time."""

from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train

#: Flat line, 850 t, effort falling linearly, γ = 0.5 m/s².
OSRD_TRAIN = Train(
    name="documented",
    mass_kg=850e3,
    rotating_mass_factor=1.05,
    length_m=400.0,
    davis_a_n=5525.0,
    davis_b_n_per_mps=244.8,
    davis_c_n_per_mps2=13.2192,
    traction=EffortCurve.from_points([(0.0, 450e3), (83.33, 180e3)]),
    braking_rates=((0.0, 0.5),),
    max_speed_mps=44.4,
)
OSRD_TRACK = Track(length_m=10_000.0, speed_limits=((0.0, 44.4),))
