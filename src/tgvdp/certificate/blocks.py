"""A system of blocks along a chain of nodes, each of which knows the ones beside it, solved from end to end."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import part

#: Second derivative of unknowns that stay as they are, and of all others, relative to their own.
_HELD, _LEAST_BEND = 1e30, 1e-9


class Blocks(NamedTuple):
    """A symmetric system of N nodes with m unknowns each, float64.

    Attributes
    ----------
    side, step : (N·m,)
        Right side and solution.
    own, link : (N, m, m)
        Blocks on the diagonal, and those beside it, by the unknowns of a node and of the next one.
    """

    side: NDArray[np.float64]
    step: NDArray[np.float64]
    own: NDArray[np.float64]
    link: NDArray[np.float64]


def blocks_for(nodes: int, own: int) -> Blocks:
    """Room for a system of so many nodes and unknowns of each."""
    return Blocks(*np.zeros((2, nodes * own)), *np.zeros((2, nodes, own, own)))


@part
def factor(held, blocks):
    """Cholesky's decomposition of the blocks of a system, in place: lower triangles, and links divided by them."""
    own, link = blocks.own, blocks.link
    nodes, count = own.shape[:2]
    for k in range(nodes):
        for j in range(count):
            own[k, j, j] += _HELD if held[k, j] else _LEAST_BEND * own[k, j, j] + 1e-300
            if k > 0:
                for i in range(count):
                    for m in range(count):
                        own[k, j, m] -= link[k - 1, i, j] * link[k - 1, i, m]
        for j in range(count):
            for m in range(j + 1):
                for i in range(m):
                    own[k, j, m] -= own[k, j, i] * own[k, m, i]
                if m < j:
                    own[k, j, m] /= own[k, m, m]
            own[k, j, j] = math.sqrt(max(own[k, j, j], 1e-300))
            for m in range(count):
                for i in range(j):
                    link[k, j, m] -= own[k, j, i] * link[k, i, m]
                link[k, j, m] /= own[k, j, j]


@part
def solve(blocks):
    """Solve a system whose blocks are decomposed."""
    side, own, link, step = blocks.side, blocks.own, blocks.link, blocks.step
    nodes, count = own.shape[:2]
    for k in range(nodes):
        at = k * count
        for j in range(count):
            if k > 0:
                for i in range(count):
                    side[at + j] -= link[k - 1, i, j] * side[at - count + i]
            for i in range(j):
                side[at + j] -= own[k, j, i] * side[at + i]
            side[at + j] /= own[k, j, j]
    for k in range(nodes - 1, -1, -1):
        at = k * count
        for j in range(count - 1, -1, -1):
            value = side[at + j]
            if k + 1 < nodes:
                for m in range(count):
                    value -= link[k, j, m] * step[at + count + m]
            for i in range(j + 1, count):
                value -= own[k, i, j] * step[at + i]
            step[at + j] = value / own[k, j, j]
