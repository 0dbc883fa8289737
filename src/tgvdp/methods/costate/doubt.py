"""Which cells of a mesh are too long, told by what extremals lose on it, and the mesh that answers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.losses import Losses, losses_of
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.multipliers import ExtremalFront

_Floats = NDArray[np.float64]

#: An extremal may lose this share of its energy. Where one loses more cells are cut until all lose no more than that
#: share, or where that takes too many, of what they lose on the cells that were asked.
_ENOUGH = 3e-5
_LOSS = 1e-5
_LEFT = 0.1
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
#: Neighbouring extremals lose in the same cells: so many are asked at first, evenly spread from end to end.
_ASKED = 5
#: How often cells may be halved.
_MOST_HALVINGS = 6


@dataclass
class Doubt:
    """What may still be asked of the meshes of a trip.

    Attributes
    ----------
    halvings : int
        How often cells may still be halved for another question.
    excess : float
        By which share of its energy an extremal was dearer than another run on the mesh before.
    some : bool
        Whether some extremals stand for their neighbours: not where one was dearer than another run for all that.
    """

    halvings: int = _MOST_HALVINGS
    excess: float = math.inf
    some: bool = True

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
        if self.some and mesh.tables.regeneration == 0.0:  # else one that is not may brake in a cell that is too long
            last = len(extremals) - 1
            chosen = {round(last * i / (_ASKED - 1)) for i in range(_ASKED)}
            asked = [extremals[i] for i in sorted(chosen)]
            others = [one for i, one in enumerate(extremals) if i not in chosen]
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

    def is_settled(self, front: ExtremalFront, outcome: _Floats) -> bool:
        """Whether the cells of a front need not, or may not, all be halved once more.

        They need be where an extremal is dearer, at its own multiplier, than one of the runs, of which it takes times,
        energies and multipliers, (n, 3); but not where that did not mend it, as next to a jump of the running time.
        """
        before, self.excess = self.excess, front.excess(outcome)
        is_mended = before <= _EXCESS or self.excess <= _MENDED * before
        if not self.halvings or self.excess <= _EXCESS or not is_mended:
            return True
        self.halvings -= 1
        self.some = False
        return False


def _multipliers(extremals: Sequence[Extremal]) -> list[float]:
    return [one.multiplier for one in extremals]


def _losses(front: ExtremalFront, mesh: Mesh, asked: Sequence[Extremal]) -> Losses:
    """What extremals lose on a mesh: they are solved on half its cells."""
    return losses_of(mesh, asked, front.solved(mesh.finer, _multipliers(asked)))


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
    total = lost.sum(axis=1)
    most = float(total.max())
    if most <= _ENOUGH:  # as on most metro sections
        return np.ones(count, dtype=np.int64)
    # To halve a cell saves 3/4 of its loss; to halve both halves, in twice as many cuts, 3/4 of what is left.
    worst, levels = lost.max(axis=0), range(_LEVELS)
    order = np.argsort(-np.concatenate([worst / 8.0**level for level in levels]), kind="stable")
    saved = np.concatenate([0.75 / 4.0**level * lost for level in levels], axis=1)[:, order]
    left = (total[:, np.newaxis] - saved.cumsum(axis=1)).max(axis=0)
    cuts = 1 + int((left <= max(_LOSS, _LEFT * most)).argmax())
    halvings: NDArray[np.int64] = np.bincount(order[:cuts] % count, minlength=count)
    return 2**halvings
