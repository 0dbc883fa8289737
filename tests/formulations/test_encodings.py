"""Words of encodings and penalties, and what they build."""

import warnings

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.bits import encode_bits
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.names import BitsForm, bits_form, parse_encoding, parse_penalty, penalty_word
from tgvdp.instances import find


@pytest.mark.parametrize(
    ("word", "canonical", "form"),
    [
        ("bits", "bits", BitsForm()),
        ("bits+slack", "bits+slack", BitsForm("slack")),
        ("bits+mccormick+right+total-equality", "bits+total-equality+right+mccormick",
         BitsForm("total-equality", "right", mccormick=True)),
        ("bits+left+cubic", "bits+left+cubic", BitsForm(distance="left", cubic=True)),
        ("unary", "unary", None),
    ],
)  # fmt: skip
def test_every_form_is_a_word(word, canonical, form):
    assert parse_encoding(word) == canonical
    if form is not None:
        assert bits_form(word) == form
        assert form.word == canonical


@pytest.mark.parametrize(
    "word",
    ["", "bit", "unary+slack", "bits+", "bits+slack+total", "bits+left+right", "bits+limits", "bits+cubic+cubic"],
)
def test_other_words_are_none(word):
    with pytest.raises(ValueError, match="no encoding"):
        parse_encoding(word)


def test_words_and_forms_give_the_same_qubo():
    one = binary_instance(4, dv_mps=0.5)
    form = BitsForm("total-equality", "right", mccormick=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        by_word = encode(one, form.word, 3.0)
    np.testing.assert_array_equal(by_word.qubo.all_energies(), encode_bits(one, 3.0, form).qubo.all_energies())


@pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")
def test_each_kind_of_violation_has_its_own_weight():
    one = binary_instance(4, cap_units=1, distance_units=3.0, alpha=0.0)
    encoded = encode(one, "bits+slack", (2.0, 3.0, 5.0, 7.0))
    bits = dict.fromkeys(encoded.qubo.labels, 0)

    def penalty(**ones):
        string = np.array([(bits | ones)[label] for label in encoded.qubo.labels])
        return float(encoded.violation.energy(string[None])[0])

    slack = {"s1_0": 1, "s2_0": 1, "s3_0": 1}  # v = 0, so that each register holds the cap
    assert penalty(**slack) == 3.0 * 3**2
    assert penalty(**slack, x3=1, y3=1) == 2.0 + 3.0 * 3**2
    assert penalty(**slack, x3=1) == 3.0 * 2.5**2 + 5.0
    assert penalty() == 3.0 * 3**2 + 3 * 7.0
    with pytest.raises(InputError, match=r"2 kinds of violations \(logic, distance\), got 4 weights"):
        encode(one, "unary", (1.0, 1.0, 1.0, 1.0))


@pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")
def test_power_of_a_substation_has_a_weight_of_its_own():
    shared = read_instance(find("substation-k2-n006"))
    encoded = encode(shared, "unary", (2.0, 3.0, 7.0))
    labels = encoded.qubo.labels

    def penalty(*ones):
        return float(encoded.violation.energy(np.array([[int(label in ones) for label in labels]]))[0])

    distances = sum(train.trip.distance_range[0] ** 2 for train in shared.trains)
    assert penalty() == 3.0 * distances
    assert penalty("n0_0") == 3.0 * distances + 7.0
    assert penalty(next(label for label in labels if label.startswith("r"))) >= 3.0 * distances + 2.0
    with pytest.raises(InputError, match=r"3 kinds of violations \(logic, distance, limit\), got 2 weights"):
        encode(shared, "unary", (1.0, 1.0))


def test_the_cubic_objective_is_of_one_model_and_proves_nothing_of_it():
    with pytest.raises(InputError, match="cubic is the efficiency model's, got the constant model"):
        encode(binary_instance(4), "bits+cubic")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        assert not encode(binary_instance(3, model="efficiency", distance_units=1.0), "bits+cubic").complete


@pytest.mark.parametrize("text", ["0", "-1", "nan", "1/0", "1/2/3/4/5", "a/b", ""])
def test_penalties_are_a_rule_or_positive_numbers(text):
    with pytest.raises(ValueError):
        parse_penalty(text)
    assert parse_penalty("1/2.5/3") == (1.0, 2.5, 3.0)
    assert penalty_word(parse_penalty("1/2.5/3")) == "1/2.5/3"
