"""Noise of many rows in less memory is that of each row."""

from __future__ import annotations

import numpy as np
import pytest

from jink import IMM, ConstantVelocity, CoordinatedTurn, Kalman, Position
from jink.filters.row_noise import BLOCK, FEWEST, Repeated, RowNoise

ROWS = 2 * BLOCK + 1_000
ASKED = (slice(None), slice(BLOCK - 10, 2 * BLOCK + 10), np.arange(50) * 7, np.arange(ROWS) % 3 == 0)


def symmetric(size, rows, seed):
    values = np.random.default_rng(seed).uniform(1.0, 2.0, (rows, size, size))
    return values + np.swapaxes(values, 1, 2)


@pytest.mark.parametrize("size", [1, 2, 3])
def test_covariances_come_back_as_they_were_given(size):
    R = symmetric(size, ROWS, 0)
    noise = RowNoise.of_covariances(R)
    assert len(noise) == ROWS
    for rows in ASKED:
        np.testing.assert_array_equal(noise[rows], R[rows])
        np.testing.assert_array_equal(noise.some(rows)[:], R[rows])
    np.testing.assert_array_equal(np.asarray(noise), R)
    np.testing.assert_array_equal(noise.first(1)[:], R[:, :1, :1])


def test_variances_come_back_as_variances():
    variances = np.random.default_rng(1).uniform(1.0, 2.0, (ROWS, 3))
    noise = RowNoise.of_variances(variances.T)
    for rows in ASKED:
        np.testing.assert_array_equal(noise[rows], variances[rows])
    np.testing.assert_array_equal(noise.beside([variances[:, 0]])[:], variances[:, [0, 1, 2, 0]])


@pytest.mark.parametrize("axes", [2, 3])
def test_further_components_are_independent(axes):
    R, more = symmetric(axes, ROWS, 2), np.random.default_rng(3).uniform(1.0, 2.0, (axes, ROWS))
    whole = np.zeros((ROWS, 2 * axes, 2 * axes))
    whole[:, :axes, :axes] = R
    for k in range(axes):
        whole[:, axes + k, axes + k] = more[k]
    noise = RowNoise.of_covariances(R).beside(more)
    for rows in ASKED:
        np.testing.assert_array_equal(noise[rows], whole[rows])
    np.testing.assert_array_equal(noise.first(axes)[:], R)


def test_some_rows_may_have_other_noise():
    R, S = symmetric(2, 100, 4), symmetric(2, 100, 5)
    S[:, 0, 1] = S[:, 1, 0] = 0.0
    which = np.arange(100) % 2 == 0
    other = RowNoise(2, {(0, 0): S[:, 0, 0], (1, 1): S[:, 1, 1]})
    expected = np.where(which[:, None, None], S, R)
    np.testing.assert_array_equal(RowNoise.of_covariances(R).where(which, other)[:], expected)
    np.testing.assert_array_equal(other.where(~which, RowNoise.of_covariances(R))[:], expected)


def test_rows_that_are_taken_out_keep_their_values():
    noise = RowNoise.of_variances([np.ones(10)])
    some = noise.some(slice(5))
    noise.variance(0)[:] = 2.0
    np.testing.assert_array_equal(some[:], np.ones((5, 1)))


@pytest.mark.parametrize("full", [False, True])
def test_noise_that_repeats_is_kept_once(full):
    count = FEWEST + 5
    different = np.random.default_rng(6).uniform(1.0, 2.0, (6, 3))
    values = np.repeat(different[[0, 1, 0, 2, 3, 4]], FEWEST // 4, axis=0)[:count].T
    entries = {(0, 0): values[0], (1, 1): values[1], (0, 1): values[2]} if full else {(0, 0): values[0]}
    noise = RowNoise(2 if full else 1, entries, full)
    kept = Repeated.of(noise)
    assert isinstance(kept, Repeated) and len(kept.different) == 5
    for rows in (slice(None), slice(FEWEST // 4 - 3, FEWEST // 4 + 3), np.arange(0, count, 997)):
        np.testing.assert_array_equal(kept[rows], noise[rows])


def test_few_rows_and_rows_that_all_differ_are_not_put_away():
    few = RowNoise.of_variances([np.ones(FEWEST - 1)])
    differ = RowNoise.of_variances(np.random.default_rng(7).uniform(1.0, 2.0, (2, FEWEST)))
    assert [Repeated.of(each) for each in (few, differ, None)] == [None] * 3


def test_noise_is_uniform_where_no_entry_differs():
    same, late = np.ones(5_000), np.ones(5_000)
    late[-1] = 2.0
    assert RowNoise(2, {(0, 0): same, (1, 1): same}).uniform
    assert not RowNoise(2, {(0, 0): same, (0, 1): late, (1, 1): same}).uniform


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("verb", ["filter", "smooth"])
def test_a_filter_takes_the_columns_of_noise_as_it_takes_matrices(verb, full):
    rng = np.random.default_rng(8)
    z = rng.normal(0.0, 30.0, (770, 2))
    z[rng.uniform(size=z.shape) < 0.1] = np.nan
    R = symmetric(2, len(z), 9) + 5.0 * np.eye(2)
    noise = RowNoise.of_covariances(R) if full else RowNoise.of_variances(R[:, [0, 1], [0, 1]].T)
    turn = CoordinatedTurn(acceleration_psd=1.0, turn_rate_psd=1e-5)
    imm = IMM([ConstantVelocity(acceleration_psd=1.0), turn], Position(sd=1.0), transition=0.95)
    offsets = np.cumsum([0, 70, 30, 200, 1, 9, 390, 70])
    time, given = np.arange(770.0), R if full else R[:, [0, 1], [0, 1]]
    one, other = (getattr(imm, verb)(time, z, offsets=offsets, covariance=each) for each in (given, noise))
    for name, values in one.results.items():
        np.testing.assert_array_equal(other.results[name], values)
    # the rows are asked for again where estimates at other times are
    np.testing.assert_array_equal(other.at([3.5, 75.0]).x, one.at([3.5, 75.0]).x)


@pytest.mark.parametrize("size", [1, 2, 6])
def test_the_row_whose_noise_is_wrong_is_named(size):
    R = np.tile(np.eye(size), (101, 1, 1))
    noise = RowNoise.of_covariances(R)
    assert noise.first_indefinite() == -1
    for row, wrong in ((0, -1.0), (63, np.nan), (100, 0.0)):
        bad = noise.some(slice(None))
        bad.entries[size - 1, size - 1][row] = wrong
        assert bad.first_indefinite() == row
    if size > 1:
        noise.entries[0, 1][97] = 1.5
        assert noise.first_indefinite() == 97


def test_noise_of_other_rows_or_components_is_refused():
    kalman = Kalman(ConstantVelocity(acceleration_psd=1.0), Position(sd=1.0))
    for count, size in ((9, 2), (10, 3)):
        with pytest.raises(ValueError, match=f"covariance: expected 10 rows of 2, got {count} of {size}"):
            kalman.filter(np.arange(10.0), np.zeros((10, 2)), covariance=RowNoise.of_variances(np.ones((size, count))))
    bad = RowNoise.of_covariances(np.tile(np.eye(2), (10, 1, 1)))
    bad.entries[0, 1][4] = 2.0
    with pytest.raises(ValueError, match="covariance: row 4 is not symmetric and positive definite"):
        kalman.filter(np.arange(10.0), np.zeros((10, 2)), covariance=bad)
