"""Which cells of a mesh are too long, told by extremals on cells of half the size, which then answer in their stead.

What a run on the long cells costs more than one on the short ones, at the same multiplier, is lost in two ways. Within
a cell both may come from and to the same speeds, and one costs more; what it has more at the end of a cell in kinetic
energy is worth its price. Or they differ in speed for many cells: as the Hamiltonian is stationary along an extremal, a
difference δ in w = v² costs ½·δ²·∂²H/∂w² per metre, of which ∂²(λ/v)/∂w² = ¾λ/v⁵ is the part that holds a run at its
speed. The loss itself is known, so that only the shares of the cells in it are estimated.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.multipliers import ExtremalFront

#: A mesh is fine enough when the extremals on half its cells, which answer, are right to this share of their energy:
#: as errors fall by four from one to the other, to a third of what they save. Where they cost more, errors do not fall.
_MESH_LOSS = 1e-4
_SAVED_PER_LOSS = 3.0
#: How often cells may be halved.
_MOST_HALVINGS = 6


@dataclass
class Doubt:
    """What may still be asked of the meshes of a trip.

    Attributes
    ----------
    halvings : int
        How often cells may still be halved.
    """

    halvings: int = _MOST_HALVINGS

    def answered(self, front: ExtremalFront, target_s: NDArray[np.float64]) -> ExtremalFront:
        """Halve cells of a front's mesh until they lose little at all extremals next to targets, and then each of them.

        Parameters
        ----------
        front : ExtremalFront
        target_s : (n,) float64
            Increasing running times that are wanted, s.

        Returns
        -------
        ExtremalFront
            Those extremals, solved on these halves.
        """
        mesh = front.mesh
        extremals = front.around(target_s)
        asked = extremals
        while True:
            multipliers = [one.multiplier for one in asked]
            fastest, *finer = front.solved(mesh.finer, [math.inf, *multipliers])
            answers = dict(zip(multipliers, finer, strict=True))
            asked, cells = _losing(front, mesh, asked, answers)
            if not asked or not self.halvings:
                break
            self.halvings -= 1
            mesh = mesh.halved(cells)
            asked = front.solved(mesh, [one.multiplier for one in asked])
        missing = [one.multiplier for one in extremals if one.multiplier not in answers]
        answers |= zip(missing, front.solved(mesh.finer, missing), strict=True)
        return front.on(mesh.finer, fastest, [answers[one.multiplier] for one in extremals])

    def is_settled(self, front: ExtremalFront, runs: Sequence[Run]) -> bool:
        """Whether the cells of a front with its runs need not, or may not, all be halved once more.

        They need be where an extremal is dearer, at its own multiplier, than one of the runs.
        """
        if not self.halvings or front.stands(runs):
            return True
        self.halvings -= 1
        return False


def _losing(
    front: ExtremalFront, mesh: Mesh, asked: Sequence[Extremal], answers: Mapping[float, Extremal]
) -> tuple[list[Extremal], NDArray[np.bool_]]:
    """Extremals of a mesh that lose too much, and the cells, (K,), with more than their part of it."""
    count = len(mesh.cells.length_m)
    losing: list[Extremal] = []
    loss = np.zeros(count)
    for extremal in asked:
        answer = answers[extremal.multiplier]
        saved_j = extremal.cost_j(extremal.multiplier) - answer.cost_j(extremal.multiplier)
        loss_j = max(saved_j / _SAVED_PER_LOSS, -saved_j)
        allowed_j = _MESH_LOSS * max(extremal.energy_j, mesh.least_drawn_j)
        if loss_j > allowed_j:
            losing.append(extremal)
            loss = np.maximum(loss, loss_j / allowed_j * _shares(mesh, extremal, answer))
    return losing, loss * count > 1.0


def _shares(mesh: Mesh, extremal: Extremal, answer: Extremal) -> NDArray[np.float64]:
    """Shares of the cells, (K,), in what an extremal and that on cells cut in two differ, each by its larger one."""
    passed = extremal.passed, answer.passed[::2]
    w = np.array([one[:, 0] for one in passed])
    spent_j = np.array([one[:, 2] + extremal.multiplier * one[:, 1] for one in passed])
    apart_w = w[0] - w[1]
    stiff = apart_w**2 / np.maximum(w.max(axis=0), mesh.floor_w) ** 2.5
    bends = mesh.cells.length_m * (stiff[:-1] + stiff[1:])
    kinetic_j = 0.5 * mesh.train.inertia_kg * mesh.tables.traction * apart_w
    saved_j = np.diff(spent_j[0] - spent_j[1] - kinetic_j)
    local = np.maximum(saved_j if saved_j.sum() > 0.0 else -saved_j, 0.0)
    return np.maximum(*(share / max(float(share.sum()), np.finfo(float).tiny) for share in (bends, local)))
