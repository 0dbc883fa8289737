"""How a switching speed changes with ln λ between two extremals, told by those beside them: by a parabola or a corner.

Speeds at which a train switches change smoothly with the multiplier, up to the one from which a limit ahead begins to
bind, or no longer does: there they have a corner. A parabola through four extremals misses that by a fourth of what
the two lines part; the lines themselves meet in it (Harten, ENO schemes with subcell resolution, J. Comput. Phys. 83,
1989, for jumps of a slope).
"""

import math
from typing import NamedTuple

from tgvdp._jit import leaf, part

#: Extremals nearer than this, in distances of the two whose policies are blended, tell no bend.
_APART = 1e-3
#: Two straight lines have a corner where they meet, if they bend so many times as much between two extremals as beside
#: these; or if one of them changes by less than this share of the step between the two.
_CORNER = 3.0
_FLAT = 1e-2
#: What bends so many times as much on one side as on the other has a corner there: the other side tells.
_UNEVEN = 3.0


class Beside(NamedTuple):
    """Extremals before two, and after them, up to two each, and where they lie in ln λ from 0 to 1 of the two.

    Where there is none it is the one that lies nearer to the two, in the same place.
    """

    first: int
    before: int
    before_at: float
    farther_before: int
    farther_before_at: float
    second: int
    after: int
    after_at: float
    farther_after: int
    farther_after_at: float


class Slopes(NamedTuple):
    """Slopes of a switching speed, per distance of two extremals in ln λ, beside these; NaN where it is not known."""

    farther_before: float
    before: float
    after: float
    farther_after: float


@part
def _next(known, first, span, i, at, step):
    """The next extremal of a finite multiplier that is apart from another, in one direction, and where it lies."""
    j = i + step
    while 0 <= j < known.shape[0] and known[j, 2] < math.inf:
        place = math.log(known[j, 2] / known[first, 2]) / span
        if abs(place - at) > _APART:
            return j, place
        j += step
    return i, at


@part
def beside_of(known, first, second):
    """The extremals beside two neighbouring ones; ``known`` has running time, energy and multiplier of each, (E, 3)."""
    if known[first, 2] == math.inf:
        return Beside(first, first, 0.0, first, 0.0, second, second, 1.0, second, 1.0)
    span = math.log(known[second, 2] / known[first, 2])
    before, before_at = _next(known, first, span, first, 0.0, -1)
    farther_before, farther_before_at = _next(known, first, span, before, before_at, -1)
    after, after_at = _next(known, first, span, second, 1.0, 1)
    farther_after, farther_after_at = _next(known, first, span, after, after_at, 1)
    return Beside(
        first, before, before_at, farther_before, farther_before_at, second, after, after_at, farther_after,
        farther_after_at,
    )  # fmt: skip


@leaf
def _slope(policies, k, which, first, first_at, second, second_at):
    """Slope of a switching speed between two extremals; NaN where these are one."""
    if first_at == second_at:
        return math.nan
    return (policies[second, k, which] - policies[first, k, which]) / (second_at - first_at)


@leaf
def slopes_of(policies, beside, k, which, line, top_w):
    """Slopes of a switching speed at station k; not known of one whose ``line`` ends on the envelope, ``top_w``."""
    before = farther_before = math.nan
    if policies[beside.before, k, line] < top_w:
        before = _slope(policies, k, which, beside.before, beside.before_at, beside.first, 0.0)
    if policies[beside.farther_before, k, line] < top_w:
        farther_before = _slope(
            policies, k, which, beside.farther_before, beside.farther_before_at, beside.before, beside.before_at
        )
    after = _slope(policies, k, which, beside.second, 1.0, beside.after, beside.after_at)
    farther_after = _slope(
        policies, k, which, beside.after, beside.after_at, beside.farther_after, beside.farther_after_at
    )
    return Slopes(farther_before, before, after, farther_after)


@leaf
def _bend_of(slope0, slope1, length):
    """Half the second derivative by two slopes, over the way from the start of the one to the end of the other."""
    return math.nan if math.isnan(slope0) or math.isnan(slope1) else (slope1 - slope0) / length


@leaf
def bent(step, beside, slopes):
    """Bend and corner, as of `blend.Blend`, of a switching speed that changes by a step."""
    left = _bend_of(slopes.before, step, 1.0 - beside.before_at)
    right = _bend_of(step, slopes.after, beside.after_at)
    bend = 0.0
    if math.isnan(left) or math.isnan(right):
        if not math.isnan(left):
            bend = left
        elif not math.isnan(right):
            bend = right
        return min(max(bend, -abs(step)), abs(step)), 0.0
    leads = slopes.before * step >= 0.0 and slopes.after * step >= 0.0  # so that the corner is between the two
    if leads and left * right > 0.0 and _is_corner(step, beside, slopes, abs(left) + abs(right)):
        rises = step - slopes.before
        return rises, (slopes.after - step) / (rises + slopes.after - step)
    bend = 0.5 * (left + right)
    if max(abs(left), abs(right)) > _UNEVEN * min(abs(left), abs(right)):
        bend = left if abs(left) < abs(right) else right
    return min(max(bend, -abs(step)), abs(step)), 0.0


@leaf
def _is_corner(step, beside, slopes, inner):
    """Whether a switching speed that bends by ``inner`` around a step has a corner there."""
    if min(abs(slopes.before), abs(slopes.after)) <= _FLAT * abs(step):
        return True
    left = _bend_of(slopes.farther_before, slopes.before, -beside.farther_before_at)
    right = _bend_of(slopes.after, slopes.farther_after, beside.farther_after_at - 1.0)
    if math.isnan(left):
        return inner > _CORNER * abs(right)  # never where nothing is known
    return inner > _CORNER * (abs(left) if math.isnan(right) else abs(left) + abs(right))


@leaf
def with_line(place, first, second, step, slope, bend, corner):
    """Bend and corner of the start of a line whose end has a corner at a place; as given if that says nothing.

    Up to there a line may fall as a run that coasts, which its policies ``first`` and ``second`` tell, and more than
    that from there on; its start has a ``slope`` before.
    """
    is_between = slope * step >= 0.0 and abs(slope) * place <= abs(step)
    if is_between and 0.0 < first[1] - first[0] < _FLAT * (second[1] - second[0]):
        return step - slope, place
    return bend, corner
