"""Files of every format with bytes changed, cut, or in another place: every row accounted for, or refused in words."""

from __future__ import annotations

import time

import numpy as np
import pytest
from formats_written import everything

import jink
from jink.io.errors import InputError
from jink.io.files import open_tables
from jink.io.loading import Reading, load_files

CONTENTS = everything()
EACH = 70  # 2,310 files in all


def damaged(content: bytes, rng: np.random.Generator, number: int) -> bytes:
    """One to twelve pieces of text or of any bytes in place of others; every fourth file is cut."""
    out = bytearray(content)
    printable = number % 3 > 0
    for _ in range(rng.integers(1, 12)):
        place, count = int(rng.integers(len(out))), int(rng.integers(0, 4))
        low, high = (32, 127) if printable else (0, 256)
        out[place : place + int(rng.integers(0, 4))] = rng.integers(low, high, count).astype("u1").tobytes()
    if number % 4 == 0:
        del out[int(rng.integers(len(out))) :]
    return bytes(out)


@pytest.mark.parametrize("name", CONTENTS)
def test_damaged_files_are_read_in_part_or_refused_in_words(tmp_path, name):
    rng, read = np.random.default_rng(list(CONTENTS).index(name)), 0
    for number in range(EACH):
        path = tmp_path / f"{number}.dat"
        path.write_bytes(damaged(CONTENTS[name], rng, number))
        began = time.monotonic()
        try:
            count = sum(frame.height for table in open_tables(path) for frame in table.read(table.names))
            loaded = load_files([path], Reading())
            measured = loaded.measurements
            assert loaded.count == count == measured.rows.height + sum(frame.height for frame in measured.rejected)
            read += 1
            if number % 5 == 0:
                tracks, rejected, _ = jink.track(path, details=True)
                assert tracks.height + rejected.height == count
        except InputError as error:
            assert len(str(error)) > 20
        assert time.monotonic() - began < 20.0
    assert read or name.startswith(("zip", "gzip", "Parquet", "Arrow"))


def test_there_are_two_thousand_of_them():
    assert EACH * len(CONTENTS) >= 2_000
