"""Numbers of texts, and the order of rows by them, whether the rows of a text stand together or not."""

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jink.io.values import codes_of, numbered, order_of, taken

NAMES = ["b", None, "a", "long enough not to be kept inline", "c"]


@pytest.mark.parametrize("together", [True, False], ids=["in runs", "in turns"])
def test_codes_are_in_the_order_of_the_texts_and_zero_where_there_is_none(together):
    texts = [name for name in NAMES for _ in range(400)] if together else NAMES * 400
    known = sorted(filter(None, NAMES))
    codes = codes_of(pl.Series(texts, dtype=pl.String))
    assert codes.dtype == np.uint32
    assert codes.tolist() == [0 if text is None else known.index(text) + 1 for text in texts]


@pytest.mark.parametrize("time", [[0, 1, 1, 0, 2, 3], [1, 0, 1, 3, 2, 0], [np.nan, 0, 1, 2, np.nan, 3]])
def test_rows_come_by_code_and_time_the_first_of_equal_ones_first(time):
    codes, time = np.array([2, 1, 2, 1, 2, 1], np.uint32), np.array(time, float)
    order = order_of(codes, time)
    assert order.tolist() == sorted(range(6), key=lambda row: (codes[row], np.isnan(time[row]), time[row], row))


def test_rows_that_are_taken_leave_an_empty_table():
    table = pl.DataFrame({"target": ["a", "b", "c"], "x": [1.0, 2.0, 3.0]})
    assert taken(table, np.array([2, 0])).rows() == [("c", 3.0), ("a", 1.0)]
    assert table.width == 0


@given(st.lists(st.sampled_from(["b", "a", "", "ü", "aa"]), max_size=40), st.integers(1, 60))
def test_texts_are_numbered_as_they_come(texts, times):
    rows = [text for text in texts for _ in range(times)]
    names, number = numbered(pl.Series(rows, dtype=pl.String))
    assert names == list(dict.fromkeys(rows))
    assert [names[k] for k in number] == rows
