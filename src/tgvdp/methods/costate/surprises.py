"""Where the front between two extremals may hold a surprise: multipliers to be solved there before runs are sought."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from tgvdp.methods.costate.extremal import Extremal, foretells, tangent_gap

if TYPE_CHECKING:
    from tgvdp.methods.costate.multipliers import ExtremalFront

#: First multiplier, in usual ones, and the factor from one to the next towards the fastest run, whose own is infinite.
FIRST_MULTIPLIER = 4.0
#: Multipliers beyond this multiple of the usual one are infinite.
HIGHEST_MULTIPLIER = 1e12
MOST_EXTREMALS = 250
#: Steps of ln λ towards the fastest run, from the highest multiplier that is finite: how long they are, how many are
#: taken at once, and how far they go at least; to a run that is slower than the fastest one by this share of what the
#: first time is.
_STEP_UP = 0.5
_STEPS_AT_ONCE = 4
_LEAST_RISE = 0.7
_FAR_ENOUGH = 0.5
#: Between two extremals the front lies above their tangents; where these leave more room than this share of energy
#: below the chord, the front may bend in a way that they do not foretell: unless they foretold one between them.
_BEND = 5e-3
#: The same where the running time seems to jump between the two.
_JUMP = 1.5e-3


def surprising(front: "ExtremalFront", target_s: Sequence[float]) -> list[tuple[int, float]]:
    """Multipliers to solve between extremals of a front, by the slower ones of these, in order.

    Parameters
    ----------
    front : ExtremalFront
    target_s : sequence of float
        Increasing running times, s: where there is none nothing matters.
    """
    inner = [bisect_right(target_s, extremal.time_s) for extremal in front.extremals[1:-1]]
    faster = [0, *inner, len(target_s)]  # targets, than each of the extremals
    wanted: list[tuple[int, float]] = []
    for second, (before, after) in enumerate(pairwise(front.extremals), 1):
        pair = before.multiplier, after.multiplier
        if faster[second - 1] == faster[second] or pair in front.settled:
            continue
        pieces = _pieces(front, before, after)
        if pieces <= 1:
            front.settled.add(pair)
            continue
        if math.isinf(before.multiplier):
            wanted += [(second, multiplier) for multiplier in _towards_fastest(front, target_s[0])]
            continue
        multiplier = front.middle(second, (pieces // 2) / pieces)
        # Between two jumps of the running time an extremal holds for many multipliers: each is asked for once.
        if multiplier is not None and multiplier not in front.repeated:
            wanted.append((second, multiplier))
    return wanted[: max(0, MOST_EXTREMALS - len(front.extremals))]


def _pieces(front: "ExtremalFront", before: Extremal, after: Extremal) -> int:
    """Into how many pieces to cut the front between two extremals so that none holds a surprise."""
    if math.isinf(before.multiplier):
        return 1 if after.time_s - before.time_s <= front.tolerance_s else 2
    if after.time_s <= before.time_s:
        return 1  # one run
    if before.multiplier in front.foretold or after.multiplier in front.foretold:
        return 1  # their tangents part a quarter as far as those of the two that foretold
    bend = tangent_gap(before, after) / front.base_j(after.energy_j)
    if bend > _JUMP and not foretells(before, after):
        return 2
    # Tangents part from the chord with the square of the distance between the extremals.
    return math.ceil(math.sqrt(bend / _BEND))


def _towards_fastest(front: "ExtremalFront", first_s: float) -> list[float]:
    """Multipliers between the fastest run and the next extremal, in steps, up to that of a run as fast as a time.

    What runs take longer than the fastest one goes about with a power of λ, which two of them tell, and a few steps on
    two others better.
    """
    fastest, after, *others = front.extremals
    slower = next((one for one in others if one.time_s > after.time_s), None)
    rise = math.log(FIRST_MULTIPLIER)
    if slower is not None:
        longer_s, next_longer_s = after.time_s - fastest.time_s, slower.time_s - fastest.time_s
        power = math.log(next_longer_s / longer_s) / math.log(after.multiplier / slower.multiplier)
        sought_s = max(_FAR_ENOUGH * (first_s - fastest.time_s), front.tolerance_s)
        rise = max(math.log(longer_s / sought_s) / power, _LEAST_RISE)
    count = math.ceil(rise / _STEP_UP)
    most = HIGHEST_MULTIPLIER * front.mesh.usual_multiplier
    steps = range(min(count, _STEPS_AT_ONCE), 0, -1)
    multipliers = [after.multiplier * math.exp(rise * step / count) for step in steps]
    return [multiplier for multiplier in multipliers if multiplier < most]
