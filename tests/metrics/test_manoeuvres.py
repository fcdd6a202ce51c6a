"""Peaks, settling, delays and false alarms, counted by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from jink import metrics


def truth():
    busy = np.zeros((3, 40), bool)
    busy[0, 10:20] = True
    busy[0, 30:] = True  # never ends
    busy[1, 12:16] = True
    return busy


def test_events():
    busy = truth()
    assert metrics.events(busy, "onset").tolist() == [[0, 10, 20], [0, 30, 40], [1, 12, 16]]
    assert metrics.events(busy, "end").tolist() == [[0, 20, 30], [1, 16, 40]]
    assert metrics.events(busy[2:], "onset").shape == (0, 3)
    with pytest.raises(ValueError, match="kind"):
        metrics.events(busy, "start")  # type: ignore[arg-type]


def test_manoeuvring():
    acceleration = np.zeros((1, 3, 2))
    acceleration[0, 1] = 3.0, 4.0
    assert metrics.manoeuvring(acceleration, 4.9).tolist() == [[False, True, False]]
    assert not metrics.manoeuvring(acceleration, 5.0).any()


def aligned_by_loops(error, busy, kind, before, after):
    """RMSE over events at each offset."""
    total, count = [0.0] * (before + after), [0] * (before + after)
    for r in range(len(busy)):
        changes = [k for k in range(1, busy.shape[1]) if busy[r, k] != busy[r, k - 1]]
        for i, k in enumerate(changes):
            if busy[r, k] != (kind == "onset"):
                continue
            stop = changes[i + 1] if i + 1 < len(changes) else busy.shape[1]
            for j in range(-before, after):
                if 0 <= k + j < stop and not np.isnan(error[r, k + j]).any():
                    total[j + before] += sum(c * c for c in error[r, k + j])
                    count[j + before] += 1
    return [math.sqrt(t / n) if n else math.nan for t, n in zip(total, count, strict=True)]


@pytest.mark.parametrize("kind", ["onset", "end"])
def test_response_by_loops(kind):
    rng = np.random.default_rng(0)
    busy = rng.random((20, 60)) < 0.5
    busy = np.repeat(busy[:, ::6], 6, axis=1)
    error = rng.standard_normal((20, 60, 2))
    error[rng.random((20, 60)) < 0.1] = np.nan
    r = metrics.response(error, busy, kind, before=3, after=15)
    curve = aligned_by_loops(error, busy, kind, 3, 15)
    assert r.over_time.tolist() == pytest.approx(curve, rel=1e-12, nan_ok=True)
    assert r.peak.value == pytest.approx(np.nanmax(curve[3:]))
    assert r.events == len(metrics.events(busy, kind))
    assert r.peak.se > 0


def test_peak_and_settling_of_a_known_response():
    busy = np.zeros((8, 60), bool)
    busy[:, 20:45] = True
    error = np.ones((8, 60, 1))
    error[:, 20:27, 0] = [1, 2, 5, 4, 3, 2, 1.4]
    r = metrics.response(error, busy, "onset", before=5, after=25)
    assert r.peak.value == pytest.approx(5) and r.peak.se == pytest.approx(0, abs=1e-12)
    assert r.level == pytest.approx(1.5)
    assert r.settling.value == 6  # the 2 at offset 5 is the last above 1.5
    assert metrics.response(error, busy, "onset", level=1.0).settling.value == 7
    assert metrics.response(error, busy, "onset", level=0.5).settling.value == math.inf
    assert metrics.response(error, busy, "onset", level=9.0).settling.value == 0
    assert math.isnan(metrics.response(error, np.zeros_like(busy), "onset").peak.value)


def test_detection_by_loops():
    rng = np.random.default_rng(1)
    busy = np.repeat(rng.random((15, 12)) < 0.3, 8, axis=1)
    p = np.clip(0.2 * busy + 0.8 * rng.random(busy.shape), 0, 1)
    p[:, 0] = np.nan
    d = metrics.detection(p, busy, threshold=0.7, grace=4, first=2)
    delays, missed, alarms, quiet = [], 0, 0, 0
    for r in range(15):
        for k in range(96):
            if k and busy[r, k] and not busy[r, k - 1]:
                j = k
                while j < 96 and busy[r, j] and not p[r, j] >= 0.7:
                    j += 1
                if j < 96 and busy[r, j]:
                    delays.append(j - k)
                else:
                    missed += 1
            if k >= 2 and not busy[r, max(0, k - 4) : k + 1].any():
                quiet += 1
                alarms += p[r, k] >= 0.7
    assert d.delay.value == pytest.approx(sum(delays) / len(delays))
    assert d.noticed.value == pytest.approx(len(delays) / (len(delays) + missed))
    assert d.false_alarms.value == pytest.approx(alarms / quiet)
    assert d.delay.se > 0 and d.false_alarms.se > 0


def test_detection_without_onsets_or_of_another_shape():
    d = metrics.detection(np.zeros((2, 30)), np.zeros((2, 30), bool))
    assert math.isnan(d.delay.value) and d.false_alarms.value == 0
    with pytest.raises(ValueError, match="probability"):
        metrics.detection(np.zeros((2, 30)), np.zeros((2, 29), bool))
