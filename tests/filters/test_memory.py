"""Memory of results is used again once nobody holds it, and never before."""

from __future__ import annotations

import gc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jink
from jink.filters import memory

LARGE = (memory.SMALLEST // 8, 2)


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    monkeypatch.setattr(memory, "_kept", [])


def address(array):
    return array.__array_interface__["data"][0]


@pytest.mark.parametrize("shape", [(0,), (3, 2), LARGE])
def test_arrays_are_writable_and_on_a_cache_line(shape):
    array = memory.empty(shape)
    array[...] = 1.0
    assert array.shape == shape and array.dtype == float and (not array.size or address(array) % memory.LINE == 0)
    assert array.flags.c_contiguous and array.flags.writeable


def test_a_block_comes_back_when_its_last_view_is_gone():
    array = memory.empty(LARGE)
    at, view = address(array), array[5:, 1]
    del array
    gc.collect()
    other = memory.empty(LARGE)
    assert address(other) != at  # the view still holds the first
    del view
    assert address(memory.empty(LARGE)) == at


def test_small_or_unlike_blocks_are_not_handed_out():
    array = memory.empty(LARGE)
    del array
    kept = list(memory._kept)
    assert len(kept) == 1
    memory.empty((10,))
    huge = memory.empty((4 * LARGE[0], 2))
    tiny = memory.empty((LARGE[0] // 2, 1))
    assert len(memory._kept) == 1 and memory._kept[0] is kept[0] and huge.size > tiny.size


def test_what_is_kept_is_bounded(monkeypatch):
    monkeypatch.setattr(memory, "MOST", 5 * 8 * LARGE[0] * LARGE[1])
    arrays = [memory.empty(LARGE) for _ in range(9)]
    last = address(arrays[-1])
    while arrays:
        del arrays[0]
    assert 1 <= len(memory._kept) < 9 and sum(b.nbytes for b in memory._kept) <= memory.MOST
    assert address(memory.empty(LARGE)) == last
    monkeypatch.setattr(memory, "MOST", 10)
    memory.empty(LARGE)
    assert sum(b.nbytes for b in memory._kept) <= 5 * 8 * LARGE[0] * LARGE[1]


def test_threads_never_share_a_block():
    def work(k):
        for _ in range(50):
            array = memory.empty(LARGE)
            array[:, 0] = k
            if not (array[:, 0] == k).all():
                return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(4)))


def test_an_estimate_keeps_its_values_while_others_are_made():
    """Large batches: the second call must not write into the first one's arrays; after the first is gone it may."""
    rows = 40_000
    rng = np.random.default_rng(0)
    f = jink.Kalman(jink.ConstantVelocity(acceleration_sd=1.0), jink.Position(sd=10.0))
    t, z = np.tile(np.arange(40.0), rows // 40), rng.normal(size=(rows, 2))
    offsets = np.arange(0, rows + 1, 40)
    first = f.filter(t, z, offsets=offsets)
    x, P, at = first.x.copy(), first.P.copy(), address(first.P)
    second = f.filter(t, z + 5.0, offsets=offsets)
    np.testing.assert_array_equal(first.x, x)
    np.testing.assert_array_equal(first.P, P)
    del first
    third = f.filter(t, z, offsets=offsets)
    assert address(third.P) == at and address(second.P) != at
    np.testing.assert_array_equal(third.x, x)


def test_what_is_kept_can_be_given_back():
    array = memory.empty(LARGE)
    del array
    gc.collect()
    assert memory._kept
    memory.give_back()
    assert not memory._kept
    assert memory.empty(LARGE).shape == LARGE
