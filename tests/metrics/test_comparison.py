"""Paired comparisons: the formula again, coverage, and what may be called better."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from jink import metrics
from jink.metrics.figure import student_quantile


def pair(rng, runs=40, scans=15, factor=1.1):
    common = rng.standard_normal((runs, scans, 2))
    return factor * common + 0.3 * rng.standard_normal(common.shape), common


def test_difference_of_rmse_by_loops():
    a, b = pair(np.random.default_rng(0))
    a[3, 5], b[6, 2, 0] = np.nan, np.nan
    sa, sb, counts = [], [], []
    for r in range(len(a)):
        use = [k for k in range(2, a.shape[1]) if not (np.isnan(a[r, k]).any() or np.isnan(b[r, k]).any())]
        sa.append(sum(float(c) ** 2 for k in use for c in a[r, k]))
        sb.append(sum(float(c) ** 2 for k in use for c in b[r, k]))
        counts.append(len(use))
    qa, qb, mean_count = sum(sa) / sum(counts), sum(sb) / sum(counts), sum(counts) / len(counts)
    d = [
        (x - qa * n) / mean_count / (2 * math.sqrt(qa)) - (y - qb * n) / mean_count / (2 * math.sqrt(qb))
        for x, y, n in zip(sa, sb, counts, strict=True)
    ]
    mean = sum(d) / len(d)
    se = math.sqrt(sum((v - mean) ** 2 for v in d) / (len(d) - 1) / len(d))
    c = metrics.compare_rmse(a, b, first=2)
    assert c.difference == pytest.approx(math.sqrt(qa) - math.sqrt(qb), rel=1e-12)
    assert c.se == pytest.approx(se, rel=1e-12)
    half = stats.t.ppf(0.975, len(a) - 1) * se
    assert (c.low, c.high) == pytest.approx((c.difference - half, c.difference + half), rel=1e-5)


def test_better_only_where_the_interval_excludes_zero():
    a, b = pair(np.random.default_rng(1))
    assert metrics.compare_rmse(b, a).verdict == "better"
    assert metrics.compare_rmse(a, b).verdict == "worse"
    assert metrics.compare_rmse(a, a).verdict == "undecided"
    assert metrics.compare_rmse(a[:1], b[:1]).verdict == "undecided"


def test_the_interval_covers_what_it_says():
    rng = np.random.default_rng(2)
    truth = math.sqrt(2) * (math.sqrt(1.1**2 + 0.09) - 1)
    covered = 0
    for _ in range(600):
        c = metrics.compare_rmse(*pair(rng, runs=20))
        covered += c.low <= truth <= c.high
    assert covered / 600 == pytest.approx(0.95, abs=0.03)


def test_pairing_is_narrower_than_not_pairing():
    a, b = pair(np.random.default_rng(3))
    unpaired = math.hypot(metrics.rmse(a).se, metrics.rmse(b).se)
    assert metrics.compare_rmse(a, b).se < 0.5 * unpaired


def test_efficiency_and_its_spread():
    rng = np.random.default_rng(6)
    figures = [metrics.efficiency(*pair(rng)) for _ in range(300)]
    a, b = pair(np.random.default_rng(0))
    assert metrics.efficiency(a, b).value == pytest.approx(np.sqrt((a**2).sum() / (b**2).sum()))
    assert np.mean([f.se for f in figures]) == pytest.approx(np.std([f.value for f in figures]), rel=0.15)
    assert metrics.efficiency(a, a) == pytest.approx((1.0, 0.0), abs=1e-12)


def test_means():
    rng = np.random.default_rng(4)
    x = rng.standard_normal((30, 8))
    y = x + 0.1 + 0.01 * rng.standard_normal(x.shape)
    x[2, 3] = np.nan
    c = metrics.compare_means(x, y, lower_is_better=False)
    d = [x[r, k] - y[r, k] for r in range(30) for k in range(8) if not np.isnan(x[r, k])]
    assert c.difference == pytest.approx(sum(d) / len(d))
    assert c.verdict == "worse"
    assert metrics.compare_means(x, y).verdict == "better"


def test_different_runs_cannot_be_paired():
    with pytest.raises(ValueError, match="runs and scans of a"):
        metrics.compare_rmse(np.zeros((3, 4, 2)), np.zeros((4, 4, 2)))


@pytest.mark.parametrize("dof", [4, 9, 30, 999])
def test_student_quantile(dof):
    assert student_quantile(0.975, dof) == pytest.approx(stats.t.ppf(0.975, dof), rel=0.01 if dof < 9 else 5e-4)
