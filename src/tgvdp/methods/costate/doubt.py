"""Which cells of a mesh are too long, told by extremals on cells of half the size, and the mesh that answers.

What a run on the long cells costs more than one on the short ones, at the same multiplier, is lost in two ways. Within
a cell both may come from and to the same speeds, and one costs more; what it has more at the end of a cell in kinetic
energy is worth its price. Or they differ in speed for many cells: as the Hamiltonian is stationary along an extremal, a
difference δ in w = v² costs ½·δ²·∂²H/∂w² per metre, of which ∂²(λ/v)/∂w² = ¾λ/v⁵ is the part that holds a run at its
speed. The loss itself is known, so that only the shares of the cells in it are estimated. As halves of a cell lose a
fourth of what it does, that tells which cells to cut.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.multipliers import ExtremalFront

_Floats = NDArray[np.float64]

#: Cells are cut until extremals lose this share of their energy, or where that takes too many, of what they lose on the
#: cells that were asked.
_LOSS = 2e-5
_LEFT = 0.1
#: Where they lose more there, what they lose on shorter cells is not to be foretold: some are halved, and asked anew.
_FORETOLD = 4e-4
#: As errors fall by four from one mesh to the other, an extremal loses so many times what its halves save; where these
#: cost more, errors do not fall, and so many times that counts for what is not to be foretold.
_LOST_PER_SAVED = 4.0 / 3.0
_DEARER = 3.0
#: What an extremal may cost more on the cells that answer than on some that were asked, as a share of its energy; where
#: one costs more, all of these answer that were asked last.
_WORSE = 1e-4
#: A mesh is too coarse when an extremal is dearer, at its own multiplier, than another run by this share of its energy,
#: and when halving its cells leaves no more than so much of that.
_EXCESS = 5e-4
_MENDED = 0.7
#: With more than so many times the cells of the mesh that was asked it is as well to take all its halves, on which
#: extremals are solved already.
_FEW_CUTS = 1.25
#: How often a cell is halved at most to answer.
_LEVELS = 2
#: A run that comes to a line of switching ends a cell on it, to this share of v².
_ON_LINE = 1e-6
#: ... and what may be lost of an extremal's energy for its costate at the start of a phase is not known.
_UNKNOWN_LOSS = 1e-3
#: ... in cells as long as this share of the way on which it rises by all it can.
_LONG = 0.3
#: Neighbouring extremals lose in the same cells: of so many one is asked, all of the first ones, which differ most, and
#: the last one, which has one neighbour.
_NEIGHBOURS = 3
_FIRST = 3
#: How often cells may be halved.
_MOST_HALVINGS = 6
_TINY = float(np.finfo(float).tiny)


@dataclass
class Doubt:
    """What may still be asked of the meshes of a trip.

    Attributes
    ----------
    halvings : int
        How often cells may still be halved for another question.
    excess : float
        By which share of its energy an extremal was dearer than another run on the mesh before.
    """

    halvings: int = _MOST_HALVINGS
    excess: float = math.inf

    def answered(self, front: ExtremalFront, target_s: _Floats) -> ExtremalFront:
        """Cut cells of a front's mesh until they lose little at all extremals next to targets.

        Parameters
        ----------
        front : ExtremalFront
        target_s : (n,) float64
            Increasing running times that are wanted, s.

        Returns
        -------
        ExtremalFront
            Those extremals on the mesh that is short enough; the front itself where its own is.
        """
        mesh, extremals = front.mesh, front.around(target_s)
        if not extremals:
            return front
        asked, others = extremals, extremals[:0]
        if mesh.tables.regeneration == 0.0:  # else one that was not asked may brake in a cell that is too long
            last = len(extremals) - 1
            is_asked = [i < _FIRST or i % _NEIGHBOURS == 0 or i == last for i in range(last + 1)]
            asked = list(itertools.compress(extremals, is_asked))
            others = [one for one, known in zip(extremals, is_asked, strict=True) if not known]
        losses = _losses(front, mesh, asked)
        if others and (_parts(losses.lost) > 1).any():  # where some lose much, others may lose more, and elsewhere
            asked, losses = asked + others, losses.joined(_losses(front, mesh, others))
        least_j = dict(zip(_multipliers(asked), losses.least_j.tolist(), strict=True))
        known = np.empty((0, len(mesh.cells.length_m)))  # what cells lose of those that are not asked again
        while self.halvings and losses.unknown.any():
            self.halvings -= 1
            parts = 1 + losses.long.astype(np.int64)
            known = _on_parts(np.concatenate((known, losses.lost[~losses.unknown])), parts)
            mesh = mesh.cut(parts)
            again = [one.multiplier for one, unknown in zip(asked, losses.unknown, strict=True) if unknown]
            asked = front.solved(mesh, again)
            losses = _losses(front, mesh, asked)
            least_j |= zip(again, np.minimum(losses.least_j, [least_j[one] for one in again]).tolist(), strict=True)
        parts = _parts(np.concatenate((known, losses.lost)))
        if not losses.unknown.any() and parts.sum() <= _FEW_CUTS * len(parts):
            own = mesh.cut(parts)
            if own is front.mesh:
                return front
            fastest, *solved = front.solved(own, [math.inf, *_multipliers(extremals)])
            if not any(_is_dearer(own, one, least_j.get(one.multiplier, math.inf)) for one in solved):
                return front.on(own, fastest, solved)
        return _halves_of(front, mesh, extremals, losses.finer)

    def is_settled(self, front: ExtremalFront, runs: Sequence[Run]) -> bool:
        """Whether the cells of a front with its runs need not, or may not, all be halved once more.

        They need be where an extremal is dearer, at its own multiplier, than one of the runs; but not where that did
        not mend it, as next to a jump of the running time.
        """
        before, self.excess = self.excess, front.excess(runs)
        is_mended = before <= _EXCESS or self.excess <= _MENDED * before
        if not self.halvings or self.excess <= _EXCESS or not is_mended:
            return True
        self.halvings -= 1
        return False


class _Losses(NamedTuple):
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

    def joined(self, others: "_Losses") -> "_Losses":
        """These losses, and those of other extremals behind them."""
        lost, least_j = np.concatenate((self.lost, others.lost)), np.concatenate((self.least_j, others.least_j))
        unknown = np.concatenate((self.unknown, others.unknown))
        return _Losses(lost, unknown, self.long | others.long, least_j, self.finer + others.finer)


def _multipliers(extremals: Sequence[Extremal]) -> list[float]:
    return [one.multiplier for one in extremals]


def _losses(front: ExtremalFront, mesh: Mesh, asked: Sequence[Extremal]) -> _Losses:
    """What extremals lose on a mesh, by those of the same multipliers on half its cells."""
    multipliers = np.array(_multipliers(asked))
    finer = front.solved(mesh.finer, _multipliers(asked))
    passed = np.array([one.passed for one in asked])
    halves = np.array([one.passed[::2] for one in finer])
    apart_w, apart_s, apart_j = np.moveaxis(passed - halves, 2, 0)
    stiff = apart_w**2 / np.maximum(np.maximum(passed[..., 0], halves[..., 0]), mesh.floor_w) ** 2.5
    bends = mesh.cells.length_m * (stiff[:, :-1] + stiff[:, 1:])
    kinetic_j = 0.5 * mesh.train.inertia_kg * mesh.tables.traction * apart_w
    saved_j = apart_j + multipliers[:, np.newaxis] * apart_s - kinetic_j
    all_j = saved_j[:, -1:]  # both end at the same speed
    local_j = np.maximum(np.copysign(1.0, all_j) * np.diff(saved_j), 0.0)
    shares = np.maximum(*(one / np.maximum(one.sum(axis=1, keepdims=True), _TINY) for one in (bends, local_j)))
    drawn_j = np.maximum(passed[:, -1, 2:], mesh.least_drawn_j)
    loss = _LOST_PER_SAVED * np.abs(all_j) / drawn_j
    unknown = loss * np.where(all_j < 0.0, _DEARER, 1.0) / _FORETOLD
    long = (unknown > 1.0) & (unknown * shares * shares.shape[1] > 1.0)
    if mesh.tables.regeneration > 0.0:
        long |= [_brakes_within(mesh.finer, one).reshape(-1, 2).any(axis=1) for one in finer]
    cost_j = [one.cost_j(one.multiplier) for one in asked]
    least_j: _Floats = cost_j - np.maximum(all_j[:, 0], 0.0)
    return _Losses(
        loss * shares, (unknown[:, 0] > 1.0) | long.any(axis=1), np.asarray(long.any(axis=0)), least_j, finer
    )


def _halves_of(
    front: ExtremalFront, mesh: Mesh, extremals: Sequence[Extremal], finer: Sequence[Extremal]
) -> ExtremalFront:
    """The front on half the cells of a mesh, where some of its extremals are solved there already."""
    answers = {one.multiplier: one for one in finer}
    missing = [one for one in (math.inf, *_multipliers(extremals)) if one not in answers]
    answers |= zip(missing, front.solved(mesh.finer, missing), strict=True)
    return front.on(mesh.finer, answers[math.inf], [answers[one] for one in _multipliers(extremals)])


def _is_dearer(mesh: Mesh, extremal: Extremal, least_j: float) -> bool:
    """Whether an extremal costs more than one of its multiplier did on another mesh."""
    drawn_j = max(extremal.energy_j, mesh.least_drawn_j)
    return extremal.cost_j(extremal.multiplier) - least_j > _WORSE * drawn_j


def _on_parts(lost: _Floats, parts: NDArray[np.int64]) -> _Floats:
    """Losses in cells, (m, K), on their parts: a cell loses with the cube of its length."""
    return lost.repeat(parts, axis=1) / (parts**3).repeat(parts)


def _parts(lost: _Floats) -> NDArray[np.int64]:
    """Into how many parts to cut cells, (K,), with as few cuts as leave little of any loss, (m, K)."""
    count = lost.shape[1]
    total = lost.sum(axis=1, keepdims=True)
    if total.max() <= _LOSS:  # as on most metro sections
        return np.ones(count, dtype=np.int64)
    # To halve a cell saves 3/4 of its loss; to halve both halves, in twice as many cuts, 3/4 of what is left.
    worth = np.concatenate([lost.max(axis=0) / 8.0**level for level in range(_LEVELS)])
    order = np.argsort(-worth, kind="stable")
    saved = np.concatenate([0.75 / 4.0**level * lost for level in range(_LEVELS)], axis=1)[:, order]
    left = (total - np.cumsum(np.insert(saved, 0, 0.0, axis=1), axis=1)).max(axis=0)
    cuts = int(np.argmax(left <= max(_LOSS, _LEFT * float(total.max()))))
    halvings: NDArray[np.int64] = np.bincount(order[:cuts] % count, minlength=count)
    return 2**halvings


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
