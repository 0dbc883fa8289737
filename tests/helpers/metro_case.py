"""A metro train."""

from tgvdp import EffortCurve, Train

TRAIN = Train(
    name="metro", mass_kg=200e3, rotating_mass_factor=1.06, traction=EffortCurve.from_caps(300e3, 2.5e6),
    braking=EffortCurve.from_caps(200e3, 4e6), friction_brake_n=60e3, davis_a_n=4000.0, davis_b_n_per_mps=60.0,
    davis_c_n_per_mps2=9.0, max_acceleration_mps2=1.2, traction_efficiency=0.85, regeneration_efficiency=0.6,
    auxiliary_power_w=400e3,
)  # fmt: skip
