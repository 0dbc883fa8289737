"""Costates of one phase from what is known at its ends."""

import numpy as np
import pytest

from tgvdp.certificate.regime_costates import Costates, fill_phase
from tgvdp.certificate.regimes import LabelledRun
from tgvdp.line.cells import Cells
from tgvdp.model.track import POWERED
from tgvdp.physics.codes import TRACTION


def _phase(growth, count=400, length_m=10.0):
    """Full traction at 15 m/s below the limit, where a change of p grows by ``growth`` per metre; p stays at −0.6."""
    ones = np.ones(count)
    cells = Cells(
        length_m * np.arange(count + 1.0), length_m * ones, 0.0 * ones, ones, 400.0 * ones,
        np.full(count, POWERED, dtype=np.int8), 0.0 * ones,
    )  # fmt: skip
    source = np.full((count, 4), 1e-4)  # of coasting: what a change of p costs
    source[:, 0] = 0.6 * growth
    label = np.full(count, TRACTION, dtype=np.int8)
    return LabelledRun(
        cells, np.full(count + 1, 225.0), ones, 1.0, -0.5, -0.3, label, source, np.full((count, 4), growth)
    )


@pytest.mark.parametrize("growth", [0.0, 1e-5, 1e-3, 0.05, -1e-3])
def test_a_mismatch_is_spread_where_it_costs_least(growth):
    """Nowhere is p beyond what it is at the ends, or where it stays; and no other way between the ends costs less."""
    run = _phase(growth)
    count = len(run.label)
    costates = Costates(*np.zeros((2, count)), *np.zeros((2, count + 1)))
    fill_phase(run, 0, count, -0.5, -0.55, costates)
    p = np.append(costates.left, costates.right[-1])
    assert (p[0], p[-1]) == (-0.5, -0.55)
    assert p.min() >= -0.6 - 1e-9
    assert p.max() <= -0.5 + 1e-9

    def cost(p):
        middle = 0.5 * (p[1:] + p[:-1])
        return float(np.sum((np.diff(p) / 10.0 - growth * (0.6 + middle)) ** 2))

    for place in (3, 100, 390):
        for change in (1e-4, -1e-4):
            other = p.copy()
            other[place] += change
            assert cost(other) >= cost(p) * (1.0 - 1e-3)
