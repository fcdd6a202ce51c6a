"""Every error figure again, from its formula, in loops."""

from __future__ import annotations

import math

import numpy as np
import pytest

from jink import metrics


def errors(seed=0, runs=7, scans=11, n=2, missing=0.1):
    rng = np.random.default_rng(seed)
    e = rng.standard_normal((runs, scans, n)) * (1 + rng.random((runs, 1, 1)))
    e[rng.random((runs, scans)) < missing] = np.nan
    e[:, 0] = np.nan
    e[2, 4, 0] = np.nan  # one component missing: no error
    return e


def per_run(e, value, first=0):
    """Each run's list of value(error vector) over its scans that have one."""
    return [[value(v) for v in run[first:] if not np.isnan(v).any()] for run in e]


def ratio_and_se(lists):
    """Mean of all values and its delta-method standard error over runs, by loops."""
    values = [v for run in lists for v in run]
    q = sum(values) / len(values)
    mean_count = len(values) / len(lists)
    influence = [(sum(run) - q * len(run)) / mean_count for run in lists]
    mean = sum(influence) / len(influence)
    variance = sum((d - mean) ** 2 for d in influence) / (len(influence) - 1)
    return q, math.sqrt(variance / len(influence))


@pytest.mark.parametrize("first", [0, 3])
def test_rmse(first):
    e = errors()
    q, se = ratio_and_se(per_run(e, lambda v: sum(c * c for c in v), first))
    figure = metrics.rmse(e, first=first)
    assert figure.value == pytest.approx(math.sqrt(q), rel=1e-12)
    assert figure.se == pytest.approx(se / (2 * math.sqrt(q)), rel=1e-12)


def test_rmse_over_time():
    e = errors()
    value, se = metrics.rmse_over_time(e)
    assert np.isnan(value[0])
    for k in range(1, e.shape[1]):
        squares = [sum(c * c for c in v) for v in e[:, k] if not np.isnan(v).any()]
        mean = sum(squares) / len(squares)
        sd = math.sqrt(sum((s - mean) ** 2 for s in squares) / (len(squares) - 1))
        assert value[k] == pytest.approx(math.sqrt(mean), rel=1e-12)
        assert se[k] == pytest.approx(sd / math.sqrt(len(squares)) / (2 * math.sqrt(mean)), rel=1e-12)


def test_mean_euclidean():
    e = errors()
    expected = ratio_and_se(per_run(e, lambda v: math.sqrt(sum(c * c for c in v))))
    assert metrics.mean_euclidean(e) == pytest.approx(expected, rel=1e-12)


def test_quantile_and_trimmed_rmse():
    e = errors(runs=30)
    lengths = sorted(v for run in per_run(e, lambda v: math.sqrt(sum(c * c for c in v))) for v in run)
    middle = len(lengths) // 2
    median = lengths[middle] if len(lengths) % 2 else None
    squares = [v * v for v in lengths]
    if median is None:  # the quantile of the squares, as the figure takes it
        median = math.sqrt((squares[middle - 1] + squares[middle]) / 2)
    assert metrics.quantile(e, 0.5).value == pytest.approx(median, rel=1e-12)
    kept = squares[: len(squares) - int(0.1 * len(squares))]
    assert metrics.trimmed_rmse(e, share=0.1).value == pytest.approx(math.sqrt(sum(kept) / len(kept)), rel=1e-12)
    with pytest.raises(ValueError, match="share"):
        metrics.trimmed_rmse(e, share=1.0)


def test_jackknife_standard_error_of_a_quantile():
    rng = np.random.default_rng(4)
    draws = [metrics.quantile(rng.standard_normal((100, 5, 2)), 0.95) for _ in range(200)]
    spread = np.std([d.value for d in draws])
    assert np.sqrt(np.mean([d.se**2 for d in draws])) == pytest.approx(spread, rel=0.3)


def test_measured_velocity():
    z = np.random.default_rng(1).standard_normal((3, 6, 2))
    z[1, 2, 0] = np.nan
    time = np.array([0, 1, 3, 3.5, 7, 8.0])
    velocity = metrics.measured_velocity(z, time)
    for r in range(3):
        for a in range(2):
            assert np.isnan(velocity[r, 0, a])
            for k in range(1, 6):
                expected = (z[r, k, a] - z[r, k - 1, a]) / (time[k] - time[k - 1])
                assert velocity[r, k, a] == pytest.approx(expected, nan_ok=True)


def zeta(e, n, first):
    scans = []
    for k in range(first, e.shape[1]):
        a = b = 0.0
        for r in range(len(e)):
            if not (np.isnan(e[r, k]).any() or np.isnan(n[r, k]).any()):
                a += sum(c * c for c in e[r, k])
                b += sum(c * c for c in n[r, k])
        scans.append(math.sqrt(a / b))
    return sum(scans) / len(scans)


def test_normalised_error():
    e, n = errors(1), errors(2, missing=0.2)
    figure = metrics.normalised_error(e, n, first=2)
    assert figure.value == pytest.approx(zeta(e, n, 2), rel=1e-12)
    with pytest.raises(ValueError, match="measurement_error"):
        metrics.normalised_error(e, n[:, :-1])


def test_normalised_error_knows_its_spread():
    rng = np.random.default_rng(3)
    figures = [
        metrics.normalised_error(
            0.5 * rng.standard_normal((50, 1, 2)) + rng.standard_normal((50, 20, 2)),
            rng.standard_normal((50, 20, 2)),
        )
        for _ in range(300)
    ]
    assert np.mean([f.se for f in figures]) == pytest.approx(np.std([f.value for f in figures]), rel=0.15)


def test_lost():
    e = np.zeros((4, 12, 2))
    e[0, 3:8, 0] = 11.0  # five scans in a row
    e[1, 3:7, 1] = 11.0  # four
    e[2, ::2, 0] = 99.0  # never two in a row
    e[3, 6:] = np.nan  # no estimate any more
    e[3, :2] = np.nan  # not yet started
    figure = metrics.lost(e, 10.0, scans=5)
    assert figure.value == 0.5
    assert figure.se == pytest.approx(math.sqrt(0.25 / 4))
    assert metrics.lost(e, 10.0, scans=4).value == 0.75
    with pytest.raises(ValueError, match="limit"):
        metrics.lost(e, 0.0)


def test_one_run_has_no_standard_error():
    e = errors(runs=7)[:1]
    assert math.isnan(metrics.rmse(e).se)
    assert math.isfinite(metrics.rmse(e).value)
    assert math.isnan(metrics.rmse(np.full((3, 4, 2), np.nan)).value)


def test_shapes_are_checked():
    with pytest.raises(ValueError, match="runs, scans, n"):
        metrics.rmse(np.zeros((3, 4)))
    with pytest.raises(ValueError, match="updates"):
        metrics.microseconds_per_update(lambda: None, 0)


def test_microseconds_per_update():
    calls = []
    figure = metrics.microseconds_per_update(lambda: calls.append(1), 10, repetitions=4)
    assert len(calls) == 5 and 0 <= figure.value < 1e4
