"""Cells of a run: what they are cut into has a bound, whatever the costate."""

import numpy as np
import pytest

from tgvdp.certificate.cells import split_cells

NODE_M, NODE_W, ROW = np.linspace(0.0, 400.0, 5), np.full(5, 100.0), np.arange(4)
NOTHING = np.empty(0), np.empty(0), np.empty(0, dtype=np.int64)


@pytest.mark.nojit
@pytest.mark.parametrize("costate", [1e3, 1e30, 1e200, 1e300])
def test_number_of_cells_has_a_bound(costate):
    """A costate that grows without end: its parts once were a number that no integer holds, and were written so."""
    left, right = np.array([0.0, -1.0, costate, 0.0]), np.array([-1.0, costate, -1.0, 0.0])
    values = NODE_M, NODE_W, ROW, left, right, 1.0, 0.05
    count = split_cells(*values, *NOTHING)
    assert 4 < count <= 2 + 2 * 1000
    made_m, made_w, made_row = np.empty(count + 1), np.empty(count + 1), np.empty(count, dtype=np.int64)
    assert split_cells(*values, made_m, made_w, made_row) == count
    assert (np.diff(made_m) > 0.0).all()
    assert (made_m[0], made_m[-1]) == (0.0, 400.0)
    assert set(np.diff(made_row)) <= {0, 1}


@pytest.mark.nojit
def test_cells_end_where_the_room_does():
    left, right = np.array([0.0, -1.0, 3.0, 0.0]), np.array([-1.0, 3.0, -1.0, 0.0])
    made_m, made_w, made_row = np.zeros(12), np.zeros(12), np.zeros(11, dtype=np.int64)
    views = made_m[:8], made_w[:8], made_row[:7]
    assert split_cells(NODE_M, NODE_W, ROW, left, right, 1.0, 0.05, *views) == 7
    assert not made_m[8:].any()
    assert not made_w[8:].any()
    assert not made_row[7:].any()
