"""Linear programs along a chain: the largest sum of least values, against a general solver."""

import numpy as np
import pytest
from scipy.optimize import linprog

from tgvdp.certificate.interior import AT_NODE, BEGIN, Blocks, Program, improve

pytestmark = pytest.mark.nojit
NODES, ROWS = 6, 9


def random_program(seed):
    """Groups between neighbours and of one node; rows around 0 in all directions, so that there is a top."""
    rng = np.random.default_rng(seed)
    unknown = [(3 * k + 1, 3 * k + 2, 3 * k + 3, 3 * k + 5) for k in range(NODES - 1)]
    unknown += [(3 * k, 3 * k + 1, 3 * k + 2, 3 * k + 2) for k in range(NODES)]
    groups = len(unknown)
    coef, const = rng.normal(size=(groups * ROWS, 4)), rng.uniform(0.0, 2.0, groups * ROWS)
    coef[(NODES - 1) * ROWS :, 3] = 0.0
    first, rows = ROWS * np.arange(groups + 1), np.zeros((4, groups * ROWS))
    held = np.zeros((NODES, AT_NODE), dtype=np.bool_)
    held[2, 2] = True
    linear = 0.1 * rng.normal(size=(NODES, AT_NODE))
    return Program(coef, const, first, np.array(unknown), linear, held, *rows, np.ones(groups))


def value(program, values):
    y = values.ravel()
    rows = program.const + np.einsum("ij,ij->i", program.coef, y[np.repeat(program.unknown, ROWS, axis=0)])
    return float(np.minimum.reduceat(rows, program.first[:-1]).sum() + (program.linear * values).sum())


def reference(program, held):
    """The largest sum by a general solver."""
    groups, rows, n = len(program.least), len(program.const), NODES * AT_NODE
    matrix = np.zeros((rows, n + groups))
    for i in range(rows):
        np.add.at(matrix[i], program.unknown[i // ROWS], -program.coef[i])
        matrix[i, n + i // ROWS] = 1.0
    bounds = [(held[j], held[j]) if program.held.ravel()[j] else (None, None) for j in range(n)] + [
        (None, None)
    ] * groups
    found = linprog(-np.append(program.linear.ravel(), np.ones(groups)), matrix, program.const, bounds=bounds)
    assert found.status == 0
    return -found.fun


@pytest.mark.parametrize("seed", range(8))
def test_the_largest_sum_is_found_and_what_is_held_stays(seed):
    program = random_program(seed)
    values = 0.1 * np.random.default_rng(seed + 50).normal(size=(NODES, AT_NODE))
    start, top = values.copy(), reference(program, values.ravel())
    assert value(program, values) < top - 1e-2
    blocks = Blocks(np.zeros_like(values), *np.zeros((2, NODES, AT_NODE, AT_NODE)), np.zeros_like(values))
    progress = BEGIN
    while not progress.ended:
        progress = improve(program, values, 1e-6, 4, progress, np.zeros(4), np.zeros((5, 4)), blocks)
    assert progress.steps < 60
    assert values[2, 2] == pytest.approx(start[2, 2], abs=1e-12)
    assert top - 1e-5 <= value(program, values) <= top + 1e-9
