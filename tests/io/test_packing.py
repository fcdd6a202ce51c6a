"""Text to gzip members: every reader gives back what was written."""

from __future__ import annotations

import gzip
import io
import random
import zlib
from typing import IO, cast

import polars as pl
import pytest

from jink._engine import native
from jink.io.packing import MEMBER, maybe_packed

EVERY = bytes(range(256))


def fibonacci(terms: int) -> bytes:
    """Bytes as frequent as Fibonacci's numbers, whose Huffman tree is as deep as there are of them."""
    counts = [1, 1]
    while len(counts) < terms:
        counts.append(counts[-1] + counts[-2])
    return b"".join(bytes([k]) * count for k, count in enumerate(counts))


TEXTS = {
    "nothing": b"",
    "one byte": b"\xff",
    "three bytes": b"abc",
    "one symbol": b"a" * 1001,
    "every byte": EVERY * 9,
    "random": random.Random(1).randbytes(10_007),
    "digits": "\n".join(f"{k * 1.37:.4f},{k / 7}" for k in range(5_000)).encode(),
    "deep": fibonacci(25),
    **{
        f"skewed {rate}": bytes(min(255, int(random.Random(2).expovariate(rate))) for _ in range(4_001))
        for rate in (0.02, 0.3, 2.0)
    },
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_member_is_what_it_was(text: bytes) -> None:
    member = native.huffman_member(text, zlib.crc32(text))
    assert gzip.decompress(member) == text
    unpack = zlib.decompressobj(wbits=31)
    assert unpack.decompress(member) + unpack.flush() == text
    assert unpack.eof and not unpack.unused_data


def test_codes_are_as_short_as_those_of_zlib() -> None:
    text = TEXTS["digits"]
    pack = zlib.compressobj(1, wbits=31, strategy=zlib.Z_HUFFMAN_ONLY)
    assert len(native.huffman_member(text, zlib.crc32(text))) < 1.01 * len(pack.compress(text) + pack.flush())


@pytest.mark.parametrize("kind", ["csv", "jsonl"])
@pytest.mark.parametrize("sizes", [[], [0], [5, MEMBER - 5], [MEMBER + 1, 3, 2 * MEMBER + 7, 1]], ids=str)
def test_writes_of_any_size_are_one_file(kind: str, sizes: list[int]) -> None:
    text = (EVERY * (4 * MEMBER // 256 + 1))[: sum(sizes)]
    handle, at = io.BytesIO(), 0
    with maybe_packed(cast(IO[bytes], handle), True, kind) as out:
        for size in sizes:
            assert out.write(text[at : at + size]) == size
            at += size
    assert gzip.decompress(handle.getvalue()) == text


def test_polars_reads_it() -> None:
    table = pl.DataFrame({"id": ["a", "b"], "x": [1.5, None]})
    handle = io.BytesIO()
    with maybe_packed(cast(IO[bytes], handle), True, "csv") as out:
        table.write_csv(out)
    assert pl.read_csv(handle.getvalue()).equals(table)
