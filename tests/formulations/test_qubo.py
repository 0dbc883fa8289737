"""QUBO values and their builder, against sums written out term by term."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.qubo_case import NUMBERS, qubos
from tgvdp.errors import InputError
from tgvdp.formulations.qubo.qubo import MAX_ENUMERATED, Qubo, QuboBuilder, bits_of


def energy_by_hand(qubo, bits):
    total = qubo.offset
    for i in range(qubo.n):
        total += qubo.linear[i] * bits[i]
    for row, col, value in zip(qubo.rows, qubo.cols, qubo.values, strict=True):
        total += value * bits[row] * bits[col]
    return total


@given(qubos())
def test_energy_is_the_sum_of_the_terms(qubo):
    strings = np.array(list(itertools.product((0, 1), repeat=qubo.n)), dtype=np.int8).reshape(1 << qubo.n, qubo.n)
    by_hand = [energy_by_hand(qubo, bits) for bits in strings]
    assert np.array_equal(qubo.energy(strings), by_hand)
    assert qubo.energy(strings[-1]) == by_hand[-1]
    assert np.array_equal(qubo.energy(strings.reshape(1, 1 << qubo.n, 1, qubo.n)), np.reshape(by_hand, (1, -1, 1)))


@given(qubos())
def test_all_energies_counts_with_the_first_bit_lowest(qubo):
    z = np.arange(1 << qubo.n)
    assert np.array_equal(qubo.all_energies(), qubo.energy(bits_of(z, qubo.n)))


@given(st.dictionaries(st.integers(0, 4), NUMBERS), NUMBERS, NUMBERS, st.lists(st.tuples(st.integers(0, 4), NUMBERS)))
def test_squares_expand_to_what_they_mean(terms, constant, weight, more):
    builder = QuboBuilder("abcde")
    builder.add_square(terms, constant, weight)
    builder.add_square(more, -constant)  # pairs may name a bit twice
    bits = bits_of(np.arange(32), 5).astype(float)
    first = np.full(32, constant) + sum(a * bits[:, i] for i, a in terms.items())
    second = -constant + sum(a * bits[:, i] for i, a in more)
    assert np.array_equal(builder.build().all_energies(), weight * first**2 + second**2)


def test_equal_terms_add_up_and_cancelled_pairs_vanish():
    builder = QuboBuilder(["a", "b"])
    c = builder.add_variable("c")
    builder.add_quadratic(1, 0, 2.0)
    builder.add_quadratic(0, 1, 3.0)
    builder.add_quadratic(c, 1, 4.0)
    builder.add_quadratic(1, c, -4.0)
    builder.add_quadratic(c, c, 5.0)
    builder.add_linear(c, 1.0)
    builder.add_constant(7.0)
    qubo = builder.build()
    assert (qubo.rows.tolist(), qubo.cols.tolist(), qubo.values.tolist()) == ([0], [1], [5.0])
    assert (qubo.linear.tolist(), qubo.offset, qubo.labels) == ([0.0, 0.0, 6.0], 7.0, ("a", "b", "c"))
    assert qubo.stats == (3, 1, (5.0, 6.0))


@settings(max_examples=20)
@given(st.lists(st.dictionaries(st.integers(0, 4), NUMBERS), max_size=6))
def test_merging_on_the_way_changes_nothing(squares):
    whole, parts = QuboBuilder("abcde"), QuboBuilder("abcde")
    with pytest.MonkeyPatch.context() as patch:
        for terms in squares:
            whole.add_square(terms, 1.0)
        patch.setattr("tgvdp.formulations.qubo.qubo._PENDING_TERMS", 3)
        for terms in squares:
            parts.add_square(terms, 1.0)
        assert parts._pending <= 3
    assert np.array_equal(whole.build().all_energies(), parts.build().all_energies())


def test_nothing_is_a_qubo_too():
    qubo = QuboBuilder().build()
    assert qubo.stats == (0, 0, (0.0, 0.0))
    assert qubo.all_energies().tolist() == [0.0]


def test_values_are_read_only_copies():
    linear = np.ones(1)
    qubo = Qubo(linear, np.empty(0), np.empty(0), np.empty(0), 0.0, ("a",))
    linear[0] = 5.0
    assert qubo.linear[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        qubo.linear[0] = 2.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"labels": ("a", "a")}, "all different"),
        ({"labels": ("a",)}, "must name 2"),
        ({"values": [1.0, 2.0]}, "one length"),
        ({"rows": [1], "cols": [0]}, "row < col"),
        ({"cols": [2]}, "row < col"),
        ({"rows": [-1]}, "row < col"),
        ({"rows": [0, 0], "cols": [1, 1], "values": [1.0, 1.0]}, "twice"),
        ({"linear": [np.nan, 0.0]}, "finite"),
        ({"offset": np.inf}, "finite"),
    ],
)
def test_wrong_values_are_refused(change, message):
    good = {"linear": [1.0, 2.0], "rows": [0], "cols": [1], "values": [3.0], "offset": 0.0, "labels": ("a", "b")}
    with pytest.raises(InputError, match=message):
        Qubo(**{**good, **change})


@pytest.mark.parametrize("bits", [[0, 1, 1], 1, [0, 2], [0.5, 0.0]])
def test_wrong_bit_strings_are_refused(bits):
    qubo = QuboBuilder("ab").build()
    with pytest.raises(InputError, match="bit"):
        qubo.energy(bits)


def test_terms_of_unknown_bits_are_refused():
    beyond, below = QuboBuilder("a"), QuboBuilder("a")
    beyond.add_linear(1, 1.0)
    with pytest.raises(InputError, match="beyond the 1 labels"):
        beyond.build()
    with pytest.raises(InputError, match="below 0"):
        below.add_linear(-1, 1.0)


def test_too_many_bits_are_not_enumerated():
    with pytest.raises(InputError, match="too many to enumerate"):
        QuboBuilder(str(i) for i in range(MAX_ENUMERATED + 1)).build().all_energies()
