"""The front against a brute-force filter, an integral by cells, and the definition of each selection."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.pareto import ParetoFront

# Few distinct values make ties and duplicates common; the second kind covers the whole range of magnitudes.
SMALL = st.integers(0, 6).map(float)
WIDE = st.floats(min_value=-1e12, max_value=1e12, allow_nan=False)
POINTS = st.one_of(
    st.lists(st.tuples(SMALL, SMALL), max_size=40),
    st.lists(st.tuples(WIDE, WIDE), max_size=40),
)


def columns(points):
    table = np.array(points, dtype=float).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def brute_front(points):
    """Values of all points that no other point dominates, by the definition."""

    def dominated(a):
        return any(b[0] <= a[0] and b[1] <= a[1] and b != a for b in points)

    return sorted({a for a in points if not dominated(a)})


@given(POINTS)
def test_front_equals_brute_force_filter(points):
    front = ParetoFront.of(*columns(points))
    assert list(zip(front.time_s.tolist(), front.energy_j.tolist(), strict=True)) == brute_front(points)


@given(POINTS)
def test_members_are_strictly_ordered_and_point_at_their_source(points):
    time_s, energy_j = columns(points)
    front = ParetoFront.of(time_s, energy_j)
    assert np.all(np.diff(front.time_s) > 0)
    assert np.all(np.diff(front.energy_j) < 0)
    np.testing.assert_array_equal(time_s[front.source], front.time_s)
    np.testing.assert_array_equal(energy_j[front.source], front.energy_j)
    for member, source in enumerate(front.source):
        same = (time_s == front.time_s[member]) & (energy_j == front.energy_j[member])
        assert source == np.flatnonzero(same)[0]


@given(POINTS, st.randoms(use_true_random=False))
def test_order_of_input_does_not_matter_and_filter_is_idempotent(points, random):
    front = ParetoFront.of(*columns(points))
    shuffled = list(points)
    random.shuffle(shuffled)
    for other in (ParetoFront.of(*columns(shuffled)), ParetoFront.of(front.time_s, front.energy_j)):
        np.testing.assert_array_equal(other.time_s, front.time_s)
        np.testing.assert_array_equal(other.energy_j, front.energy_j)


@given(st.lists(st.tuples(SMALL, SMALL), max_size=20), st.integers(-1, 8), st.integers(-1, 8))
def test_hypervolume_counts_dominated_unit_cells(points, time_s, energy_j):
    cells = sum(any(p[0] <= t and p[1] <= e for p in points) for t in range(-2, time_s) for e in range(-2, energy_j))
    assert ParetoFront.of(*columns(points)).hypervolume(time_s, energy_j) == cells


def test_hypervolume_agrees_with_monte_carlo():
    random = np.random.default_rng(7)
    front = ParetoFront.of(*random.random((2, 200)))
    samples = random.random((100_000, 2)) * 1.2
    index = np.searchsorted(front.time_s, samples[:, 0], side="right") - 1
    share = np.mean((index >= 0) & (front.energy_j[np.maximum(index, 0)] <= samples[:, 1]))
    assert front.hypervolume(1.2, 1.2) == pytest.approx(1.44 * share, rel=0.01)


@given(POINTS.filter(bool), st.one_of(SMALL, WIDE))
def test_a_further_point_never_shrinks_the_hypervolume(points, value):
    reference = max(p[0] for p in points) + 1.0, max(p[1] for p in points) + 1.0
    before = ParetoFront.of(*columns(points)).hypervolume(*reference)
    after = ParetoFront.of(*columns([*points, (value, value)])).hypervolume(*reference)
    assert after >= before * (1 - 1e-12)


@given(st.lists(st.tuples(SMALL, SMALL), min_size=1), st.integers(0, 7), st.integers(0, 3))
def test_at_delay_is_the_cheapest_member_within_it(points, delay_s, reference_s):
    front = ParetoFront.of(*columns(points))
    within = [e for t, e in points if t <= reference_s + delay_s]
    if not within:
        with pytest.raises(InfeasibleError, match="no member within a delay"):
            front.at_delay(delay_s, reference_s)
        return
    index = front.at_delay(delay_s, reference_s)
    assert front.energy_j[index] == min(within)
    assert front.time_s[index] <= reference_s + delay_s


@given(st.lists(st.tuples(SMALL, SMALL), min_size=1), st.integers(-4, 10))
def test_at_saving_is_the_fastest_member_that_saves_as_much(points, tenths):
    front = ParetoFront.of(*columns(points))
    within = [t for t, e in points if 1.0 - e / 5.0 >= tenths / 10 - 1e-9]
    if not within:
        with pytest.raises(InfeasibleError, match="no member saves"):
            front.at_saving(tenths / 10, 5.0)
        return
    assert front.time_s[front.at_saving(tenths / 10, 5.0)] == min(within)


def test_every_member_is_found_by_its_own_delay_and_saving():
    """As computed from printed figures: percent and back, a difference of times and back."""
    random = np.random.default_rng(3)
    front = ParetoFront.of(1234.567 + np.cumsum(random.random(60)), 4.2e9 - np.cumsum(random.random(60)) * 1e7)
    for index in range(len(front)):
        delay_s = front.time_s[index] - front.time_s[0]
        saved_pct = 100.0 * (1.0 - front.energy_j[index] / front.energy_j[0])
        assert front.at_delay(delay_s, front.time_s[0]) == index
        assert front.at_saving(saved_pct / 100.0, front.energy_j[0]) == index


def test_empty_front():
    front = ParetoFront.of([], [])
    assert len(front) == 0
    assert front.hypervolume(1.0, 1.0) == 0.0
    with pytest.raises(InfeasibleError, match="empty"):
        front.at_delay(1.0, 0.0)
    with pytest.raises(InfeasibleError, match="empty"):
        front.at_saving(0.1, 1.0)


def test_single_point_duplicates_and_all_dominated():
    assert len(ParetoFront.of([3.0], [4.0])) == 1
    np.testing.assert_array_equal(ParetoFront.of([3.0] * 5, [4.0] * 5).source, [0])
    front = ParetoFront.of([5.0, 5.0, 1.0, 7.0], [5.0, 1.0, 1.0, 1.0])
    np.testing.assert_array_equal(front.source, [2])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_rejected_by_name(bad):
    with pytest.raises(InputError, match=r"time_s\[1\]"):
        ParetoFront.of([1.0, bad], [1.0, 2.0])
    with pytest.raises(InputError, match=r"energy_j\[0\]"):
        ParetoFront.of([1.0, 2.0], [bad, 2.0])
    front = ParetoFront.of([1.0], [1.0])
    for call in (
        lambda: front.hypervolume(bad, 1.0),
        lambda: front.hypervolume(1.0, bad),
        lambda: front.at_delay(bad, 1.0),
        lambda: front.at_saving(bad, 1.0),
    ):
        with pytest.raises(InputError, match="finite"):
            call()


def test_shapes_and_order_are_checked():
    with pytest.raises(InputError, match="equally long"):
        ParetoFront.of([1.0], [1.0, 2.0])
    with pytest.raises(InputError, match="one dimension"):
        ParetoFront.of([[1.0]], [[1.0]])
    with pytest.raises(InputError, match="above 0 J"):
        ParetoFront.of([1.0], [1.0]).at_saving(0.1, 0.0)
    with pytest.raises(InputError, match="strictly"):
        ParetoFront(np.array([1.0, 2.0]), np.array([1.0, 1.0]), np.array([0, 1]))
    with pytest.raises(InputError, match="source"):
        ParetoFront(np.array([1.0]), np.array([1.0]), np.array([0, 1]))


def test_a_front_owns_its_arrays_and_they_are_read_only():
    time_s = np.array([1.0, 2.0])
    front = ParetoFront.of(time_s, [2.0, 1.0])
    time_s[0] = 9.0
    assert front.time_s[0] == 1.0
    for values in (front.time_s, front.energy_j, front.source):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0


def test_its_representation_is_one_line():
    assert repr(ParetoFront.of([100.0, 110.0, 120.0], [7.2e6, 5e6, 3.6e6])) == (
        "<ParetoFront: 3 points from 100.0 s, 2.00 kWh to 120.0 s, 1.00 kWh>"
    )
    assert repr(ParetoFront.of([], [])) == "<ParetoFront: no points>"
