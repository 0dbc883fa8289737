"""Lower bounds on what the rest of a demand run costs, by speed: proved for every speed, not only for grid points.

The speed axis is cut into cells, with cuts at the joints of the force curves, so that v ↦ v + γ(v, d)·Δt is smooth
within a cell. Its range over a cell lies between its values at the ends, widened by max|f''|·w²/8, with the steepest
slope of the line for the low end and the least steep one for the high end. For a multiplier ν, let B_ν(k, cell) be the
least of cost + ν·distance over the remaining steps from any speed in the cell: each step is bounded by the cheapest
cost and the most favourable distance in the cell, followed by the best cell that it may lead to. Then

    cost to go ≥ B_ν − ν·(D − s), for every ν,

with the end of the tolerance that favours it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.alstom import BRAKING, TOP_KMH, TRACTION, Floats, power_w
from tgvdp.formulations.problem.demand import slope_range_permil, step
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.units import KMH_PER_MPS

#: Cells of speed; more give tighter bounds.
_CELLS = 4000
#: Widens each range by more than all rounding, m/s.
_SLACK_MPS = 1e-7
_MULTIPLIERS = 9
_ROUNDS = 3


class Cells(NamedTuple):
    """What one step can do from each cell (C of them) with each allowed demand (L of them).

    Attributes
    ----------
    edges : (C+1,) float64
        Speeds, m/s.
    first, last : (L, C) int64
        Range of cells that it may lead to; first > last where the speed limit forbids it all.
    cost_j : (L, C) float64
        Least cost.
    distance_m : (2, L, C) float64
        Least and largest distance.
    """

    edges: Floats
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    cost_j: Floats
    distance_m: Floats


class Bounds(NamedTuple):
    """Tables of B_ν.

    Attributes
    ----------
    edges : (C+1,) float64
    multipliers : (M,) float64
        J/m.
    to_go : (N+1, M, C) float64
        B_ν, J; infinite where the end cannot be reached.
    distance_m : (2, N+1, C) float64
        Least and largest distance still to come.
    """

    edges: Floats
    multipliers: Floats
    to_go: Floats
    distance_m: Floats

    def cost_to_go(self, instance: DemandInstance, k: int, speed_mps: Floats, distance_m: Floats) -> Floats:
        """Lower bound on the cost of the steps from k on: (n,) speeds and distances gone → (n,) J, maybe infinite."""
        cell = np.clip(np.searchsorted(self.edges, speed_mps, side="left") - 1, 0, self.edges.size - 2)
        low = instance.distance_m - instance.tol_m - distance_m
        high = instance.distance_m + instance.tol_m - distance_m
        reach = (self.distance_m[0, k, cell] <= high + 1e-6) & (self.distance_m[1, k, cell] >= low - 1e-6)
        best = np.full(speed_mps.shape, -np.inf)
        for m, nu in enumerate(self.multipliers):
            best = np.maximum(best, self.to_go[k, m, cell] - np.maximum(nu * low, nu * high))
        result: Floats = np.where(reach, best, np.inf)
        return result


def demand_bounds(instance: DemandInstance, levels: Floats) -> Bounds:
    """Make the tables for given levels of demand, with multipliers around the one that is best at the start."""
    cells = _cells(instance, levels)
    distances = np.stack([_to_go(instance, cells, np.array([nu]), only_distance=True)[:, 0] for nu in (1.0, -1.0)])
    distances[1] *= -1.0
    # Full power at full speed costs about this much per metre.
    scale = instance.p_max_w / instance.vmax_mps
    multipliers = np.concatenate(([0.0], -scale * np.geomspace(1e-3, 3.0, _MULTIPLIERS - 1)))
    for _ in range(_ROUNDS):
        tables = Bounds(cells.edges, multipliers, _to_go(instance, cells, multipliers), distances)
        at_start = tables.to_go[0, :, 0]
        low, high = (instance.distance_m + sign * instance.tol_m for sign in (-1.0, 1.0))
        value = at_start - np.maximum(multipliers * low, multipliers * high)
        best = int(np.argmax(value))
        near = multipliers[[max(0, best - 1), min(best + 1, multipliers.size - 1)]]
        multipliers = np.unique(np.concatenate((np.linspace(near[0], near[1], _MULTIPLIERS - 2), multipliers[:1])))
        multipliers = np.sort(multipliers)[::-1]
    return tables


def _cells(instance: DemandInstance, levels: Floats) -> Cells:
    joints = [end / KMH_PER_MPS for pieces in (TRACTION, BRAKING) for end, _ in pieces]
    grid = np.linspace(0.0, instance.vmax_mps, _CELLS + 1)
    edges = np.unique(np.concatenate((grid, [joint for joint in joints if joint < instance.vmax_mps])))
    left, right = edges[:-1] + _SLACK_MPS / 10, edges[1:] - _SLACK_MPS / 10  # inside: away from the jumps
    width = np.diff(edges)
    d = levels[:, None]
    easiest, steepest = slope_range_permil(instance)
    slowest, fastest = (
        np.stack([step(instance, end, d, slope).speed_mps for end in (left, right)]) for slope in (steepest, easiest)
    )
    bend = instance.dt_s / (instance.rotating_factor * instance.mass_kg) * (_largest_bend() + 2.0 * instance.davis[2])
    slack = _SLACK_MPS * (2.0 + instance.dt_s) + bend * width**2 / 8.0
    low, high = np.maximum(0.0, slowest.min(axis=0) - slack), fastest.max(axis=0) + slack
    first = np.clip(np.searchsorted(edges, low, side="right") - 1, 0, width.size)
    last = np.clip(np.searchsorted(edges, high, side="left") - 1, -1, width.size - 1)
    first[low > instance.vmax_mps] = width.size
    least_mean, most_mean = 0.5 * (edges[:-1] + low), 0.5 * (edges[1:] + high)
    mean = np.where(d >= 0.0, least_mean, most_mean)
    power = power_w(mean, d, instance.p_max_w, instance.cost_ref_mps, instance.alpha)
    distance = instance.dt_s * np.stack((least_mean, most_mean))
    return Cells(edges, first, last, power * instance.dt_s, distance)


def _largest_bend() -> float:
    """Largest |F''| of all pieces, N/(m/s)²."""
    start, worst = 0.0, 0.0
    for pieces in (TRACTION, BRAKING):
        start = 0.0
        for end, (_, _, c2, c3) in pieces:
            worst = max(worst, *(abs(2.0 * c2 + 6.0 * c3 * v) for v in (start, min(end, TOP_KMH))))
            start = end
    return worst * KMH_PER_MPS**2


def _to_go(instance: DemandInstance, cells: Cells, multipliers: Floats, *, only_distance: bool = False) -> Floats:
    """B_ν of all steps and cells: (N+1, M, C)."""
    count = cells.edges.size - 1
    table = np.full((instance.steps + 1, multipliers.size, count), np.inf)
    table[-1, :, cells.edges[:-1] <= instance.end_speed_max_mps * (1.0 + 1e-9) + 1e-9] = 0.0
    nu = multipliers[:, None, None]
    own = np.minimum(nu * cells.distance_m[0], nu * cells.distance_m[1])  # (M, L, C)
    if not only_distance:
        own = own + cells.cost_j
    own = np.where(cells.first <= cells.last, own, np.inf)
    for k in range(instance.steps - 1, -1, -1):
        table[k] = (own + _least_between(table[k + 1], cells.first, cells.last)).min(axis=1)
    return table


def _least_between(values: Floats, first: NDArray[np.int64], last: NDArray[np.int64]) -> Floats:
    """Least of (M, C) values from cell first to last: (L, C) indices → (M, L, C); anything where first > last.

    A range is covered by two ranges of the largest power of two cells that fits (a sparse table).
    """
    count = values.shape[-1]
    first, last = np.minimum(first, count - 1), np.maximum(last, 0)
    fits = np.frexp(np.maximum(1, last - first + 1))[1] - 1
    least = np.empty((values.shape[0], *first.shape))
    for power in range(int(fits.max()) + 1):
        here = fits == power
        size = 1 << power
        least[:, here] = np.minimum(values[:, first[here]], values[:, np.maximum(last[here] - size + 1, 0)])
        values = np.minimum(values[:, : count - size], values[:, size:]) if power < fits.max() else values
        count -= size
    return least
