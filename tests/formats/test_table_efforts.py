"""Effort curves as tables, in native trains."""

import pytest

from tests.helpers.refusal import refusal
from tests.helpers.table_case import EFFORT_TABLE, TRAIN_WITH_TABLE
from tgvdp.formats import load_scenario, load_train


def test_an_effort_curve_stands_in_a_native_train_and_in_its_provenance(saved):
    saved(EFFORT_TABLE, "effort.csv")
    scenario = load_scenario(saved(TRAIN_WITH_TABLE, "train.toml"))
    efforts = [scenario.train.traction.effort_n(speed) for speed in (0.0, 9.99, 10.0, 20.0, 30.0)]
    assert efforts == pytest.approx([200e3, 200e3, 150e3, 100.5e3, 100.5e3], rel=1e-3)
    assert [path.rpartition("/")[2] for path in scenario.inputs] == ["train.toml", "effort.csv"]


@pytest.mark.parametrize(
    ("effort", "message"),
    [
        ("speed_kmh,remark\n0,1",
         "train.traction: {}: no column for the tractive effort (such as effort_kn or Effort [kN]), got 'speed_kmh'"),
        ("speed_kmh,effort_kn\n0,\n1,2", "train.traction: {}: line 2, column 'effort_kn': must not be blank"),
        ("speed_kmh,effort_kn\n0,-2\n1,2",
         "train.traction: {}: line 2, column 'effort_kn': must be at least 0 kN, got -2 kN"),
        ("speed_kmh,effort_kn\n9,2\n1,2",
         "train.traction: {}: line 3, column 'speed_kmh': speeds must not decrease, got 1 km/h after 9 km/h"),
        ("speed_kmh,braking effort [kN]\n0,300\n9,200",
         "train.traction: {}: no column for the tractive effort (such as effort_kn or Effort [kN]), got 'speed_kmh'"),
        ("speed_kmh,effort_kn\n", "train.traction: {}: holds no rows below the header"),
        ("speed_kmh,effort_kn\n0,9\n5,8\n5,7\n5,6\n9,1",
         "train.traction: {}: line 5, column 'speed_kmh': a speed is given twice at most, where the effort jumps, "
         "got 5 km/h a third time"),
        ("[train]\n", "train.traction: {}: must be a table of speed and effort, as CSV or Excel, got TOML"),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_a_wrong_effort_table_is_named_with_the_train(saved, effort, message):
    path = saved(effort, "effort.txt")
    train = saved(TRAIN_WITH_TABLE.replace("effort.csv", "effort.txt"), "train.toml")
    assert refusal(load_train, train).startswith(message.format(path))


def test_a_column_of_tractive_effort_is_no_brake(saved):
    saved("Speed [km/h];Zugkraft [kN]\n0;200\n72;100\n", "effort.csv")
    text = TRAIN_WITH_TABLE + 'braking = { file = "effort.csv" }\n'
    assert refusal(load_train, saved(text, "train.toml")).endswith(
        "no column for the braking effort (such as effort_kn or Effort [kN]), got 'Speed [km/h]', 'Zugkraft [kN]'"
    )


def test_an_effort_file_excludes_other_forms_and_must_be_there(saved):
    train = saved(TRAIN_WITH_TABLE, "train.toml")
    assert refusal(load_train, train).startswith("train.traction.file: ")
    saved(EFFORT_TABLE, "effort.csv")
    both = saved(TRAIN_WITH_TABLE.replace("{ file", "{ force_kn = 2, file"), "train.toml")
    assert "must hold exactly one of force_kn (with power_kw or without), points, polynomials, file, got" in refusal(
        load_train, both
    )


def test_columns_of_an_effort_table_that_are_not_used_are_noted_with_the_train(saved):
    saved("Speed [km/h];Effort [kN];Mode\n5;200;a\n72;100,5;b\n", "effort.csv")
    train = load_train(saved(TRAIN_WITH_TABLE, "train.toml"))
    assert train.notes == (
        "effort.csv: columns not used: 'Mode'",
        "effort.csv: effort below 5 km/h is taken to be as large as there",
    )
