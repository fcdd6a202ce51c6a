"""Every registered filter on every sensor with hostile but legal numbers: ``python -m benchmarks.torture``, small."""

from __future__ import annotations

import sys
import zlib
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import border, torture, torture_checks
from jink import Status
from jink.catalogue.registry import FILTERS

NONE = int(Status.none)
UPDATED = int(Status.updated)
PREDICTED = int(Status.predicted)


@pytest.mark.parametrize("filter", FILTERS)
def test_nothing_is_lost_or_beyond_numbers(filter):
    total, offenders = Counter(), []
    for sensor in torture.SENSORS:
        found = torture.run(torture.Case(filter, sensor, (1e-6, 1e6), (1e-4, 10.0), 6, 0, 1))
        total.update(found.counts)
        offenders += found.offenders
    assert total["updates"] > 20_000 and not offenders


def test_the_checks_count_what_is_wrong():
    good = np.array([[2.0, 1.0], [1.0, 2.0]])
    assert torture_checks.indefinite(np.stack([good, good * 1e-300, good * 1e300])) == 0
    assert (
        torture_checks.indefinite(np.stack([good, [[1.0, 1.0 + 1e-9], [1.0 + 1e-9, 1.0]], [[1, 0.5], [0.4, 1]]])) == 2
    )
    status, time = np.array([[NONE, UPDATED, NONE, PREDICTED]]), np.array([[0.0, 1.0, 9.0, 10.0]])
    assert torture_checks.lost(status, time, None) == 1
    assert torture_checks.lost(status, time, 5.0) == 0
    assert torture_checks.lost(status, time, 8.0) == 1


@pytest.mark.parametrize("what", border.WHAT)
def test_mutations_at_the_border_end_in_an_error_or_an_answer(what):
    counts = border.run(what, 7, 3_000)
    assert sum(counts.values()) == 3_000
    assert counts["refused"] > 1_000 and counts["taken"] > 100
    assert counts["other"] == counts["crashes"] == 0


def test_rows_that_are_gated_keep_nothing_of_other_tracks():
    """Tracks that share an engine come out as each would alone; slots without a mode held what lay there before."""
    case = torture.Case("vsmm-ds", "position-velocity-2", (1e-6,), (1e-4,), 6, 0, 1)
    rng = np.random.default_rng(zlib.crc32(b"vsmm-ds/position-velocity-2/0/1"))
    filter = torture.made(case, 1e-6, 1e-4, rng)
    tracks = torture.TRACKS
    rows = torture.hostile(filter.sensors[0], 1e-6, 1e-4, tracks, case.scans, rng)
    time, z = rows.time.reshape(tracks, -1), rows.z.reshape(tracks, -1, rows.z.shape[-1])
    together, alone = filter.start(tracks), [filter.start(1) for _ in range(tracks)]
    gated = 0
    for scan in range(time.shape[1]):
        all_of_them = together.update(time[:, scan], z[:, scan])
        each = [one.update(time[t, scan : scan + 1], z[t, scan][None]) for t, one in enumerate(alone)]
        assert np.array_equal(all_of_them.x, np.concatenate([one.x for one in each]), equal_nan=True)
        gated += int((np.asarray(all_of_them.status) == Status.gated).sum())
    assert gated > 50
