"""Cells of a run: what they are cut into has a bound, whatever the costate."""

import numpy as np
import pytest

from tgvdp.certificate.cells import Cut, count_cells, cut_rows, graded_step, join_rows, split_cells

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


def cut_up(x_m, w, cut):
    parts = np.empty(len(x_m) - 1, dtype=np.int64)
    count = count_cells(x_m, w, cut, parts)
    assert count == parts.sum()
    node_m, node_w, row = np.empty(count + 1), np.empty(count + 1), np.empty(count, dtype=np.int64)
    assert cut_rows(x_m, w, parts, node_m, node_w, row) == count
    return node_m, node_w, row


@pytest.mark.nojit
def test_cells_of_an_acceleration_lose_alike_and_together_what_they_may():
    x_m, w = np.array([0.0, 100.0, 400.0, 700.0]), np.array([1.0, 101.0, 401.0, 401.0])
    budget_s = 0.01
    cut = Cut(1e4, 1e4, graded_step(x_m, w, np.empty(3), budget_s))
    node_m, node_w, row = cut_up(x_m, w, cut)
    v = np.sqrt(node_w)
    loss_s = 2.0 * np.diff(node_m) / (v[1:] + v[:-1]) * np.diff(np.log(node_w)) ** 2
    assert loss_s.sum() == pytest.approx(budget_s, rel=0.05)
    assert loss_s[row < 2].max() < 1.2 * loss_s[row < 2].min()
    assert np.count_nonzero(row == 2) == 1
    np.testing.assert_allclose(np.interp(x_m, node_m, node_w), w, rtol=1e-12)
    np.testing.assert_allclose(np.interp(node_m, x_m, w), node_w, rtol=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("backwards", [False, True])
def test_a_standstill_has_a_cell_of_its_own(backwards):
    x_m, w = np.array([0.0, 50.0]), np.array([0.0, 100.0])
    node_m, node_w, _ = cut_up(x_m, w[::-1].copy() if backwards else w, Cut(1e4, 1e4, 0.1))
    if backwards:
        node_m, node_w = 50.0 - node_m[::-1], node_w[::-1]
    assert len(node_m) > 20
    assert node_w[1] == pytest.approx(1e-2, rel=1e-6)
    np.testing.assert_allclose(node_w, 2.0 * node_m, atol=1e-12)
    steps = np.diff(np.cbrt(np.sqrt(node_w[1:])))
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)


@pytest.mark.nojit
def test_rows_that_differ_in_effort_place_or_direction_are_not_joined():
    x_m = np.arange(9.0)
    w = 100.0 + np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.9, 6.0, 5.0])
    effort = np.array([1.0, 1.02, 1.0, 0.5, 0.5, 0.5, 0.5, 0.5])
    place = np.array([0, 0, 0, 0, 0, 1, 1, 1])
    n = join_rows(x_m, w, effort, place, Cut(1e4, 1e4, 10.0))
    assert n == 5
    np.testing.assert_array_equal(x_m[:6], [0.0, 3.0, 5.0, 6.0, 7.0, 8.0])
    np.testing.assert_array_equal(w[:6], [100.0, 103.0, 105.0, 105.9, 106.0, 105.0])
    np.testing.assert_allclose(effort[:5], [3.02 / 3.0, 0.5, 0.5, 0.5, 0.5], rtol=1e-12)
    np.testing.assert_array_equal(place[:5], [0, 0, 1, 1, 1])
