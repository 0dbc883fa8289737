"""The line as the referee sees it: looked up in the track itself, and summed up in a way of its own.

Nothing is shared with `physics.resolved`. Resistance and drag are added up along the track in small parts, and a train
of some length meets the difference of two sums over its length.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.model.track import Curve
from tgvdp.model.trip import Trip
from tgvdp.physics.resolved import LOWERED, NEUTRAL, POWERED

_Floats = NDArray[np.float64]

#: Parts of each curve in which its radius changes, and the longest one, m.
_PARTS = 256
_LONGEST_M = 20.0
#: Radius at which Röckl's formula jumps.
_JUMP_M = 300.0
#: Where both sides of a break are looked at, as a share of the distance between breaks.
_BESIDE = 1e-3
#: Jumps of the gradient below this share of the starting effort, or of the steepest gradient, are rounding.
_SAME_FORCE = 1e-6


class SeenLine(NamedTuple):
    """Sums along the track, (n,) float64 each.

    Attributes
    ----------
    at_m : (n,)
        Positions on the track, increasing.
    force_nm, drag : (n,)
        Sums up to there of the force of gradients and curves, and of the coefficient of v².
    length_m : float
        Length over which the train meets their mean; 0 where it meets them at its head.
    """

    at_m: _Floats
    force_nm: _Floats
    drag: _Floats
    length_m: float


@leaf
def _part(at, x):
    lo = 0
    hi = at.shape[0] - 1
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if at[middle] <= x:
            lo = middle
        else:
            hi = middle
    return lo


@kernel
def met(line, x):
    """Force of gradients and curves in N, and coefficient of v², that the train meets with its head at x."""
    at = line.at_m
    i = _part(at, x)
    span = at[i + 1] - at[i]
    force = (line.force_nm[i + 1] - line.force_nm[i]) / span
    drag = (line.drag[i + 1] - line.drag[i]) / span
    if line.length_m == 0.0:
        return force, drag
    tail = x - line.length_m
    j = _part(at, tail)
    span = at[j + 1] - at[j]
    back_force = line.force_nm[j] + (tail - at[j]) * ((line.force_nm[j + 1] - line.force_nm[j]) / span)
    back_drag = line.drag[j] + (tail - at[j]) * ((line.drag[j + 1] - line.drag[j]) / span)
    head_force = line.force_nm[i] + (x - at[i]) * force
    head_drag = line.drag[i] + (x - at[i]) * drag
    return (head_force - back_force) / line.length_m, (head_drag - back_drag) / line.length_m


def _curve_permil(formula: str, row: Curve, share: float) -> float:
    """Resistance at a share of the way through a curve, ‰."""
    bend = abs((1.0 - share) / row.radius_start_m + share / row.radius_end_m)
    if formula == "none" or bend == 0.0:
        return 0.0
    radius_m = 1.0 / bend
    if formula == "800/R":
        return 800.0 / radius_m
    return 650.0 / (radius_m - 55.0) if radius_m >= _JUMP_M else 500.0 / (radius_m - 30.0)


def see_line(trip: Trip) -> SeenLine:
    """Add up the track of a trip."""
    track, train, convention = trip.track, trip.train, trip.convention
    ends_m = {0.0, track.length_m}
    ends_m |= {row.position_m for row in track.gradients} | {row.position_m for row in track.curves}
    for tunnel in track.tunnels:
        ends_m |= {tunnel.position_m, min(tunnel.position_m + tunnel.length_m, track.length_m)}
    curves = track.curves if convention.curves != "none" else ()
    curve_end_m = [*(row.position_m for row in curves[1:]), track.length_m]
    for row, end_m in zip(curves, curve_end_m, strict=False):
        if row.radius_start_m != row.radius_end_m:
            parts = max(_PARTS, math.ceil((end_m - row.position_m) / _LONGEST_M))
            ends_m |= set(np.linspace(row.position_m, end_m, parts + 1).tolist())
            bend, turn = 1.0 / row.radius_start_m, 1.0 / row.radius_end_m - 1.0 / row.radius_start_m
            shares = ((side / _JUMP_M - bend) / turn for side in (-1.0, 0.0, 1.0))
            ends_m |= {row.position_m + share * (end_m - row.position_m) for share in shares if 0.0 < share < 1.0}
    length_m = train.length_m if convention.mass_model == "strip" else 0.0
    # What the track begins with was there before it.
    at_m = np.array(sorted(ends_m | {-length_m}))
    middle_m = np.maximum(0.5 * (at_m[:-1] + at_m[1:]), _BESIDE * _BESIDE * at_m[at_m > 0.0].min())
    permil = np.zeros_like(middle_m)
    for position_m, gradient_permil in track.gradients:
        permil[middle_m > position_m] = gradient_permil
    for row, end_m in zip(curves, curve_end_m, strict=False):
        for i in np.flatnonzero((middle_m > row.position_m) & (middle_m < end_m)):
            share = (middle_m[i] - row.position_m) / (end_m - row.position_m)
            permil[i] += _curve_permil(convention.curves, row, float(share))
    air = np.full_like(middle_m, train.davis_c_n_per_mps2)
    for tunnel in track.tunnels if convention.tunnels else ():
        inside = (middle_m > tunnel.position_m) & (middle_m < tunnel.position_m + tunnel.length_m)
        air[inside] += next(
            row.davis_c_n_per_mps2 for row in train.tunnel_drag if row.cross_section_m2 == tunnel.cross_section_m2
        )
    force_n = train.mass_kg * permil / 1000.0 * convention.gravity_mps2
    sums = [np.concatenate(([0.0], np.cumsum(np.diff(at_m) * value))) for value in (force_n, air)]
    return SeenLine(at_m, sums[0], sums[1], length_m)


def limits_seen(trip: Trip, at_m: _Floats) -> _Floats:
    """Speed limit at positions of the head, m/s: a limit holds until the tail has left it, or the head (convention)."""
    track = trip.track
    behind_m = trip.train.length_m if trip.convention.limits == "tail" else 0.0
    limit_mps = np.full(len(at_m), trip.train.max_speed_mps)
    ends_m = [*(row.position_m for row in track.speed_limits[1:]), math.inf]
    for row, end_m in zip(track.speed_limits, ends_m, strict=True):
        held = (at_m >= row.position_m) & (at_m < end_m + behind_m)
        limit_mps[held] = np.minimum(limit_mps[held], row.speed_mps)
    return limit_mps


def supply_seen(trip: Trip, at_m: _Floats) -> NDArray[np.int8]:
    """Current at positions of the head, (n,): POWERED, NEUTRAL or LOWERED."""
    supply = np.full(len(at_m), POWERED, dtype=np.int8)
    for position_m, length_m, lowered in trip.track.neutral_sections:
        supply[(at_m >= position_m) & (at_m < position_m + length_m)] = LOWERED if lowered else NEUTRAL
    return supply


def breaks_seen(trip: Trip) -> _Floats:
    """Positions within the trip at which its limit or its current changes, or the gradient met at the head, m."""
    track, convention = trip.track, trip.convention
    found = {row.position_m for row in track.speed_limits}
    if convention.limits == "tail":
        found |= {position_m + trip.train.length_m for position_m in found}
    for position_m, length_m, _ in track.neutral_sections:
        found |= {position_m, position_m + length_m}
    at_m = np.array(sorted(x for x in found if trip.origin_m < x < trip.destination_m))
    gaps_m = _BESIDE * np.diff(np.concatenate(([trip.origin_m], at_m, [trip.destination_m])))
    before_m, after_m = at_m - gaps_m[:-1], at_m + gaps_m[1:]
    changes = limits_seen(trip, before_m) != limits_seen(trip, after_m)
    changes |= supply_seen(trip, before_m) != supply_seen(trip, after_m)
    if convention.mass_model == "strip" and trip.train.length_m > 0.0:
        return at_m[changes]
    weight_n = trip.train.mass_kg * convention.gravity_mps2 / 1000.0
    least_permil = _SAME_FORCE * trip.train.traction_limit.effort_n(0.0) / weight_n
    least_permil = max([least_permil, *(_SAME_FORCE * abs(row.gradient_permil) for row in track.gradients)])
    jumps_m = [
        row.position_m
        for before, row in pairwise(track.gradients)
        if abs(before.gradient_permil - row.gradient_permil) > least_permil
        and trip.origin_m < row.position_m < trip.destination_m
    ]
    return np.union1d(at_m[changes], jumps_m)
