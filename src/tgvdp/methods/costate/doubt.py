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
#: A run that comes to a line of switching ends a cell on it, to this share of v².
_ON_LINE = 1e-6
#: ... and what may be lost of an extremal's energy for its costate at the start of a phase is not known.
_UNKNOWN_LOSS = 1e-3
#: ... in cells as long as this share of the way on which it rises by all it can.
_LONG = 0.3
#: Neighbouring extremals lose in the same cells: of so many one is asked at first, the others on what cells it leaves.
#: Where they have few cells in all they are asked at once, for each round takes as long as some of them.
_NEIGHBOURS = 3
_FEW_CELLS = 1500
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
        neighbours = _NEIGHBOURS if len(extremals) * len(mesh.cells.length_m) > _FEW_CELLS else 1
        asked, unasked = extremals[::neighbours], [one for i, one in enumerate(extremals) if i % neighbours]
        answers: dict[float, Extremal] = {}  # on half the cells of this mesh, by multiplier
        while True:
            _answer(front, mesh, asked, answers)
            losing, cells = _losing(mesh, asked, answers)
            if losing and self.halvings:
                self.halvings -= 1
                mesh, answers = mesh.halved(cells), {}
                asked = front.solved(mesh, [one.multiplier for one in losing])
                continue
            _answer(front, mesh, extremals, answers)
            # What one loses on the first mesh, where cells have been halved since, is more than it loses on this one.
            asked = [one for one in unasked if self.halvings and _may_lose(mesh, one, answers[one.multiplier])]
            unasked = []
            if not asked:
                return front.on(mesh.finer, answers[math.inf], [answers[one.multiplier] for one in extremals])
            if mesh is not front.mesh:
                asked = front.solved(mesh, [one.multiplier for one in asked])

    def is_settled(self, front: ExtremalFront, runs: Sequence[Run]) -> bool:
        """Whether the cells of a front with its runs need not, or may not, all be halved once more.

        They need be where an extremal is dearer, at its own multiplier, than one of the runs.
        """
        if not self.halvings or front.stands(runs):
            return True
        self.halvings -= 1
        return False


def _answer(front: ExtremalFront, mesh: Mesh, asked: Sequence[Extremal], answers: dict[float, Extremal]) -> None:
    """Solve on half the cells of a mesh what is asked, and the fastest run, where there is no answer yet."""
    missing = [one for one in (math.inf, *(one.multiplier for one in asked)) if one not in answers]
    answers |= zip(missing, front.solved(mesh.finer, missing), strict=True)


def _losing(
    mesh: Mesh, asked: Sequence[Extremal], answers: Mapping[float, Extremal]
) -> tuple[list[Extremal], NDArray[np.bool_]]:
    """Extremals of a mesh that lose too much, and the cells, (K,), with more than their part of it."""
    count = len(mesh.cells.length_m)
    losing: list[Extremal] = []
    loss = np.zeros(count)
    too_long = np.zeros(count, dtype=np.bool_)
    for extremal in asked:
        answer = answers[extremal.multiplier]
        share = _loss_share(mesh, extremal, answer)
        long = _brakes_within(mesh, answer)
        too_long |= long
        if share > 1.0:
            loss = np.maximum(loss, share * _shares(mesh, extremal, answer))
        if share > 1.0 or long.any():
            losing.append(extremal)
    return losing, too_long | (loss * count > 1.0)


def _may_lose(mesh: Mesh, extremal: Extremal, answer: Extremal) -> bool:
    """Whether an extremal of this mesh, or of a coarser one, may lose too much."""
    return _loss_share(mesh, extremal, answer) > 1.0 or bool(_brakes_within(mesh, answer).any())


def _loss_share(mesh: Mesh, extremal: Extremal, answer: Extremal) -> float:
    """What an extremal loses, by its answer, in what it may lose."""
    saved_j = extremal.cost_j(extremal.multiplier) - answer.cost_j(extremal.multiplier)
    allowed_j = _MESH_LOSS * max(extremal.energy_j, mesh.least_drawn_j)
    return max(saved_j / _SAVED_PER_LOSS, -saved_j) / allowed_j


def _brakes_within(mesh: Mesh, answer: Extremal) -> NDArray[np.bool_]:
    """Cells, (K,), that are too long to tell where dynamic braking begins in them.

    A run that does not brake at the start of a cell comes to the line of braking at its end, wherever that line is
    between. On the way the costate rises, by all that lies between coasting and friction within L = η·m·v³/λ. What it
    is too high at the start, of which half is lost on average, is known of no run: two meshes may be wrong alike, where
    a cell is as long as a large share of L.
    """
    if mesh.tables.regeneration == 0.0 or math.isinf(answer.multiplier):
        return np.zeros(len(mesh.cells.length_m), dtype=np.bool_)
    finer = mesh.finer
    b, w = answer.switch[:, 2], answer.passed[:, 0]
    lands = (b[1:] < finer.fast[1:]) & (w[1:] < w[:-1]) & (np.abs(w[1:] - b[1:]) <= _ON_LINE * b[1:])
    lands &= w[:-1] < b[:-1] * (1.0 + _ON_LINE)
    least_j = _UNKNOWN_LOSS * max(answer.energy_j, mesh.least_drawn_j)
    returned_j = np.maximum(-np.diff(answer.passed[:, 2]), 0.0)
    rise = mesh.tables.regeneration * mesh.train.inertia_kg * np.maximum(w[1:], mesh.floor_w) ** 1.5
    asked = answer.multiplier * finer.cells.length_m
    long = lands & (asked > _LONG * rise) & (0.5 * asked * returned_j > least_j * rise)
    return np.asarray(long[::2] | long[1::2])


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
