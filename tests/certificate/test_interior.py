"""Linear programs along a chain: the largest sum of least values, against a general solver."""

import numpy as np
import pytest
from scipy.optimize import linprog

from tgvdp.certificate.interior import BEGIN, improve, room_for
from tgvdp.certificate.program import DIFFER, program_for

pytestmark = pytest.mark.nojit
NODES, RUN, ROWS = 6, 3, 60


def random_program(seed, bands):
    """Groups between neighbours and of one node; rows around 0 in all directions, so that there is a top."""
    rng = np.random.default_rng(seed)
    own, count = 2 * bands + 1, 2 * bands + 2
    before, after = [*range(bands, 2 * bands), 2 * bands], [*range(bands), 2 * bands]
    unknown = [[own * k + j for j in before] + [own * (k + 1) + j for j in after] for k in range(NODES - 1)]
    unknown += [[own * k + min(j, own - 1) for j in range(count)] for k in range(NODES)]
    groups, runs = len(unknown), ROWS // RUN
    program = program_for(NODES, own, groups * ROWS, groups * runs, groups)
    of_nodes = (NODES - 1) * runs
    for q in range(groups * runs):  # the last unknown of a node's group is there twice
        columns = count if q < of_nodes else count - 1
        program.column[q, : min(DIFFER, columns)] = np.sort(rng.permutation(columns)[:DIFFER])
    program.coef[:] = rng.normal(size=program.coef.shape)
    program.coef[of_nodes * RUN :][program.column[of_nodes:].repeat(RUN, axis=0) == count - 1] = 0.0
    program.base[:] = rng.normal(size=program.base.shape)
    program.base[of_nodes:, -1] = 0.0
    program.const[:] = rng.uniform(0.0, 2.0, groups * ROWS)
    program.run[:], program.first[:] = RUN * np.arange(groups * runs + 1), runs * np.arange(groups + 1)
    program.unknown[:] = unknown
    program.held[2, 2] = True
    program.linear[:] = 0.1 * rng.normal(size=(NODES, own))
    program.least[:] = 1.0
    return program


def dense(program):
    """All coefficients of all rows."""
    coef = program.base.repeat(RUN, axis=0)
    for i, columns in enumerate(program.column.repeat(RUN, axis=0)):
        np.add.at(coef[i], columns, program.coef[i])
    return coef


def value(program, values):
    rows = program.const + np.einsum("ij,ij->i", dense(program), values[np.repeat(program.unknown, ROWS, axis=0)])
    return float(np.minimum.reduceat(rows, np.arange(0, len(rows), ROWS)).sum() + program.linear.ravel() @ values)


def reference(program, held):
    """The largest sum by a general solver."""
    groups, rows, n = len(program.least), len(program.const), len(held)
    matrix, coef = np.zeros((rows, n + groups)), dense(program)
    for i in range(rows):
        np.add.at(matrix[i], program.unknown[i // ROWS], -coef[i])
        matrix[i, n + i // ROWS] = 1.0
    bounds = [(held[j], held[j]) if program.held.ravel()[j] else (None, None) for j in range(n)] + [
        (None, None)
    ] * groups
    found = linprog(-np.append(program.linear.ravel(), np.ones(groups)), matrix, program.const, bounds=bounds)
    assert found.status == 0
    return -found.fun


@pytest.mark.parametrize("bands", [1, 2, 3])
@pytest.mark.parametrize("seed", range(8))
def test_the_largest_sum_is_found_and_what_is_held_stays(seed, bands):
    program = random_program(seed, bands)
    values = 0.1 * np.random.default_rng(seed + 50).normal(size=program.linear.size)
    start, top, held = values.copy(), reference(program, values), 2 * (2 * bands + 1) + 2
    assert value(program, values) < top - 1e-2
    room, progress = room_for(program), BEGIN
    while not progress.ended:
        progress = improve(program, values, 1e-6, 4, progress, room)
    assert progress.steps < 40
    assert values[held] == pytest.approx(start[held], abs=1e-12)
    assert top - 1e-5 <= value(program, values) <= top + 1e-9
