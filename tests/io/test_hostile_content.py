"""Content that is small or odd and costs much: archives that hold gigabytes, thousands of columns, a line of junk."""

from __future__ import annotations

import gzip
import io
import json
import random
import zipfile
import zlib

import polars as pl
import pytest
from polars.testing import assert_frame_equal

from jink.io import packing, unpacking
from jink.io.errors import InputError
from jink.io.files import open_table
from jink.io.formats.json import FEW, JsonText
from jink.io.loading import Reading, load_files
from jink.io.unpacking import zstd_size


@pytest.fixture
def small(monkeypatch):
    """A machine of little memory."""
    monkeypatch.setattr(unpacking, "most_unpacked", lambda: 200_000)
    monkeypatch.setattr("jink.io.files.most_unpacked", lambda: 200_000)


CONTENT = b"target,time,x,y\n" + b"a,1,2,3\n" * 100_000


def zipped(content: bytes) -> bytes:
    handle = io.BytesIO()
    with zipfile.ZipFile(handle, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("inner.csv", content)
    return handle.getvalue()


def in_members(content: bytes) -> bytes:
    return b"".join(gzip.compress(content[k : k + 50_000]) for k in range(0, len(content), 50_000))


PACKED = {"a.csv.gz": gzip.compress, "members.csv.gz": in_members, "a.zip": zipped}


@pytest.mark.parametrize("name", PACKED)
def test_content_that_unpacks_to_too_much_is_one_line(tmp_path, small, name):
    path = tmp_path / name
    path.write_bytes(PACKED[name](CONTENT))
    with pytest.raises(InputError, match="unpacks to more than") as error:
        open_table(path)
    assert "\n" not in str(error.value)
    path.write_bytes(PACKED[name](CONTENT[:160_000]))
    assert open_table(path).names == ["target", "time", "x", "y"]


def test_the_size_of_zstd_is_known_before_it_is_unpacked(tmp_path, small):
    raw = b"\x28\xb5\x2f\xfd\x00\x58"  # no size of its content, a window of 2 MB
    run = (1 << 17 << 3 | 1 << 1).to_bytes(3, "little") + b"a"  # a block that repeats one byte
    last = (1 << 17 << 3 | 1 << 1 | 1).to_bytes(3, "little") + b"a"
    assert zstd_size(raw + run * 9 + last) == 10 << 17
    assert zstd_size(raw + run * 9 + last + raw + last) == 11 << 17
    assert zstd_size(b"") == zstd_size(b"abcdefgh") == 0
    path = tmp_path / "a.csv.zst"
    path.write_bytes(raw + run * 9 + last)
    with pytest.raises(InputError, match="unpacks to more than"):
        open_table(path)


def test_noise_is_no_size_of_zstd():
    rng = random.Random(0)
    for _ in range(2_000):
        zstd_size(b"\x28\xb5\x2f\xfd" + rng.randbytes(rng.randrange(60)))


def test_sixty_thousand_columns():
    """The names are counted once, and not each by each."""
    names = ["target", "time", "x", "y", *(f"n{k}" for k in range(60_000)), "n7"]
    rows = "".join(",".join(["a", str(k), str(200 * k), "0", *["1"] * 60_001]) + "\n" for k in range(3))
    counted = [0]

    class Counting(str):
        def __eq__(self, other: object) -> bool:
            counted[0] += 1
            return str.__eq__(self, other)

        __hash__ = str.__hash__

    from jink.io.formats.csv import CsvText

    table = CsvText("wide.csv", (",".join(names) + "\n" + rows).encode())
    assert len(table.names) == 60_005 and "n7 (2)" in table.names
    assert "n7" in table.notes[-1]
    table._told_apart([Counting(name) for name in names])
    assert counted[0] < 10 * len(names)


def lines(count: int) -> list[str]:
    rng = random.Random(1)
    return [
        json.dumps({"id": f"t{k % 7}", "time": k * 0.5, "x": rng.uniform(-9, 9), "y": k, "ok": k % 2 == 0})
        for k in range(count)
    ]


@pytest.mark.parametrize("junk", ["{broken", "[1, 2]", "7", '{"id": "t1", "time": "soon", "x": 1.0, "y": 2}'])
def test_one_line_of_junk_costs_itself(monkeypatch, junk):
    text = lines(20_000)
    whole = JsonText("f", "\n".join(text).encode())
    wanted, _ = whole.read(["id", "time", "x", "y", "ok"])
    alone = [0]
    real = JsonText._value_by_value

    def counted(self, names, records):
        records = list(records)
        alone[0] += len(records)
        return real(self, names, records)

    monkeypatch.setattr(JsonText, "_value_by_value", counted)
    text[12_345] = junk
    found, refused = JsonText("f", "\n".join(text).encode()).read(["id", "time", "x", "y", "ok"])
    assert alone[0] * len(text[0]) <= 2 * FEW
    others = found.filter(pl.col("row") != 12_345)
    expected = wanted.filter(pl.col("row") != 12_345)
    if junk.startswith('{"id"'):  # then the column is text
        assert found.height == 20_000 and found["time"].dtype == pl.String and refused.height == 0
        others = others.with_columns(pl.col("time", "x").cast(pl.Float64), pl.col("y").cast(pl.Int64))
        others, expected = others.drop("ok"), expected.drop("ok")
    else:
        assert refused["row"].to_list() == [12_345]
    assert_frame_equal(others, expected)


def test_lines_of_junk_everywhere():
    text = lines(3_000)
    for k in range(0, 3_000, 37):
        text[k] = "{" * (k % 5 + 1)
    text[500:500] = ["", "  "]
    found, refused = JsonText("f", "\n".join(text).encode()).read(["id", "x"])
    assert refused["row"].to_list() == list(range(0, 3_000, 37))
    assert sorted(found["row"].to_list() + refused["row"].to_list()) == list(range(3_000))


def test_a_long_line_of_junk():
    text = lines(500)
    text[77] = "{" + "a" * 10 * FEW
    found, refused = JsonText("f", "\n".join(text).encode()).read(["id", "x"])
    assert refused["row"].to_list() == [77] and found.height == 499


def test_packed_text_is_gzip(tmp_path, monkeypatch):
    monkeypatch.setattr(packing, "MEMBER", 1_000)
    path = tmp_path / "t.csv"
    for content in (b"", b"a", CONTENT[:5_555], CONTENT[:100_000]):
        path.write_bytes(content)
        packing.compress(path)
        assert gzip.decompress(path.read_bytes()) == content
    assert [item.name for item in tmp_path.iterdir()] == ["t.csv"]
    assert zlib.decompressobj(wbits=31).decompress(path.read_bytes())[:6] == b"target"


def test_what_was_packed_is_read(tmp_path):
    path = tmp_path / "t.csv.gz"
    path.write_bytes(b"target,time,x,y\n" + b"".join(b"a,%d,%d,0\n" % (k, k) for k in range(50)))
    packing.compress(path)
    assert load_files([path], Reading()).count == 50
