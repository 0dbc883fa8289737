"""The linear margin: every stretch takes the same ratio of its fastest time, as all speeds are divided by it.

Where the margin changes on the way, the train is at the border as fast as the side with less margin has it; it brakes
or accelerates on the other side, whose ratio is so much larger that its time is met.
"""

from tgvdp.margins.curve import Curve, blended
from tgvdp.margins.parts import Part, met
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import BRAKING, TRACTION
from tgvdp.runs.profile import Profile, profile_of

#: A ratio that differs from 1 by less differs by rounding.
_SAME = 1e-12
#: Ratios up to this multiple of the part's own are tried.
_MOST = 16.0


def scaled_run(trip: Trip, fastest: Profile, ratio: float) -> Profile:
    """The fastest run with all speeds divided by a ratio."""
    if ratio <= 1.0 + _SAME:
        return fastest
    return profile_of(trip, fastest.position_m - trip.origin_m, (fastest.speed_mps / ratio) ** 2)


def linear_run(part: Part) -> Curve:
    """Run of a part by the linear margin.

    Raises
    ------
    InfeasibleError
        When the part is too short for what lies between its speeds and those of its neighbours.
    """
    if part.ratio <= 1.0 + _SAME:
        return part.base
    own = part.base.scaled(part.ratio)
    if not any(joints_of(part, float(own.w[0]), float(own.w[-1]))):
        return own
    # Ratios rise, and both ends fall. The scaled run is one under the true resistance already.
    joints = [part.driven(joint) for joint in joints_of(part, 0.0, 0.0) if joint is not None]

    def run(ratio: float) -> Curve:
        curve = part.base.scaled(ratio)
        for joint in joints:
            curve = curve.upper(joint)
        return curve

    return met(part, run, part.ratio, _MOST * part.ratio, blended)


def joints_of(part: Part, start_w: float, end_w: float) -> tuple[Curve | None, Curve | None]:
    """What leads down from the speed at the begin of a part, and up to that at its end; None where it is not above."""
    begin, end, driver = part.trip.start_speed_mps**2, part.trip.end_speed_mps**2, part.driver
    down = driver.forwards(BRAKING, 0.0, begin, part.base) if begin > start_w * (1.0 + _SAME) else None
    up = (
        driver.backwards(TRACTION, part.trip.distance_m, end, 0.0, part.base)[0]
        if end > end_w * (1.0 + _SAME)
        else None
    )
    return down, up
