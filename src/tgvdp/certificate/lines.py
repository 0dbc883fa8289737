"""Lines under a front: for which multipliers, and from which runs, they are worth the time.

Every line holds for all runs, whatever multiplier and run it comes from (`certificate.line`); these only decide how
close it comes. A line is best at the running time of the optimal run of its multiplier. A first one is made for each
multiplier of the front; where they leave a gap that better ones might close, more are made with more care.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.line import BoundingProblem
from tgvdp.errors import TgvdpError
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

_Floats = NDArray[np.float64]

#: Energy below this share of the kinetic energy at the top speed is a rounding error of none.
NO_ENERGY = 1e-9
#: The extremals of a certificate are solved on a mesh this much finer than the front's.
_FINENESS = 4.0
#: Multipliers of a front's certificate at most, before refinement.
_MOST_LINES = 64
#: Further ones, relative to the largest: next to the fastest run a line is good only near its own point.
_LARGER = (1.15, 1.35, 1.8)
#: Between multipliers further apart than this factor another one is solved: a line may be poor where T(λ) jumps.
_APART = 1.1
#: Refined lines: mesh of their extremals against the front's, cells of their costates against the usual ones.
_REFINED_MESH, _REFINED_CELLS = 16.0, 4.0
#: Cells of all extremals of refined lines at most: the work that they may be.
_MOST_CELLS = 160_000
#: A gap that needs no refinement, and a promise that is not worth it: relative to the energy, and to the gap.
_ENOUGH, _PROMISE, _PROMISED_SHARE = 5e-4, 2e-4, 0.1
#: Lines whose costates are improved by ascent at most, and the least gain of a pass relative to the energy.
_MOST_ASCENTS, _ASCENT_GAIN = 8, 1e-5
#: Refined lines for one point at most, and ascents in vain.
_TRIES = 2
#: Multipliers for the fastest run itself grow by this factor until they do not help; from there on more precise lines
#: grow by a smaller one. The losses of a line grow with its multiplier, so that it needs this many times more cells.
_STEEPER, _STEEPER_YET = 4.0, 1.5
_STEEP_CELLS, _STEEPEST_CELLS = 16.0, 64.0
_STEEPEST = 3e4
#: Two running times that are nearer, relative to the fastest one, are one.
_SAME_TIME = 1e-7
#: Least of these multipliers, relative to energy over running time of the fastest run.
_STEEP = 30.0


def top_j(trip: Trip, profile: Profile) -> float:
    """Kinetic energy at the top speed of a run, J: the scale of energies."""
    return 0.5 * trip.train.inertia_kg * float(profile.speed_mps.max()) ** 2


class Line(NamedTuple):
    """E ≥ line_j − multiplier_j_per_s·T for every run, and the run that suggested the costate: its T and its E + λT."""

    multiplier_j_per_s: float
    line_j: float
    time_s: float
    cost_j: float


def level_line(problem: BoundingProblem) -> Line:
    """The line of λ = 0, which no run suggests."""
    return Line(0.0, problem.least_energy_j, math.inf, problem.least_energy_j)


def own_line(problem: BoundingProblem, profile: Profile, multiplier: float, fineness: float = 1.0) -> Line:
    """The line that a profile suggests for a multiplier, J/s."""
    x_m, w = profile.position_m - problem.trip.origin_m, profile.speed_mps**2
    cost_j = profile.total_energy_j + multiplier * profile.duration_s
    return Line(multiplier, problem.line(x_m, w, multiplier, fineness), profile.duration_s, cost_j)


def all_lines(
    problem: BoundingProblem,
    fastest: Profile,
    time_s: _Floats,
    energy_j: _Floats,
    multiplier_j_per_s: _Floats,
    clock: Clock,
) -> tuple[list[Line], bool]:
    """All lines for points at given running times and energies; see `certificate.front.certify_front`.

    Returns
    -------
    lines : list of Line
    reached : bool
        False when the time ended before there was a line for each multiplier: flatter ones are missing.
    """
    mesh = Mesh.of(problem.trip, fastest, _FINENESS)
    multipliers = _multipliers(multiplier_j_per_s, mesh.usual_multiplier)
    lines = [level_line(problem), *_extremal_lines(problem, mesh, multipliers, clock)]
    reached = not clock.expired
    lines += steep_lines(problem, fastest, float(multipliers[0]), clock)
    if not clock.expired:
        slower = time_s > fastest.duration_s * (1.0 + _SAME_TIME)
        lines += _refined_lines(problem, fastest, lines, time_s[slower], energy_j[slower], clock)
        lines += _ascended_lines(problem, mesh, fastest, lines, time_s[slower], energy_j[slower], clock)
    return lines, reached


def _multipliers(multiplier_j_per_s: _Floats, usual_multiplier: float) -> _Floats:
    """Multipliers to solve, decreasing: those given, thinned out and filled up; the usual one where none is given."""
    multipliers = np.unique(multiplier_j_per_s[np.isfinite(multiplier_j_per_s) & (multiplier_j_per_s > 0.0)])
    if len(multipliers) == 0:
        multipliers = np.array([usual_multiplier])
    if len(multipliers) > _MOST_LINES:
        multipliers = multipliers[np.linspace(0, len(multipliers) - 1, _MOST_LINES).round().astype(np.int64)]
    between = np.sqrt(multipliers[1:] * multipliers[:-1])[multipliers[1:] > _APART * multipliers[:-1]]
    return np.sort(np.concatenate((multipliers, between, multipliers[-1] * np.array(_LARGER))))[::-1]


def _extremal_lines(
    problem: BoundingProblem,
    mesh: Mesh,
    multipliers: _Floats,
    clock: Clock,
    fineness: float = 1.0,
    gain_j: float = math.inf,
) -> Iterator[Line]:
    """Lines from the optimal runs of multipliers, J/s, until the time is up.

    A mesh knows no auxiliaries: their power is part of its multipliers.
    """
    counters = {"extremals": 0, "runs": 0, "costates": 0}
    for multiplier in multipliers.tolist():
        if clock.expired:
            return
        total = problem.total(multiplier)
        try:
            extremal = mesh.extremal(total, counters)
        except TgvdpError:
            continue  # one line less: the certificate is only looser
        n, time_s, energy_j = mesh.drive(extremal.switch, extremal.switch, 0.0, counters)
        line_j = problem.line(mesh.rows.x[:n], mesh.rows.w[:n], multiplier, fineness, gain_j)
        yield Line(multiplier, line_j, time_s, energy_j + total * time_s)


def _refined_lines(
    problem: BoundingProblem, fastest: Profile, lines: list[Line], time_s: _Floats, energy_j: _Floats, clock: Clock
) -> Iterator[Line]:
    """Lines on a finer mesh for multipliers between the others, where they promise most."""
    lines = list(lines)
    mesh = None
    tries = np.zeros(len(time_s), dtype=np.int64)
    size_j = np.maximum(np.abs(energy_j), NO_ENERGY * top_j(problem.trip, fastest))
    cells = 0
    while True:
        promise_j, target = _worthwhile(lines, time_s, energy_j, size_j, tries, _TRIES)
        if clock.expired or not promise_j.any():
            return
        mesh = mesh or Mesh.of(problem.trip, fastest, _REFINED_MESH)
        cells += len(mesh.cells.length_m)
        if cells > _MOST_CELLS:
            return
        chosen = int(np.argmax(promise_j / size_j))
        tries[chosen] += 1
        for line in _extremal_lines(problem, mesh, target[chosen : chosen + 1], clock, _REFINED_CELLS):
            lines.append(line)
            yield line


def _ascended_lines(
    problem: BoundingProblem,
    mesh: Mesh,
    fastest: Profile,
    lines: list[Line],
    time_s: _Floats,
    energy_j: _Floats,
    clock: Clock,
) -> Iterator[Line]:
    """Lines with costates improved by ascent, each point once, where they promise most.

    Not many in vain: what costates do not close is the run's own distance from the optimum, or a dent of the front.
    """
    lines, in_vain = list(lines), 0
    size_j = np.maximum(np.abs(energy_j), NO_ENERGY * top_j(problem.trip, fastest))
    tries = np.zeros(len(time_s), dtype=np.int64)
    for _ in range(_MOST_ASCENTS):
        promise_j, target = _worthwhile(lines, time_s, energy_j, size_j, tries, 1)
        if clock.expired or in_vain == _TRIES or not promise_j.any():
            return
        chosen = int(np.argmax(promise_j / size_j))
        tries[chosen] += 1
        before_j = max(line.line_j - line.multiplier_j_per_s * time_s[chosen] for line in lines)
        gain_j = _ASCENT_GAIN * float(size_j[chosen])
        for line in _extremal_lines(problem, mesh, target[chosen : chosen + 1], clock, gain_j=gain_j):
            closed_j = line.line_j - line.multiplier_j_per_s * time_s[chosen] - before_j
            in_vain = 0 if closed_j > _PROMISED_SHARE * (energy_j[chosen] - before_j) else in_vain + 1
            lines.append(line)
            yield line


def _worthwhile(
    lines: list[Line],
    time_s: _Floats,
    energy_j: _Floats,
    size_j: _Floats,
    tries: NDArray[np.int64],
    most_tries: int,
) -> tuple[_Floats, _Floats]:
    """What a better line may gain at each point, J, 0 where that is not worth it, and the multiplier of that line."""
    gap_j, promise_j, target = _promises(np.array(lines), time_s, energy_j, tries)
    promise_j[(tries >= most_tries) | (gap_j <= _ENOUGH * size_j)] = 0.0
    promise_j[promise_j <= np.maximum(_PROMISE * size_j, _PROMISED_SHARE * gap_j)] = 0.0
    return promise_j, target


def _promises(
    lines: _Floats, time_s: _Floats, energy_j: _Floats, tries: NDArray[np.int64]
) -> tuple[_Floats, _Floats, _Floats]:
    """Gap at each point, J, how much of it a refined line might close, J, and the multiplier of that line, J/s.

    Lines from optimal costates are at most as high as their runs cost; the difference is what finer cells may gain.
    Half the product of the differences in time and multiplier is what another multiplier may gain. Where the point
    itself is not optimal neither closes the gap, and nothing is promised.
    """
    multiplier, line_j, line_s, cost_j = lines.T
    value_j = line_j[:, None] - multiplier[:, None] * time_s
    best = np.argmax(value_j, axis=0)
    lower_j = np.max(value_j, axis=0)
    finer_j = np.max(cost_j[:, None] - multiplier[:, None] * time_s, axis=0) - lower_j
    target = _multipliers_at(time_s, multiplier[1:], line_s[1:])
    other_j = 0.5 * np.abs((target - multiplier[best]) * (line_s[best] - time_s))
    gap_j = energy_j - lower_j
    return gap_j, np.minimum(np.where(tries == 0, finer_j, 0.0) + other_j, gap_j), target


def _multipliers_at(time_s: _Floats, multiplier: _Floats, line_s: _Floats) -> _Floats:
    """Multipliers whose optimal runs take given times, between those of lines."""
    order = np.argsort(-multiplier)
    return np.exp(np.interp(time_s, np.maximum.accumulate(line_s[order]), np.log(multiplier[order])))


def steep_lines(problem: BoundingProblem, fastest: Profile, above: float, clock: Clock) -> Iterator[Line]:
    """Lines for the fastest run, whose own multiplier is infinite.

    Next to it the least energy falls as c·√(T − T_min): a line of multiplier λ is c²/(4λ) too low there, and its own
    losses grow with λ. In between is a best one; the costates of all are taken from the fastest run.
    """
    least = max(fastest.total_energy_j, 1e-3 * top_j(problem.trip, fastest)) / fastest.duration_s
    multiplier = max(above, _STEEP * least)
    most = max(multiplier, _STEEPEST * least)
    coarse = list(_climb(problem, fastest, multiplier, _STEEPER, most, _STEEP_CELLS, clock))
    yield from coarse
    if coarse:
        yield from _climb(problem, fastest, _best_multiplier(coarse), _STEEPER_YET, most, _STEEPEST_CELLS, clock)


def _climb(
    problem: BoundingProblem,
    fastest: Profile,
    multiplier: float,
    factor: float,
    most: float,
    cells: float,
    clock: Clock,
) -> Iterator[Line]:
    """Lines for the fastest run of multipliers that grow by a factor, up to the first that does not help."""
    highest_j = -math.inf
    while multiplier <= most and not clock.expired:
        line = own_line(problem, fastest, multiplier, cells)
        value_j = line.line_j - multiplier * fastest.duration_s
        if value_j > fastest.total_energy_j:
            return  # its losses are below the precision of the run, and so is what a steeper line could tell
        yield line
        if value_j <= highest_j:
            return
        highest_j = value_j
        multiplier *= factor


def _best_multiplier(lines: list[Line]) -> float:
    """Multiplier of the highest line at the time of its run: of the last three, as far off as A/λ + B·λ + C."""
    multiplier, line_j, time_s, cost_j = np.array(lines[-3:]).T
    if len(multiplier) == 3:
        falling, rising, _ = np.linalg.solve(
            np.column_stack((1.0 / multiplier, multiplier, np.ones(3))), cost_j - line_j
        )
        if falling > 0.0 and rising > 0.0:
            return float(np.clip(math.sqrt(falling / rising), multiplier[0], multiplier[-1]))
    return float(multiplier[np.argmax(line_j - multiplier * time_s)])
