"""The line as the referee sees it: looked up in the track itself, and summed up in a way of its own.

Nothing is shared with `line.resolved`. Resistance and drag are added up along the track in small parts, and a train
of some length meets the difference of two sums over its length.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.model.track import LOWERED, NEUTRAL, POWERED, Curve
from tgvdp.model.trip import Trip

_Floats = NDArray[np.float64]

#: Parts of each curve in which its radius changes, and the longest one, m.
_PARTS = 256
_LONGEST_M = 20.0
#: Radius at which Röckl's formula jumps, and what it may lack of that by rounding along a curve of that radius.
_JUMP_M = 300.0
_ROUNDING = 1e-9
#: Where both sides of a break are looked at, as a share of the distance between breaks.
_BESIDE = 1e-3
#: Jumps of the gradient below this share of the starting effort, or of the steepest gradient, are rounding.
_SAME_FORCE = 1e-6


class SeenLine(NamedTuple):
    """The track in n parts, and sums along it; float64.

    Attributes
    ----------
    at_m : (n + 1,)
        Ends of the parts on the track, increasing.
    force_n, slope : (n,)
        Force of gradients and curves at the start of each part, and its change per metre, N/m.
    air : (n,)
        Coefficient of v² in each part.
    force_nm, drag : (n + 1,)
        Sums up to each end of the force, and of the coefficient of v².
    length_m : float
        Length over which the train meets their mean; 0 where it meets them at its head.
    """

    at_m: _Floats
    force_n: _Floats
    slope: _Floats
    air: _Floats
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


@leaf
def _ahead(at, i, x):
    while i + 2 < at.shape[0] and at[i + 1] <= x:
        i += 1
    return i


@kernel
def parts_at(line, x):
    """Parts of the track in which the head is at x and the tail behind it, from which `met` looks ahead."""
    return _part(line.at_m, x), _part(line.at_m, x - line.length_m)


@leaf
def met(line, parts, x):
    """Force of gradients and curves in N, and coefficient of v², that the train meets with its head at x.

    ``parts`` are those at a position that is not after x.
    """
    i = _ahead(line.at_m, parts[0], x)
    past = x - line.at_m[i]
    if line.length_m == 0.0:
        return line.force_n[i] + past * line.slope[i], line.air[i]
    tail = x - line.length_m
    j = _ahead(line.at_m, parts[1], tail)
    behind = tail - line.at_m[j]
    head_force = line.force_nm[i] + past * (line.force_n[i] + 0.5 * past * line.slope[i])
    back_force = line.force_nm[j] + behind * (line.force_n[j] + 0.5 * behind * line.slope[j])
    drag = line.drag[i] + past * line.air[i] - line.drag[j] - behind * line.air[j]
    return (head_force - back_force) / line.length_m, drag / line.length_m


def _held(at_m: _Floats, rows: Sequence[Any], end_m: Sequence[float]) -> Iterator[tuple[Any, slice]]:
    """Rows, and where among increasing positions each of them holds, its end left out.

    A line may have 100,000 of both.
    """
    places = np.searchsorted(at_m, np.column_stack(([row.position_m for row in rows], end_m)))
    return zip(rows, (slice(*place) for place in places.tolist()), strict=True)


def _until_next_m(rows: Sequence[Any], last_m: float) -> list[float]:
    """Ends of rows that hold until the next one."""
    return [*(row.position_m for row in rows[1:]), last_m][: len(rows)]


def _curve_permil(formula: str, curves: Sequence[Curve], end_m: Sequence[float], at_m: _Floats) -> _Floats:
    """Resistance at positions from the first curve on, ‰."""
    from_m, start_m, last_m = np.array(curves, dtype=np.float64).T
    row = np.searchsorted(from_m, at_m, side="right") - 1
    share = (at_m - from_m[row]) / (np.array(end_m) - from_m)[row]
    bend = np.abs((1.0 - share) / start_m[row] + share / last_m[row])
    radius_m = np.divide(1.0, bend, out=np.full_like(bend, math.inf), where=bend > 0.0)
    if formula == "800/R":
        return 800.0 / radius_m
    wide = radius_m >= _JUMP_M * (1.0 - _ROUNDING)
    return np.where(wide, 650.0 / (np.where(wide, radius_m, math.inf) - 55.0), 500.0 / (radius_m - 30.0))


@lru_cache(maxsize=16)
def see_line(trip: Trip) -> SeenLine:
    """Add up the track of a trip."""
    track, train, convention = trip.track, trip.train, trip.convention
    at_turns_m: list[_Floats] = []
    ends_m = {0.0, track.length_m}
    ends_m |= {row.position_m for row in track.gradients} | {row.position_m for row in track.curves}
    for tunnel in track.tunnels:
        ends_m |= {tunnel.position_m, min(tunnel.position_m + tunnel.length_m, track.length_m)}
    curves = track.curves if convention.curves != "none" else ()
    curve_end_m = _until_next_m(curves, track.length_m)
    for row, end_m in zip(curves, curve_end_m, strict=True):
        if row.radius_start_m != row.radius_end_m:
            # 800/R is linear where the curvature is.
            parts = 1 if convention.curves == "800/R" else max(_PARTS, math.ceil((end_m - row.position_m) / _LONGEST_M))
            at_turns_m.append(np.linspace(row.position_m, end_m, parts + 1))
            bend, turn = 1.0 / row.radius_start_m, 1.0 / row.radius_end_m - 1.0 / row.radius_start_m
            shares = ((side / _JUMP_M - bend) / turn for side in (-1.0, 0.0, 1.0))
            ends_m |= {row.position_m + share * (end_m - row.position_m) for share in shares if 0.0 < share < 1.0}
    length_m = train.length_m if convention.mass_model == "strip" else 0.0
    # What the track begins with was there before it.
    at_m = np.unique(np.concatenate((list(ends_m | {-length_m}), *at_turns_m)))
    middle_m = np.maximum(0.5 * (at_m[:-1] + at_m[1:]), _BESIDE * _BESIDE * at_m[at_m > 0.0].min())
    span_m = np.diff(at_m)
    permil, permil_per_m = np.zeros_like(middle_m), np.zeros_like(middle_m)
    for row, held in _held(middle_m, track.gradients, _until_next_m(track.gradients, math.inf)):
        permil[held] = row.gradient_permil
    if curves:
        bent = slice(int(np.searchsorted(middle_m, curves[0].position_m)), None)
        beside_m = np.where(at_m[:-1] >= 0.0, 0.25 * span_m, 0.0)[bent]
        first, last = (
            _curve_permil(convention.curves, curves, curve_end_m, middle_m[bent] + aside_m)
            for aside_m in (-beside_m, beside_m)
        )
        permil[bent] += 0.5 * (first + last)
        permil_per_m[bent] = 2.0 * (last - first) / span_m[bent]
    air = np.full_like(middle_m, train.davis_c_n_per_mps2)
    tunnels = track.tunnels if convention.tunnels else ()
    for tunnel, held in _held(middle_m, tunnels, [row.position_m + row.length_m for row in tunnels]):
        air[held] += next(
            row.davis_c_n_per_mps2 for row in train.tunnel_drag if row.cross_section_m2 == tunnel.cross_section_m2
        )
    mean_n, slope = (train.mass_kg * value / 1000.0 * convention.gravity_mps2 for value in (permil, permil_per_m))
    force_nm, drag = (np.concatenate(([0.0], np.cumsum(span_m * value))) for value in (mean_n, air))
    return SeenLine(at_m, mean_n - 0.5 * span_m * slope, slope, air, force_nm, drag, length_m)


def limits_seen(trip: Trip, at_m: _Floats) -> _Floats:
    """Speed limit at increasing positions of the head, m/s.

    A limit holds until the tail has left it, or the head, by the trip's convention.
    """
    limits = trip.track.speed_limits
    behind_m = trip.train.length_m if trip.convention.limits == "tail" else 0.0
    limit_mps = np.full(len(at_m), trip.train.max_speed_mps)
    for row, held in _held(at_m, limits, [end_m + behind_m for end_m in _until_next_m(limits, math.inf)]):
        limit_mps[held] = np.minimum(limit_mps[held], row.speed_mps)
    return limit_mps


def supply_seen(trip: Trip, at_m: _Floats) -> NDArray[np.int8]:
    """Current at increasing positions of the head, (n,): POWERED, NEUTRAL or LOWERED."""
    supply = np.full(len(at_m), POWERED, dtype=np.int8)
    sections = trip.track.neutral_sections
    for section, held in _held(at_m, sections, [row.position_m + row.length_m for row in sections]):
        supply[held] = LOWERED if section.lowered_pantograph else NEUTRAL
    return supply


@lru_cache(maxsize=16)
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
