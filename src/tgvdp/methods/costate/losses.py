"""What extremals lose on a mesh, told by those of the same multipliers on cells of half the size.

What a run on the long cells costs more than one on the short ones, at the same multiplier, is lost in two ways. Within
a cell both may come from and to the same speeds, and one costs more; what it has more at the end of a cell in kinetic
energy is worth its price. Or they differ in speed for many cells: as the Hamiltonian is stationary along an extremal, a
difference δ in w = v² costs ½·δ²·∂²H/∂w² per metre, of which ∂²(λ/v)/∂w² = ¾λ/v⁵ is the part that holds a run at its
speed. The loss itself is known, so that only the shares of the cells in it are estimated. As halves of a cell lose a
fourth of what it does, that tells which cells to cut.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, leaf
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh

_Floats = NDArray[np.float64]

#: Where extremals lose more than this share of their energy, what they lose on shorter cells is not to be foretold.
_FORETOLD = 4e-4
#: As errors fall by four from one mesh to the other, an extremal loses so many times what its halves save; where these
#: cost more, errors do not fall, and so many times that counts for what is not to be foretold.
_LOST_PER_SAVED = 4.0 / 3.0
_DEARER = 3.0
#: A run that comes to a line of switching ends a cell on it, to this share of v².
_ON_LINE = 1e-6
#: ... and what may be lost of an extremal's energy for its costate at the start of a phase is not known.
_UNKNOWN_LOSS = 1e-3
#: ... in cells as long as this share of the way on which it rises by all it can.
_LONG = 0.3
_TINY = float(np.finfo(float).tiny)


class Losses(NamedTuple):
    """What extremals lose on a mesh of K cells.

    Attributes
    ----------
    lost : (m, K) float64
        Of each of them, in each cell, as a share of its energy.
    unknown : (m,) bool
        Whether what one loses on shorter cells is not to be foretold.
    long : (K,) bool
        The cells to be halved for that.
    least_j : (m,) float64
        The lesser cost E + λT of two: on the mesh and on half its cells.
    finer : list of Extremal
        Those on half its cells.
    """

    lost: _Floats
    unknown: NDArray[np.bool_]
    long: NDArray[np.bool_]
    least_j: _Floats
    finer: list[Extremal]

    def joined(self, others: "Losses") -> "Losses":
        """These losses, and those of other extremals behind them."""
        lost, least_j = np.concatenate((self.lost, others.lost)), np.concatenate((self.least_j, others.least_j))
        unknown = np.concatenate((self.unknown, others.unknown))
        return Losses(lost, unknown, self.long | others.long, least_j, self.finer + others.finer)


@leaf
def _saved_j(run, halves, k, multiplier, kinetic_kg):
    """What a run has spent more than one on half the cells, at a station of its own, less what it has more in speed."""
    apart_w = run[k, 0] - halves[2 * k, 0]
    return run[k, 2] - halves[2 * k, 2] + multiplier * (run[k, 1] - halves[2 * k, 1]) - kinetic_kg * apart_w


@leaf
def _stiffness(run, halves, k, floor_w):
    """What the difference in squared speed costs per metre at a station, up to a factor of all."""
    w = max(run[k, 0], halves[2 * k, 0], floor_w)
    return (run[k, 0] - halves[2 * k, 0]) ** 2 / (w * w * math.sqrt(w))


@entry
def fill_losses(length_m, passed, halves, multipliers, kinetic_kg, floor_w, drawn_j, lost, long, of_run):
    """Fill in what runs lose in each cell.

    Parameters
    ----------
    length_m : (K,) float64
        Lengths of the cells.
    passed : (m, K + 1, 3) float64
        Squared speed, m²/s², running time, s, and energy, J, of each run at each station.
    halves : (m, 2·K + 1, 3) float64
        The same of runs of the same multipliers on half the cells.
    multipliers : (m,) float64
        λ, J/s.
    kinetic_kg : float
        Energy of one m²/s².
    floor_w : float
        Least squared speed that counts, m²/s².
    drawn_j : float
        Least energy whose shares are told, J.
    lost : (m, K) float64, modified in place
        Shares of a run's energy.
    long : (m, K) bool, modified in place
        Cells in which a run loses so much that what shorter ones lose is not to be foretold.
    of_run : (m, 2) float64, modified in place
        What the halves save of E + λT, J, and what is lost for that as a share of what may be foretold.
    """
    cells = length_m.shape[0]
    for i in range(multipliers.shape[0]):
        run, half, multiplier = passed[i], halves[i], multipliers[i]
        all_j = _saved_j(run, half, cells, multiplier, kinetic_kg)
        sign = 1.0 if all_j >= 0.0 else -1.0
        bends = local_j = 0.0
        after, after_j = _stiffness(run, half, 0, floor_w), _saved_j(run, half, 0, multiplier, kinetic_kg)
        for k in range(cells):
            before, after = after, _stiffness(run, half, k + 1, floor_w)
            before_j, after_j = after_j, _saved_j(run, half, k + 1, multiplier, kinetic_kg)
            lost[i, k] = length_m[k] * (before + after)
            bends += lost[i, k]
            local_j += max(sign * (after_j - before_j), 0.0)
        loss = _LOST_PER_SAVED * abs(all_j) / max(run[cells, 2], drawn_j)
        unknown = loss * (_DEARER if all_j < 0.0 else 1.0) / _FORETOLD
        after_j = _saved_j(run, half, 0, multiplier, kinetic_kg)
        shares = 0.0
        for k in range(cells):
            before_j, after_j = after_j, _saved_j(run, half, k + 1, multiplier, kinetic_kg)
            share = max(lost[i, k] / max(bends, _TINY), max(sign * (after_j - before_j), 0.0) / max(local_j, _TINY))
            lost[i, k] = share
            long[i, k] = unknown > 1.0 and unknown * share * cells > 1.0
            shares += share
        for k in range(cells):
            lost[i, k] *= loss / max(shares, _TINY)
        of_run[i, 0] = all_j
        of_run[i, 1] = unknown


def losses_of(mesh: Mesh, asked: Sequence[Extremal], finer: list[Extremal]) -> Losses:
    """What extremals lose on a mesh, by those of the same multipliers on half its cells."""
    shape = len(asked), len(mesh.cells.length_m)
    lost, long, of_run = np.empty(shape), np.empty(shape, dtype=np.bool_), np.empty((len(asked), 2))
    passed, halves = np.array([one.passed for one in asked]), np.array([one.passed for one in finer])
    kinetic_kg = 0.5 * mesh.train.inertia_kg * mesh.tables.traction
    multipliers = np.array([one.multiplier for one in asked])
    fill_losses(
        mesh.cells.length_m, passed, halves, multipliers, kinetic_kg, mesh.floor_w, mesh.least_drawn_j, lost, long,
        of_run,
    )  # fmt: skip
    if mesh.tables.regeneration > 0.0:
        long |= [_brakes_within(mesh.finer, one).reshape(-1, 2).any(axis=1) for one in finer]
    cost_j = [one.cost_j(one.multiplier) for one in asked]
    least_j: _Floats = cost_j - np.maximum(of_run[:, 0], 0.0)
    unknown = (of_run[:, 1] > 1.0) | long.any(axis=1)
    return Losses(lost, unknown, np.asarray(long.any(axis=0)), least_j, finer)


def _brakes_within(mesh: Mesh, run: Extremal) -> NDArray[np.bool_]:
    """Cells, (K,), that are too long to tell where dynamic braking begins in them.

    A run that does not brake at the start of a cell comes to the line of braking at its end, wherever that line is
    between. On the way the costate rises, by all that lies between coasting and friction within L = η·m·v³/λ. What it
    is too high at the start, of which half is lost on average, is known of no run: two meshes may be wrong alike, where
    a cell is as long as a large share of L. So they may where a run that drives at the start has passed that line at
    the end: it may miss all that the dynamic brake returns along the cell.
    """
    a, b, w, regeneration = run.switch[:, 0], run.switch[:, 2], run.passed[:, 0], mesh.tables.regeneration
    is_line = b[1:] < mesh.fast[1:]
    lands = is_line & (w[1:] < w[:-1]) & (np.abs(w[1:] - b[1:]) <= _ON_LINE * b[1:])
    lands &= w[:-1] < b[:-1] * (1.0 + _ON_LINE)
    passes = is_line & (w[:-1] <= a[:-1] * (1.0 + _ON_LINE)) & (w[1:] >= b[1:] * (1.0 - _ON_LINE))
    least_j = _UNKNOWN_LOSS * max(run.energy_j, mesh.least_drawn_j)
    returned_j = np.maximum(-np.diff(run.passed[:, 2]), 0.0)
    brake = mesh.trip.train.dynamic_brake_limit
    for k in np.flatnonzero(passes):
        returned_j[k] = regeneration * brake.effort_n(math.sqrt(w[k + 1])) * mesh.cells.length_m[k]
    rise = regeneration * mesh.train.inertia_kg * np.maximum(w[1:], mesh.floor_w) ** 1.5
    asked = run.multiplier * mesh.cells.length_m
    return np.asarray((lands | passes) & (asked > _LONG * rise) & (0.5 * asked * returned_j > least_j * rise))
