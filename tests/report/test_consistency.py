import numpy as np
import pytest

from jink.report.consistency import BINS, consistency


def test_true_chi_square_is_consistent():
    rng = np.random.default_rng(3)
    dof = rng.integers(1, 4, 60_000)
    nis = rng.chisquare(dof)
    target = np.repeat([0, 1, 2], 20_000)
    check = consistency(target, 3, nis, dof.astype(float), np.ones(60_000, bool))
    assert check.compared.tolist() == [20_000] * 3
    assert np.allclose(check.inside / check.compared, 0.95, atol=0.006)
    assert np.allclose(check.histogram, 60_000 / BINS, rtol=0.08)
    assert check.mean_ratio == pytest.approx(1.0, abs=0.02)
    assert (check.inside + check.below + check.above == check.compared).all()


def test_only_accepted_rows_with_a_number_count():
    nis = np.array([1.0, np.nan, 1.0, 1e9, 1.0])
    dof = np.array([2.0, 2.0, np.nan, 2.0, 0.0])
    check = consistency(np.zeros(5, int), 2, nis, dof, np.array([True, True, True, False, True]))
    assert check.compared.tolist() == [1, 0] and check.inside.tolist() == [1, 0]


def test_nothing_to_compare():
    check = consistency(np.zeros(2, int), 1, np.full(2, np.nan), np.full(2, np.nan), np.ones(2, bool))
    assert check.compared.tolist() == [0] and np.isnan(check.mean_ratio) and check.bands == {}
