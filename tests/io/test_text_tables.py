"""Text tables: the same bytes as polars writes, little at a time, and the file's own errors."""

import errno
import io
import json
import math
import struct
from datetime import UTC, date, datetime, time, timedelta
from decimal import Decimal

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polars.testing.parametric import dataframes

from jink._engine import native
from jink.io import text_tables
from jink.io.text_tables import BYTES, ROWS, plain_times, write_csv, write_json_lines

ODD = [
    *(0.0, -0.0, 5e-324, -2.2250738585072014e-308, 1.7976931348623157e308, 1e-7, 0.1, 1 / 3, 1e22, 123456789.125),
    *(math.inf, -math.inf, math.nan, None),
]
TEXTS = ['"', "\\", "\n\r\t", "\x00\x01\x1f\x7f", "naïve", "\U0001f6e9", "\u2028", "", "null", None]
WRITTEN = [  # by the engine
    *(pl.Float32, pl.Float64, pl.Int8, pl.Int16, pl.Int32, pl.Int64, pl.UInt8, pl.UInt16, pl.UInt32, pl.UInt64),
    *(pl.Boolean, pl.String, pl.Date, pl.Null, pl.Categorical, pl.Enum(["one", 'tw"o', "", "three\n, and a long one"])),
    *(pl.Datetime("ms"), pl.Datetime("us", "UTC"), pl.Datetime("ns")),
]
OTHERS = [
    *(pl.Time, pl.Duration, pl.Decimal(10, 2), pl.Datetime("us", "Europe/Paris"), pl.Int128),
    *(pl.List(pl.Int16), pl.Struct({"a": pl.String, "b": pl.Float64})),
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
    plain_times(table).write_ndjson(out)
    return out.getvalue()


def csv_of(table):
    out = Writes()
    write_csv(table, out)
    return out.getvalue()


def written(table):
    return native.TextRows(table, native.TextFormat.csv, False).supported


@given(dataframes(min_cols=1, max_cols=6, max_size=80, allowed_dtypes=WRITTEN))
def test_the_engine_writes_the_bytes_of_polars(table):
    assert written(table)
    assert lines_of(table) == at_once(table)
    assert csv_of(table) == plain_times(table).write_csv().encode()


@given(dataframes(max_cols=4, max_size=12, allowed_dtypes=WRITTEN + OTHERS))
def test_stretches_give_the_bytes_of_one_write(table):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(text_tables, "ROWS", 5)
        patch.setattr(text_tables, "BYTES", 7)
        assert lines_of(table) == at_once(table)
        if not any(kind.is_nested() for kind in table.schema.values()):
            assert csv_of(table) == plain_times(table).write_csv().encode()


@pytest.mark.parametrize("kind", OTHERS, ids=str)
def test_one_column_of_another_kind_leaves_the_table_to_polars(kind):
    table = pl.DataFrame({"a": [1.5, None], "b": pl.Series([None, None], dtype=kind)})
    assert not written(table) and lines_of(table) == at_once(table)


@pytest.mark.parametrize("width", [32, 64])
@given(data=st.data())
def test_numbers_are_as_short_as_numpy_has_them(width, data):
    finite = st.floats(width=width, allow_nan=False, allow_infinity=False)
    numbers = np.array(data.draw(st.lists(finite, min_size=1)), dtype=f"f{width // 8}")
    shown = [json.loads(line, parse_float=str)["a"] for line in lines_of(pl.DataFrame({"a": numbers})).splitlines()]
    assert np.array_equal(np.array(shown, dtype=numbers.dtype), numbers)
    assert [significant(text) for text in shown] == [significant(str(number)) for number in numbers]


def significant(text):
    """The digits of a number, without zeros around them."""
    return text.lstrip("-").partition("e")[0].replace(".", "").strip("0")


def test_every_power_of_two_and_its_neighbours_come_back():
    wide = [math.ldexp(1.0, power) for power in range(-1074, 1024)]
    wide += [math.nextafter(number, to) for number in wide for to in (0.0, math.inf)]
    wide = [number for number in wide if math.isfinite(number)]
    table = pl.DataFrame({"a": wide})
    assert [json.loads(line)["a"] for line in lines_of(table).splitlines()] == wide
    assert lines_of(table) == at_once(table)


def test_numbers_of_every_size_and_of_few_digits():
    draw = np.random.default_rng(5)
    any_bits = draw.integers(0, 2**64, 100_000, dtype=np.uint64)
    usual = np.ldexp(draw.uniform(-1, 1, 100_000), draw.integers(-180, 70, 100_000))
    few = np.round(draw.uniform(-1e6, 1e6, 100_000)) / 10.0 ** draw.integers(0, 12, 100_000)
    borders = [each * (1 + k * 2.0**-52) for each in (1e-38, 2.0**53, 1e-5, 1e16, 1e17) for k in range(-50, 50)]
    with np.errstate(over="ignore", invalid="ignore"):
        wide = np.concatenate([any_bits.view(float), usual, few, borders])
        narrow = np.concatenate([any_bits.view(np.float32), wide.astype(np.float32)])
    for numbers in (wide, narrow):
        table = pl.DataFrame({"a": numbers[np.isfinite(numbers)]})
        assert lines_of(table) == at_once(table)


def test_moments_before_and_after_the_years_of_four_digits():
    days = [-800_000, -719_529, -719_528, -1, 0, 11_016, 2_932_896, 2_932_897, 3_000_000]
    table = pl.DataFrame({"day": pl.Series(days, dtype=pl.Int32).cast(pl.Date)})
    for kind, ticks in ((pl.Datetime("ms"), 10**3), (pl.Datetime("us"), 10**6)):
        moments = pl.Series([day * 86400 * ticks + k for k, day in enumerate(days)]).cast(kind)
        table = table.with_columns(moments.alias(str(ticks)))
    assert written(table) and lines_of(table) == at_once(table)


def test_a_table_of_several_pieces_and_slices_of_it():
    piece = pl.DataFrame(
        {"a": [1, None, 3], "b": ["x", None, "a text that is longer than its view"], "c": [True, False, None]}
    )
    piece = piece.with_columns(d=pl.col("b").cast(pl.Categorical))
    table = pl.concat([piece] * 30, rechunk=False)
    assert table.n_chunks() == 30
    for part in (table, table.slice(1, 50), table.slice(35, 1), table[::2], table.clear()):
        assert lines_of(part) == at_once(part) and csv_of(part) == plain_times(part).write_csv().encode()


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


def test_names_with_a_nul_are_written_as_well():
    flat = pl.DataFrame({"a\0b": [1, None], "c": pl.Series(["d\0e", None], dtype=pl.Enum(["d\0e"]))})
    nested = flat.select(pl.struct(pl.all()).alias("f"))
    for table in (flat, nested, flat.select("c")):
        assert lines_of(table) == at_once(table)
    assert csv_of(flat) == flat.write_csv().encode()


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
