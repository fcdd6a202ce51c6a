import base64
import gzip

import numpy as np
import pytest

from jink.report.arrays import ArrayBlock, round_mantissa


def unpack(block, name, dtype):
    data = gzip.decompress(base64.b64decode(block.base64()))
    entry = block.manifest[name]
    width = np.dtype(dtype).itemsize
    part = np.frombuffer(data, "u1", entry["length"] * width, entry["start"])
    return np.ascontiguousarray(part.reshape(width, -1).T).view(dtype).ravel()


def test_arrays_come_back_as_they_went_in():
    block = ArrayBlock()
    single = np.array([1.5, np.nan, -2e-30], np.float32)
    double = np.array([np.pi, 1.6e9])
    block.add("a", single)
    block.add("b", double, "f8")
    block.add("c", np.array([True, False]), "u1")
    block.add("none", np.zeros(0))
    np.testing.assert_array_equal(unpack(block, "a", "<f4"), single)
    np.testing.assert_array_equal(unpack(block, "b", "<f8"), double)
    np.testing.assert_array_equal(unpack(block, "c", "u1"), [1, 0])
    assert unpack(block, "none", "<f4").size == 0


def test_a_name_is_used_once():
    block = ArrayBlock()
    block.add("a", np.zeros(1))
    with pytest.raises(ValueError, match="'a' is already"):
        block.add("a", np.zeros(1))


@pytest.mark.parametrize("bits", [7, 9, 16, 23])
def test_rounding_keeps_the_promised_precision(bits):
    rng = np.random.default_rng(0)
    values = (rng.normal(size=1000) * 10.0 ** rng.integers(-6, 7, 1000)).astype(np.float32)
    rounded = round_mantissa(values, bits)
    assert (np.abs(rounded - values) <= np.abs(values) * 2.0 ** -(bits + 1)).all()


def test_rounding_leaves_missing_and_infinite_values():
    np.testing.assert_array_equal(round_mantissa(np.array([np.nan, np.inf, -np.inf]), 7), [np.nan, np.inf, -np.inf])
