"""NEES, NIS, bands and scores, from their formulas and on draws whose answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from jink import metrics
from jink.metrics import chi_square


def draws(runs=60, scans=9, n=4, seed=0):
    """Errors drawn from their own covariances, of components with very different units."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((runs, scans, n, n)) + 2 * np.eye(n)
    A = A * np.array([500.0, 20.0, 1e-3, 1.0])[:n, None]
    P = A @ A.swapaxes(-1, -2)
    return np.einsum("rkij,rkj->rki", A, rng.standard_normal((runs, scans, n))), P


def test_nees_by_inversion():
    e, P = draws(5, 4)
    P[1, 2] = np.nan
    e[2, 3, 0] = np.nan
    P[3, 1] = 0.0
    P[4, 0, 1, 1] = -1.0
    value = metrics.nees(e, P)
    for r in range(5):
        for k in range(4):
            expected = e[r, k] @ np.linalg.inv(P[r, k]) @ e[r, k] if P[r, k].any() and P[r, k, 1, 1] > 0 else np.nan
            assert value[r, k] == pytest.approx(expected, rel=1e-8, nan_ok=True)
    with pytest.raises(ValueError, match="P: expected"):
        metrics.nees(e, P[..., :3])


def test_consistency_by_loops():
    e, P = draws()
    squares = metrics.nees(e, P)
    squares[:, 0] = np.nan
    squares[4, 3] = np.nan
    c = metrics.consistency(squares, 4, first=1)
    values = [[float(v) for v in run[1:] if not math.isnan(v)] for run in squares]
    everything = [v for run in values for v in run]
    assert c.mean.value == pytest.approx(sum(everything) / 4 / len(everything))
    low, high = stats.chi2.ppf([0.025, 0.975], 4)
    assert c.inside.value == pytest.approx(sum(low <= v <= high for v in everything) / len(everything))
    inside = 0
    for k in range(1, 9):
        scan = [float(v) for v in squares[:, k] if not math.isnan(v)]
        low, high = stats.chi2.ppf([0.025, 0.975], 4 * len(scan)) / len(scan)
        average = sum(scan) / len(scan)
        assert (c.average[k - 1], c.low[k - 1], c.high[k - 1]) == pytest.approx((average, low, high), rel=1e-6)
        inside += low <= average <= high
    assert c.scans_inside == inside / 8


def test_what_is_consistent_lies_inside_and_what_is_not_does_not():
    e, P = draws(300, 40)
    good = metrics.consistency(metrics.nees(e, P), 4)
    assert abs(good.mean.value - 1) < 3 * good.mean.se
    assert abs(good.inside.value - 0.95) < 3 * good.inside.se + 1e-3
    assert good.scans_inside > 0.8
    proud = metrics.consistency(metrics.nees(2 * e, P), 4)
    assert proud.mean.value == pytest.approx(4 * good.mean.value)
    assert proud.scans_inside == 0 and proud.inside.value < 0.6


def test_degrees_of_freedom_of_each_scan():
    rng = np.random.default_rng(2)
    dof = rng.integers(0, 4, (200, 30)).astype(float)
    nis = np.where(dof > 0, rng.chisquare(np.maximum(dof, 1)), np.nan)
    c = metrics.consistency(nis, dof)
    assert abs(c.mean.value - 1) < 3 * c.mean.se
    assert c.mean.value == pytest.approx(np.nansum(nis) / dof.sum())
    assert abs(c.inside.value - 0.95) < 3 * c.inside.se + 1e-3


def test_log_score_is_the_normal_density():
    e, P = draws(6, 5)
    values = metrics.log_density(e, P)
    for r in range(6):
        for k in range(5):
            expected = -0.5 * (
                e[r, k] @ np.linalg.inv(P[r, k]) @ e[r, k] + math.log(np.linalg.det(2 * math.pi * P[r, k]))
            )
            assert values[r, k] == pytest.approx(expected, rel=1e-8)
    assert metrics.log_score(e, P, first=1).value == pytest.approx(values[:, 1:].mean())


def test_prediction_score():
    values = np.random.default_rng(0).standard_normal((5, 6))
    values[:, 0] = np.nan
    counted = np.ones((5, 6), bool)
    counted[2, 3] = False
    expected = [values[r, k] for r in range(5) for k in range(2, 6) if counted[r, k]]
    assert metrics.prediction_score(values, first=2, counted=counted).value == pytest.approx(np.mean(expected))


@pytest.mark.parametrize("dof", [1, 2, 3, 7, 40, 1999, 2000, 5000, 400000])
@pytest.mark.parametrize("p", [0.001, 0.025, 0.5, 0.975, 0.999])
def test_chi_square_quantiles(dof, p):
    assert chi_square.quantile(p, dof) == pytest.approx(stats.chi2.ppf(p, dof), rel=1e-10 if dof < 2000 else 1e-5)


def test_chi_square_refuses_nonsense():
    for p, dof in ((0.0, 2), (1.0, 2), (0.5, 0)):
        with pytest.raises(ValueError, match="probability"):
            chi_square.quantile(p, dof)
