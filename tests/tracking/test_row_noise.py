"""Noise of many rows in less memory is that of each row."""

from __future__ import annotations

import numpy as np
import pytest

from jink.tracking.row_noise import FEWEST, JoinedNoise, Repeated, uniform


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


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("crossed", [False, True])
def test_joined_noise_is_that_of_positions_and_velocities(axes, crossed):
    rng = np.random.default_rng(1)
    position, (xx, yy, zz, xy) = rng.uniform(1.0, 2.0, (9_000, axes, axes)), rng.uniform(1.0, 2.0, (4, 9_000))
    joined = JoinedNoise(position, (xx, yy, zz), xy if crossed else None)
    whole = np.zeros((9_000, 2 * axes, 2 * axes))
    whole[:, :axes, :axes] = position
    whole[:, axes, axes], whole[:, axes + 1, axes + 1] = xx, yy
    if axes == 3:
        whole[:, 5, 5] = zz
    if crossed:
        whole[:, axes, axes + 1] = whole[:, axes + 1, axes] = xy
    for rows in (slice(None), slice(3_990, 8_010), rng.integers(0, 9_000, 50), rng.random(9_000) < 0.5):
        np.testing.assert_array_equal(joined[rows], whole[rows])
    np.testing.assert_array_equal(np.asarray(joined), whole)


@pytest.mark.parametrize("crossed", [False, True])
def test_joined_noise_that_repeats_is_kept_once(crossed):
    count, rng = FEWEST + 5, np.random.default_rng(2)
    changes = np.arange(count) >= np.array([[10], [20], [30], [40]])
    position = np.full((count, 2, 2), 3.0) + changes[0, :, None, None]
    joined = JoinedNoise(position, (*(1.0 + changes[1:3]), rng.random(count)), 0.1 * changes[3] if crossed else None)
    kept = Repeated.of(joined)
    assert isinstance(kept, Repeated) and len(kept.different) == (5 if crossed else 4)
    np.testing.assert_array_equal(kept[:], joined[:])
    assert not uniform(joined)
    assert uniform(JoinedNoise(position[50:], tuple(each[50:] for each in joined.variances), None))
    assert not uniform(JoinedNoise(position[50:], (np.arange(count - 50.0), *joined.variances[1:]), None))
