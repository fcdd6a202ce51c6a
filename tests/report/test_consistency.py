import numpy as np
import pytest

from jink.report.consistency import BINS, chi2_cdf, chi2_quantile, consistency


@pytest.mark.parametrize("dof", [1, 2, 3, 4, 5, 6, 9, 12])
def test_chi_square_against_scipy(dof):
    stats = pytest.importorskip("scipy.stats")
    for x in (1e-6, 0.1, 0.7, 1.0, 2.5, 7.0, 20.0, 60.0, 900.0):
        assert chi2_cdf(x, dof) == pytest.approx(stats.chi2.cdf(x, dof), rel=1e-10, abs=1e-13)
    for p in (0.025, 0.05, 0.5, 0.95, 0.975):
        assert chi2_quantile(p, dof) == pytest.approx(stats.chi2.ppf(p, dof), rel=1e-10)


def test_quantile_wants_a_probability():
    with pytest.raises(ValueError, match=r"p = 1\.0.*between 0 and 1"):
        chi2_quantile(1.0, 2)


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
