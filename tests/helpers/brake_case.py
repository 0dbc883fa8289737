"""A metro train whose dynamic brake cuts out, or drops, at a speed."""

from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train

CUTS_OUT = ((0.0, 0.0), (2.2, 0.0), (2.2, 150e3), (14.0, 150e3), (22.0, 95e3))
DROPS = ((0.0, 150e3), (15.4, 150e3), (15.4, 40e3), (23.0, 30e3))
LIMITS = (SpeedLimit(0.0, 22.0), SpeedLimit(1200.0, 14.0))
LEVEL = Track(length_m=3000.0, speed_limits=LIMITS)
HILLY = Track(
    length_m=3000.0, speed_limits=LIMITS, gradients=(Gradient(0.0, 0.0), Gradient(800.0, -8.0), Gradient(2000.0, 4.0))
)


def metro(points):
    return Train(
        mass_kg=205e3, rotating_mass_factor=1.08, traction=EffortCurve.from_caps(230e3, 2.2e6),
        braking=EffortCurve.from_points(points), friction_brake_n=173e3, davis_a_n=3000.0, davis_b_n_per_mps=60.0,
        davis_c_n_per_mps2=6.0, max_speed_mps=22.0, traction_efficiency=0.87, regeneration_efficiency=0.85,
    )  # fmt: skip
