"""Text tables in small writes: the same bytes as polars writes at once, and the file's own errors."""

import errno
import io
import json
import math
import struct
from datetime import UTC, date, datetime, time, timedelta
from decimal import Decimal

import polars as pl
import pytest
from hypothesis import given
from jink.io.small_writes import BYTES, ROWS, write_csv, write_json_lines
from polars.testing.parametric import dataframes

from jink.io import small_writes

ODD = [
    *(0.0, -0.0, 5e-324, -2.2250738585072014e-308, 1.7976931348623157e308, 1e-7, 0.1, 1 / 3, 1e22, 123456789.125),
    *(math.inf, -math.inf, math.nan, None),
]
TEXTS = ['"', "\\", "\n\r\t", "\x00\x01\x1f\x7f", "naïve", "\U0001f6e9", "\u2028", "", "null", None]
KINDS = [
    *(pl.Float32, pl.Float64, pl.Int8, pl.UInt64, pl.Boolean, pl.String, pl.Date, pl.Time, pl.Null),
    *(pl.Datetime, pl.Duration, pl.Categorical, pl.List(pl.Int16), pl.Struct({"a": pl.String, "b": pl.Float64})),
]


class Writes(io.BytesIO):
    """A file in memory that keeps the size of each write."""

    def __init__(self):
        super().__init__()
        self.sizes = []

    def write(self, text):
        self.sizes.append(len(text))
        return super().write(text)


def lines_of(table):
    out = Writes()
    write_json_lines(table, out)
    return out.getvalue()


def at_once(table):
    out = io.BytesIO()
    table.write_ndjson(out)
    return out.getvalue()


@given(dataframes(max_cols=4, max_size=12, allowed_dtypes=KINDS))
def test_stretches_give_the_bytes_of_one_write(table):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(small_writes, "ROWS", 5)
        patch.setattr(small_writes, "BYTES", 7)
        assert lines_of(table) == at_once(table)


def test_numbers_come_back_bit_for_bit_and_those_that_json_lacks_are_null():
    table = pl.DataFrame({"wide": ODD, "narrow": pl.Series(ODD, dtype=pl.Float32, strict=False)})
    rows = [json.loads(line) for line in lines_of(table).splitlines()]
    for number, row in zip(ODD, rows, strict=True):
        if number is None or not math.isfinite(number):
            assert row == {"wide": None, "narrow": None}
        else:
            assert struct.pack("d", row["wide"]) == struct.pack("d", number)
    narrow = [row["narrow"] for row in rows]
    for number, back in zip(table["narrow"].to_list(), narrow, strict=True):
        if number is None or not math.isfinite(number):
            assert back is None
        else:
            assert struct.pack("f", back) == struct.pack("f", number)


def test_any_text_and_any_key_comes_back():
    table = pl.DataFrame({'k"\\\n': TEXTS, "é": TEXTS})
    rows = [json.loads(line) for line in lines_of(table).splitlines()]
    assert rows == table.to_dicts() and [list(row) for row in rows] == [table.columns] * len(TEXTS)


def test_values_of_other_kinds():
    row = {
        "flag": True,
        "large": 2**64 - 1,
        "day": date(2024, 2, 29),
        "hour": time(1, 2, 3),
        "moment": datetime(2024, 1, 1, tzinfo=UTC),
        "lag": timedelta(seconds=1.5),
        "exact": Decimal("1.50"),
        "list": [1, None],
        "nested": {"a": "x", "b": None},
        "nothing": None,
    }
    table = pl.DataFrame([row])
    assert lines_of(table) == at_once(table)
    back = json.loads(lines_of(table))
    same = ("flag", "large", "list", "nested", "nothing")
    assert list(back) == list(row) and {name: back[name] for name in same} == {name: row[name] for name in same}


@pytest.mark.parametrize("table", [pl.DataFrame(), pl.DataFrame({"a": []}), pl.DataFrame(schema={"a": pl.String})])
def test_no_rows_are_no_lines(table):
    assert lines_of(table) == b"" == at_once(table)


def test_no_write_is_large_and_pandas_and_polars_read_the_lines():
    pandas = pytest.importorskip("pandas")
    table = pl.DataFrame({"row": range(2 * ROWS + 3)}).with_columns(text=pl.lit("x" * 50), half=pl.col("row") / 2)
    out = Writes()
    write_json_lines(table, out)
    assert max(out.sizes) == BYTES and len(out.sizes) > 3
    assert pl.read_ndjson(out.getvalue()).equals(table)
    assert pandas.read_json(io.BytesIO(out.getvalue()), lines=True)["half"].tolist() == table["half"].to_list()
    out = Writes()
    write_csv(table, out)
    write_csv(table, out, header=False)
    assert max(out.sizes) == BYTES
    assert pl.read_csv(out.getvalue()).equals(pl.concat([table, table]))


@pytest.mark.parametrize("write", [write_csv, write_json_lines])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EPIPE])
def test_the_error_of_the_file_is_raised_as_it_is(write, number):
    class Full(io.BytesIO):
        def write(self, text):
            raise OSError(number, "no more")

    with pytest.raises(OSError, match="no more") as raised:
        write(pl.DataFrame({"a": [1]}), Full())
    assert raised.value.errno == number
