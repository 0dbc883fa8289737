"""Values and rows as JSON, CSV and Markdown."""

import math

import numpy as np

from tgvdp.report.plain import csv_text, markdown_table, plain


def test_what_json_cannot_write_is_none_or_text():
    found = plain({"a": np.array([1.0, math.inf]), 2: (np.int64(3), True, None), "p": math.nan, "c": 1j})
    assert found == {"a": [1.0, None], "2": [3, True, None], "p": None, "c": "1j"}


def test_tables_align_numbers_right_and_words_left():
    assert markdown_table([{"a": "x", "b": 12345.6}]) == "| a | b |\n| --- | ---: |\n| x | 12346 |\n"
    rows = [{"a": None, "b": math.inf, "c": True}, {"a": "x", "b": 0.123456, "c": math.nan}]
    assert markdown_table(rows) == "| a | b | c |\n| --- | ---: | ---: |\n| – | inf | yes |\n| x | 0.1235 | – |\n"
    assert markdown_table([]) == ""


def test_csv_leaves_empty_what_is_unknown():
    assert csv_text([{"a": "x, y", "b": None}, {"a": 1.5, "b": 2}]) == b'a,b\n"x, y",\n1.5,2\n'
