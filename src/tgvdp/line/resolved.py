"""The line as one train meets it: resistance, drag, speed limit and current, resolved once for a trip.

Where the resistance varies with the position, searches see it as steps: each has the mean of the resistance over it,
so that work and climb are exact from one break to the next. Inside a step a run that follows the true resistance with
the same effort differs by a known amount of kinetic energy, which `runs.resistance_correction` adds.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.piecewise import Floats, Piecewise, as_table
from tgvdp.line.resistance import curve_permil, gradient_permil, tunnel_drag
from tgvdp.model.convention import Convention
from tgvdp.model.track import LOWERED, NEUTRAL, POWERED, Track
from tgvdp.model.train import Train, TunnelDrag
from tgvdp.model.trip import Trip

#: Breaks nearer to each other than this share of the distance are one: no acceleration can be told on less.
SAME_POSITION = 1e-9
#: Largest change of the resistance within a step, as a share of the starting effort, but no more than so many steps
#: for the whole range of the resistance. The product below matters more: over the length of a short train a change of
#: gradient does next to nothing, however large it is. Running time and energy are right to 2e-5 then
#: (tests/line/test_resistance.py).
_STEP_SHARE = 0.05
_MOST_STEPS = 400
#: Largest product of that change and the step's length, as a share of twice the kinetic energy at top speed: within a
#: step, w may be off by an eighth of that share before `runs.resistance_correction` puts it right.
_WORK_SHARE = 4e-5


class ResolvedLine(NamedTuple):
    """A line for one trip, in K steps; positions are those of the head and count from the trip's origin.

    Attributes
    ----------
    break_m : (K + 1,) float64
        Ends of the steps, from 0 to the trip's distance.
    grade_n : (K,) float64
        Mean force of gradients and curves, N.
    air : (K,) float64
        Mean coefficient of v² in the running resistance, N/(m/s)².
    limit_mps : (K,) float64
        Speed limit of line and train; may be infinite.
    supply : (K,) int8
        POWERED, NEUTRAL or LOWERED.
    force, drag : Piecewise
        What the means are taken of.
    force_nm, drag_nm : (K + 1,) float64
        Integrals of force and drag up to each break.
    even : bool
        Whether resistance and drag are constant within each step.
    inertia_kg : float
    """

    break_m: Floats
    grade_n: Floats
    air: Floats
    limit_mps: Floats
    supply: NDArray[np.int8]
    force: Piecewise
    drag: Piecewise
    force_nm: Floats
    drag_nm: Floats
    even: bool
    inertia_kg: float

    def step_at(self, x_m: Floats) -> NDArray[np.int64]:
        """Step that holds each position, at a break the one that starts there."""
        return np.asarray(np.searchsorted(self.break_m[1:-1], x_m, side="right"))

    def supply_between(self, x_m: Floats) -> NDArray[np.int8]:
        """Current between rows at given positions, (n − 1,)."""
        return np.asarray(self.supply[self.step_at(0.5 * (x_m[:-1] + x_m[1:]))])


class _Asked(NamedTuple):
    """What the steps of a line depend on: trips that differ in something else, as in the wind, share them.

    Attributes
    ----------
    track, origin_m, destination_m, start_speed_mps, convention, credits
        As of the trip.
    train_name, mass_kg, length_m, davis_c_n_per_mps2, tunnel_drag, max_speed_mps, inertia_kg
        As of its train.
    starting_n : float
        Starting effort, N.
    """

    track: Track
    origin_m: float
    destination_m: float
    start_speed_mps: float
    convention: Convention
    credits: tuple[tuple[float, float], ...]
    train_name: str
    mass_kg: float
    length_m: float
    davis_c_n_per_mps2: float
    tunnel_drag: tuple[TunnelDrag, ...]
    max_speed_mps: float
    inertia_kg: float
    starting_n: float

    @property
    def distance_m(self) -> float:
        """Distance from origin to destination, m."""
        return self.destination_m - self.origin_m

    def limit_mps(self, at_m: Floats) -> Floats:
        """Speed limit of line and train at positions from the origin."""
        limits = as_table(self.track.speed_limits)
        return np.minimum(_limit_mps(limits, self.origin_m + at_m, self.reach_m), self.max_speed_mps)

    @property
    def reach_m(self) -> float:
        """How far behind the head the speed limit counts that holds there, m."""
        return self.length_m if self.convention.limits == "tail" else 0.0


@lru_cache(maxsize=16)
def resolve(trip: Trip) -> ResolvedLine:
    """Resolve the line of a trip by its convention.

    Raises
    ------
    InputError
        When a curve is too tight for the formula, or the train's drag in a tunnel is not known.
    """
    train = trip.train
    asked = _Asked(
        trip.track, trip.origin_m, trip.destination_m, trip.start_speed_mps, trip.convention, trip.credits, train.name,
        train.mass_kg, train.length_m, train.davis_c_n_per_mps2, train.tunnel_drag, train.max_speed_mps,
        train.inertia_kg, train.traction_limit.effort_n(0.0),
    )  # fmt: skip
    line = _on_steps(asked)
    if line.even:
        return line
    turns_m = _turns(train, line.force, line.drag, line.break_m, asked.limit_mps)
    break_m = _merged(np.sort(np.concatenate((line.break_m, turns_m))), asked.distance_m)
    return _cut(asked, line.force, line.drag, break_m)


@lru_cache(maxsize=16)
def _on_steps(asked: _Asked) -> ResolvedLine:
    """The line on steps whose ends do not depend on how hard the train rolls."""
    force, drag = _resistance(asked)
    limits = as_table(asked.track.speed_limits)
    top_mps = min(float(limits[:, 1].max()), asked.max_speed_mps)
    rises = np.diff(limits[:, 1]) > 0.0
    changes_m = limits[1:, 0] + np.where(rises, asked.reach_m, 0.0) - asked.origin_m
    from_m, until_m = _stretches(asked)[:, :2].T
    credits_m = np.array([until_m - asked.origin_m for until_m, _ in asked.credits])
    breaks = [*_steps(asked, force, drag, top_mps), changes_m, from_m, until_m, credits_m]
    return _cut(asked, force, drag, _merged(np.sort(np.concatenate(breaks)), asked.distance_m))


def _cut(asked: _Asked, force: Piecewise, drag: Piecewise, break_m: Floats) -> ResolvedLine:
    """The line in the steps between given breaks."""
    even = force.is_even and drag.is_even
    middle_m = 0.5 * (break_m[:-1] + break_m[1:])
    grade_n, air = (
        function.on(function.piece_at(middle_m), middle_m) if even else function.mean(break_m[:-1], break_m[1:])
        for function in (force, drag)
    )
    return ResolvedLine(
        break_m, grade_n, air, asked.limit_mps(middle_m), _supply(_stretches(asked), middle_m), force, drag,
        force.integral_to(break_m), drag.integral_to(break_m), even, asked.inertia_kg,
    )  # fmt: skip


def _stretches(asked: _Asked) -> Floats:
    """Stretches without current: their ends, from the origin, m, and whether the pantograph is lowered, (n, 3)."""
    stretches = np.array(asked.track.neutral_sections, dtype=np.float64).reshape(-1, 3)
    stretches[:, 0] -= asked.origin_m
    stretches[:, 1] += stretches[:, 0]
    return stretches


def _resistance(asked: _Asked) -> tuple[Piecewise, Piecewise]:
    """Force of gradients and curves, N, and coefficient of v², N/(m/s)², over the head's position from the origin."""
    track, convention, ends_m = asked.track, asked.convention, (asked.origin_m, asked.destination_m)
    over_m = asked.length_m if convention.mass_model == "strip" else 0.0
    permil = _section_permil(track, convention.curves, over_m, *ends_m)
    drag = Piecewise.constant(asked.davis_c_n_per_mps2, asked.distance_m)
    if convention.tunnels and track.tunnels:
        own = asked.train_name, asked.davis_c_n_per_mps2, asked.tunnel_drag
        drag = _whole_drag(*own, track, over_m).between(*ends_m)
    return permil.scaled(asked.mass_kg * convention.gravity_mps2 / 1000.0), drag


@lru_cache(maxsize=16)
def _section_permil(track: Track, curves: str, over_m: float, from_m: float, to_m: float) -> Piecewise:
    """Gradients and curves of a section, ‰, averaged over a train's length: many trains may run there."""
    return _whole_permil(track, curves, over_m).between(from_m, to_m)


@lru_cache(maxsize=4)
def _whole_permil(track: Track, curves: str, over_m: float) -> Piecewise:
    """The same over a whole track, which the sections of a journey share."""
    permil = gradient_permil(track)
    if curves != "none":
        permil = permil.plus(curve_permil(track, curves))
    return permil.mean_behind(over_m) if over_m > 0.0 else permil


@lru_cache(maxsize=4)
def _whole_drag(
    train_name: str, davis_c_n_per_mps2: float, more: tuple[TunnelDrag, ...], track: Track, over_m: float
) -> Piecewise:
    """Coefficient of v² over a whole track with tunnels, N/(m/s)², averaged over a train's length."""
    drag = Piecewise.constant(davis_c_n_per_mps2, track.length_m).plus(tunnel_drag(train_name, more, track))
    return drag.mean_behind(over_m) if over_m > 0.0 else drag


def _steps(asked: _Asked, force: Piecewise, drag: Piecewise, top_mps: float) -> list[Floats]:
    """Ends of steps in which the resistance at speeds up to the top speed hardly changes."""
    effort_n, inertia_kg = asked.starting_n, asked.inertia_kg
    top_w = min(top_mps**2, asked.start_speed_mps**2 + 2.0 * effort_n * asked.distance_m / inertia_kg)
    return [
        function.steps(_STEP_SHARE * effort_n * unit, _MOST_STEPS, _WORK_SHARE * inertia_kg * top_w * unit)
        for function, unit in ((force, 1.0), (drag, 1.0 / top_w))
    ]


def _turns(
    train: Train, force: Piecewise, drag: Piecewise, break_m: Floats, limit_of: Callable[[Floats], Floats]
) -> Floats:
    """Positions at which holding the speed limit turns from traction to braking: no mean may hide one by the other."""
    found = [break_m[:0]]
    for limit_mps in np.unique(limit_of(0.5 * (break_m[:-1] + break_m[1:]))).tolist():
        if limit_mps < math.inf:
            rolling_n = Piecewise.constant(train.davis_a_n + train.davis_b_n_per_mps * limit_mps, float(break_m[-1]))
            at_m = force.plus(drag.scaled(limit_mps**2)).plus(rolling_n).roots()
            found.append(at_m[limit_of(at_m) == limit_mps])
    return np.concatenate(found)


def _merged(break_m: Floats, distance_m: float) -> Floats:
    """Breaks in order, within the trip, and its two ends; those that are one in rounding only once."""
    gap_m = SAME_POSITION * distance_m
    inside_m = np.concatenate(([0.0], break_m[(break_m > 0.0) & (break_m < distance_m - gap_m)]))
    return np.append(inside_m[np.diff(inside_m, prepend=-np.inf) > gap_m], distance_m)


def _limit_mps(limits: Floats, at_m: Floats, reach_m: float) -> Floats:
    """Smallest speed limit of the line between each position and ``reach_m`` behind it; before the line its first."""
    last = np.searchsorted(limits[:, 0], at_m, side="right")
    if reach_m == 0.0:
        return np.asarray(limits[last - 1, 1])
    first = np.maximum(np.searchsorted(limits[:, 0], at_m - reach_m, side="right") - 1, 0)
    return np.array([limits[i:j, 1].min() for i, j in zip(first, last, strict=True)])


def _supply(stretches: Floats, at_m: Floats) -> NDArray[np.int8]:
    """Current at each position; rows of a stretch are its ends, and whether the pantograph is lowered."""
    supply = np.full(len(at_m), POWERED, dtype=np.int8)
    for from_m, until_m, lowered in stretches:
        supply[(at_m > from_m) & (at_m < until_m)] = LOWERED if lowered else NEUTRAL
    return supply
