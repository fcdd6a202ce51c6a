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


@pytest.mark.parametrize(
    ("name", "sd", "step", "tracks", "scans"),
    [
        ("vsmm-ag/polar-height/11/3", 1e-3, 1e4, 64, 89),  # the state is thin along one row after the other
        ("vsmm-ag/polar-converted/2/3", 1e-6, 1.0, 64, 89),  # correlated noise, of a state far less certain
        ("vsmm-ds/polar-converted/31/3", 1e6, 1e-2, 64, 89),
        ("imm/polar-rate-2/28/3", 1e3, 1e3, 64, 89),  # a row that is believed with hindsight alone keeps its track
        ("mm/polar-2/0/17", 1e-6, 1e-4, 64, 89),  # a mode's probability below the range of numbers
        ("imm-cv-ct/bearing/36/17", 25.0, 1.0, 1, 100_000),  # nothing holds the range
    ],
)
def test_what_was_found_by_other_seeds(name, sd, step, tracks, scans):
    filter, sensor, number, seed = name.split("/")
    case = torture.Case(filter, sensor, (), (), 89, 0, int(seed))
    found = torture.once(case, int(number), sd, step, tracks, scans)
    assert found.counts["updates"] > 5_000 and not found.offenders


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


@pytest.mark.parametrize(
    ("sensor", "number", "sd", "scans"),
    [("position-velocity-2", "0/1", 1e-6, 6), ("position-velocity-3", "18/3", 25.0, 89)],
)
def test_tracks_together_are_what_each_is_alone(sensor, number, sd, scans):
    """Tracks share an engine, whose slots without a mode hold what lay there before, of other tracks."""
    name, step, tracks = f"vsmm-ds/{sensor}/{number}", 1e-4, torture.TRACKS
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    filter = torture.made(torture.Case("vsmm-ds", sensor, (sd,), (step,), scans, 0, 1), sd, step, rng)
    rows = torture.hostile(filter.sensors[0], sd, step, tracks, scans, rng)
    time, z = rows.time.reshape(tracks, -1), rows.z.reshape(tracks, -1, rows.z.shape[-1])
    together, alone = filter.start(tracks), [filter.start(1) for _ in range(tracks)]
    for scan in range(6):
        every = together.update(time[:, scan], z[:, scan])
        each = [one.update(time[t, scan : scan + 1], z[t, scan][None]) for t, one in enumerate(alone)]
        for field in ("x", "mode_probability", "log_likelihood"):
            apart = np.concatenate([getattr(one, field) for one in each])
            assert np.array_equal(getattr(every, field), apart, equal_nan=True)
