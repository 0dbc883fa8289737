"""Tables of columns: the same numbers in every format, and the same decimals within a column of CSV."""

import io
import sys

import numpy as np
import pytest

from tgvdp.errors import InputError, MissingExtraError
from tgvdp.report import columns as module
from tgvdp.report.columns import decimals, to_csv, to_parquet, to_xlsx

TABLE = {
    "id": ["a", "b", "c"],
    "count": [1, 2, 3],
    "energy_kwh": np.array([2038.9974345223698, 12.5, -0.0]),
    "bound": [None, 0.25, float("inf")],
}


@pytest.mark.parametrize(
    ("values", "digits", "places"),
    [
        ([2038.99], 9, 5),
        ([0.5, 2.0], 3, 2),
        ([1e9], 3, 0),
        ([], 5, 0),
        ([0.0], 5, 0),
        ([1e-30], 5, 15),
        ([9.5, 10.0], 2, 0),
    ],
)
def test_decimals_follow_the_largest(values, digits, places):
    assert decimals(values, digits) == places


def test_csv_has_the_same_decimals_in_a_column():
    assert to_csv(TABLE, {"bound": 3}).decode().splitlines() == [
        "id,count,energy_kwh,bound",
        "a,1,2038.99743,",
        "b,2,12.50000,0.250",
        "c,3,0.00000,",
    ]


def test_parquet_keeps_numbers_in_full():
    parquet = pytest.importorskip("pyarrow.parquet")
    read = parquet.read_table(io.BytesIO(to_parquet(TABLE)))
    assert read.column_names == list(TABLE)
    assert read["energy_kwh"].to_pylist() == TABLE["energy_kwh"].tolist()
    assert read["bound"].to_pylist() == TABLE["bound"]


def test_excel_has_a_sheet_for_each_table():
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(io.BytesIO(to_xlsx({"front": TABLE, "profiles": {"x": [1.5]}})))
    assert book.sheetnames == ["front", "profiles"]
    head, *rows = book["front"].values
    assert head == tuple(TABLE)
    assert [row[:2] for row in rows] == [("a", 1), ("b", 2), ("c", 3)]
    assert [row[2] for row in rows] == pytest.approx(TABLE["energy_kwh"].tolist(), rel=1e-14)
    assert [row[3] for row in rows] == [None, 0.25, None]


def test_excel_refuses_more_rows_than_a_sheet_has(monkeypatch):
    pytest.importorskip("openpyxl")
    monkeypatch.setattr(module, "_MOST_EXCEL_ROWS", 3)
    with pytest.raises(InputError, match="a sheet holds 2 rows, front has 3"):
        to_xlsx({"front": TABLE})


@pytest.mark.parametrize(("package", "write"), [("pyarrow", to_parquet), ("openpyxl", to_xlsx)])
def test_formats_name_the_extra_that_they_need(monkeypatch, package, write):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"{package}: pip install 'tgvdp\[tables\]'"):
        write(TABLE)
