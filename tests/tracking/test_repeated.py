"""Noise of many rows, each different one kept once, is that of each row."""

from __future__ import annotations

import numpy as np
import pytest

from jink.tracking.repeated import FEWEST, Repeated


@pytest.mark.parametrize("shape", [(3,), (3, 3)])
def test_rows_have_the_covariances_that_they_had(shape):
    rng = np.random.default_rng(0)
    different = rng.uniform(1.0, 2.0, (5, *shape))
    whole = np.repeat(different[[0, 1, 0, 2, 3, 4]], FEWEST // 4, axis=0)
    kept = Repeated.of(whole)
    assert isinstance(kept, Repeated) and len(kept.different) == 6
    for rows in (slice(None), slice(FEWEST // 4 - 3, FEWEST // 4 + 3), rng.integers(0, len(whole), 50)):
        np.testing.assert_array_equal(kept[rows], whole[rows])


def test_few_rows_and_rows_that_all_differ_are_not_put_away():
    differ = np.random.default_rng(0).uniform(1.0, 2.0, (FEWEST, 2))
    assert [Repeated.of(each) for each in (np.ones((FEWEST - 1, 3)), differ, None)] == [None] * 3
