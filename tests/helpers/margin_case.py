"""A plain train on a hilly section, for margins."""

from tests.helpers.twins.economy import Twin
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train

TRAIN = Train(
    name="plain", mass_kg=300e3, rotating_mass_factor=1.05,
    traction=EffortCurve.from_points([(0.0, 250e3), (60.0, 60e3)]),
    braking_rates=((0.0, 0.6),), davis_a_n=3000.0, davis_b_n_per_mps=60.0, davis_c_n_per_mps2=6.0, max_speed_mps=45.0,
)  # fmt: skip
HILLS = Track(
    name="hills",
    length_m=20_000.0,
    stops_m=(0.0, 20_000.0),
    speed_limits=(SpeedLimit(0.0, 40.0), SpeedLimit(9000.0, 28.0), SpeedLimit(12_000.0, 40.0)),
    gradients=(
        Gradient(0.0, 0.0),
        Gradient(4000.0, -14.0),
        Gradient(6000.0, 2.0),
        Gradient(14_000.0, -11.0),
        Gradient(15_500.0, 0.0),
    ),
)


def twin():
    """The same by `Twin`."""

    def grade_permil(x_m):
        return next(row.gradient_permil for row in reversed(HILLS.gradients) if row.position_m <= x_m)

    def limit_mps(x_m):
        return next(row.speed_mps for row in reversed(HILLS.speed_limits) if row.position_m <= x_m)

    return Twin(
        HILLS.length_m, TRAIN.mass_kg, TRAIN.inertia_kg, (3000.0, 60.0, 6.0),
        lambda v: 250e3 + (60e3 - 250e3) * v / 60.0, 0.6, grade_permil, limit_mps,
    )  # fmt: skip
