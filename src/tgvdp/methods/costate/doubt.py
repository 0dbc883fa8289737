"""Which cells of a mesh are too long, told by runs on cells of half the size.

What a run on the long cells costs more than one on the short ones, at the same multiplier, is lost in two ways. Within
a cell both may come from and to the same speeds, and one costs more; what it has more at the end of a cell in kinetic
energy is worth its price. Or they differ in speed for many cells: as the Hamiltonian is stationary along an extremal, a
difference δ in w = v² costs ½·δ²·∂²H/∂w² per metre, of which ∂²(λ/v)/∂w² = ¾λ/v⁵ is the part that holds a run at its
speed. The loss itself is known, so that only the shares of the cells in it are estimated.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.multipliers import ExtremalFront

#: A mesh is fine enough when half its cells save no extremal more than this share of its energy: as the error falls by
#: four from one to the other, its own is a third more.
_MESH_LOSS = 1e-4
#: How often cells may be halved.
_MOST_HALVINGS = 6


@dataclass
class Doubt:
    """What a mesh was asked already, and what is left to ask.

    Attributes
    ----------
    settled : set of float
        Multipliers, J/s, at which the mesh, or one of which it is a refinement, is known to lose little.
    halvings : int
        How often cells may still be halved.
    """

    settled: set[float] = field(default_factory=set)
    halvings: int = _MOST_HALVINGS

    def refined(self, front: ExtremalFront, runs: Sequence[Run] = ()) -> Mesh:
        """Halve cells of a front's mesh until they lose little at any multiplier of its extremals.

        Parameters
        ----------
        front : ExtremalFront
        runs : sequence of Run
            Runs that were found on its mesh. Where an extremal is dearer than one of them, all cells are halved.

        Returns
        -------
        Mesh
            The same object where nothing is in doubt, or cells have been halved too often.
        """
        mesh = front.mesh
        asked = [e for e in front.extremals if math.isfinite(e.multiplier) and e.multiplier not in self.settled]
        while asked and self.halvings:
            asked, cells = self._doubted(front, mesh, asked)
            if asked:
                self.halvings -= 1
                mesh = mesh.halved(cells)
                asked = [mesh.extremal(extremal.multiplier, front.counters) for extremal in asked]
        if mesh is front.mesh and self.halvings and not front.stands(runs):
            self.halvings -= 1
            mesh = mesh.finer
        return mesh

    def _doubted(
        self, front: ExtremalFront, mesh: Mesh, asked: list[Extremal]
    ) -> tuple[list[Extremal], NDArray[np.bool_]]:
        """Extremals of a mesh that lose too much, and the cells, (K,), with more than their part of it."""
        count = len(mesh.cells.length_m)
        losing: list[Extremal] = []
        loss = np.zeros(count)
        for extremal in asked:
            front.watch()
            other = mesh.finer.extremal(extremal.multiplier, front.counters)
            loss_j = extremal.cost_j(extremal.multiplier) - other.cost_j(extremal.multiplier)
            allowed_j = _MESH_LOSS * front.base_j(extremal.energy_j)
            if loss_j <= allowed_j:
                self.settled.add(extremal.multiplier)
            else:
                losing.append(extremal)
                loss = np.maximum(loss, loss_j / allowed_j * _shares(mesh, extremal, other))
        return losing, loss * count > 1.0


def _shares(mesh: Mesh, extremal: Extremal, other: Extremal) -> NDArray[np.float64]:
    """Shares of the cells, (K,), in what an extremal loses against that on cells cut in two, each by its larger one."""
    passed = extremal.passed, other.passed[::2]
    w = np.array([one[:, 0] for one in passed])
    lost_j = np.array([one[:, 2] + extremal.multiplier * one[:, 1] for one in passed])
    apart_w = w[0] - w[1]
    stiff = apart_w**2 / np.maximum(w.max(axis=0), mesh.floor_w) ** 2.5
    bends = mesh.cells.length_m * (stiff[:-1] + stiff[1:])
    kinetic_j = 0.5 * mesh.train.inertia_kg * mesh.tables.traction * apart_w
    local = np.maximum(np.diff(lost_j[0] - lost_j[1] - kinetic_j), 0.0)
    return np.maximum(*(share / max(float(share.sum()), np.finfo(float).tiny) for share in (bends, local)))
