"""Descents along which runs under the dynamic brake part from each other: their cells have to be short.

A brake of limited power has the less effort the faster the train is. Where it nearly holds a descent, a run that is a
little faster than another leaves it behind, by a factor of e within some hundred metres, and all runs that follow come
from next to one speed. Costates go back by one step per cell, which knows nothing of that where it is longer.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.line.cells import Cells
from tgvdp.model.track import POWERED
from tgvdp.physics.forces import KernelTrain, effort_at, resistance_at

#: Speeds that are looked at, from the fastest one of a cell down, each so many times the one before it: down to an
#: eighth of that. A brake that holds a descent at less is not used for that, and cells would be without number.
_SPEEDS = 50
_STEP = 0.96


@kernel
def _parting(train, grade_n, air, length_m, top_w):
    """By how many factors of e runs under the dynamic brake part at most within a cell.

    From one speed to the next the net force N changes by N'·Δ: over a length d runs there part by 2·d·N'/m in w, but
    where N is large they are elsewhere before the cell ends, within ½·m·w/N.
    """
    most = 0.0
    v = math.sqrt(top_w)
    net = effort_at(train.braking, v) + resistance_at(train, air, v) + grade_n
    for _ in range(_SPEEDS):
        before_v = v
        before = net
        v *= _STEP
        net = effort_at(train.braking, v) + resistance_at(train, air, v) + grade_n
        if net > before:
            w = v * v
            least = 0.0 if net * before <= 0.0 else min(abs(net), abs(before))
            there_m = min(length_m, 0.5 * train.inertia_kg * w / max(least, 1e-300))
            most = max(most, 2.0 * there_m * (net - before) / (train.inertia_kg * (before_v * before_v - w)))
    return most


@kernel
def _parts(train, cells, top_w, parts):
    for k in range(parts.shape[0]):
        parts[k] = 1
        if cells.supply[k] == POWERED and cells.grade_n[k] + train.davis_a_n < 0.0 and top_w[k] > 0.0:
            parting = _parting(train, cells.grade_n[k], cells.air[k], cells.length_m[k], top_w[k])
            parts[k] = max(1, math.ceil(parting))


def parts_on_descents(train: KernelTrain, cells: Cells, fast_w: NDArray[np.float64]) -> NDArray[np.int64]:
    """Into how many parts to cut cells, (K,), so that runs under the dynamic brake part by e at most in each of them.

    Parameters
    ----------
    train : KernelTrain
    cells : Cells
    fast_w : (K + 1,) float64
        Fastest feasible squared speed at each station, m²/s².
    """
    parts = np.empty(len(cells.length_m), dtype=np.int64)
    _parts(train, cells, np.maximum(fast_w[:-1], fast_w[1:]), parts)
    return parts
