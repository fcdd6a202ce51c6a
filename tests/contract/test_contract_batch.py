"""The contract's clauses about how rows are run: batches, threads, neighbours, live use, files."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.situations import flight
from subjects import RESULTS, assert_same, build, claims, fleet, scene

import jink


@claims("batch")
def test_batch_is_a_loop_and_threads_change_nothing(name):
    """Bit for bit: alone, in a batch, in any order, with any number of threads."""
    t, z, offsets, tracks = fleet()
    f = build(name)
    together = f.filter(t, z, offsets=offsets, threads=1)
    for b, (tb, zb) in enumerate(tracks):
        alone = f.filter(tb, zb)
        assert_same(alone, together, slice(offsets[b], offsets[b + 1]))
        assert alone.log_likelihood == together.log_likelihood[b]
    for threads in (2, 3, None):
        assert_same(f.filter(t, z, offsets=offsets, threads=threads), together)
    order = np.random.default_rng(4).permutation(len(tracks))
    shuffled = [tracks[i] for i in order]
    lengths = [len(a) for a, _ in shuffled]
    again = f.filter(
        np.concatenate([a for a, _ in shuffled]),
        np.concatenate([b for _, b in shuffled]),
        offsets=np.r_[0, np.cumsum(lengths)],
    )
    assert_array_equal(again.log_likelihood, together.log_likelihood[order])


@claims("batch")
def test_single_covariances_are_those_of_P(name):
    """Bit for bit, in the order that was asked for, filtered and smoothed."""
    t, z, offsets, _ = fleet()
    f = build(name)
    pairs = [("px", "px"), (f.components[-1], f.components[-1]), ("px", "vx"), ("vx", "px")]
    names = [f"P[{first},{second}]" for first, second in pairs]
    for verb in (f.filter, *([] if f.not_smoothed else [f.smooth])):
        whole, alone = (verb(t, z, offsets=offsets, outputs=["status", *which]) for which in (["P"], names))
        assert "P" not in alone.results
        for (first, second), one in zip(pairs, names, strict=True):
            i, j = f.components.index(first), f.components.index(second)
            assert_array_equal(alone.results[one], whole.P[:, i, j])
            assert_array_equal(alone.covariance(second, first), whole.covariance(first, second))
        assert_array_equal(alone.sd("px"), whole.sd("px"))
        frame = alone.to_frame()
        assert [name for name in frame.columns if name.endswith("_sd")] == [f"{f.components[k]}_sd" for k in (0, -1)]


LEVEL_RUN = """
import sys
sys.path[:0] = [sys.argv[1], sys.argv[1] + "/support"]
import numpy as np
from subjects import SUBJECTS, build, fleet

t, z, offsets, _ = fleet()
out = {}
for name in SUBJECTS:
    e = build(name).filter(t, z, offsets=offsets)
    out |= {f"{name}/{part}": getattr(e, part) for part in ("x", "P", "mode_probability", "status")}
np.savez(sys.argv[2], **out)
"""


@pytest.fixture(scope="module", params=["v2", "v3"])
def lower_level(request, tmp_path_factory):
    """Results of every subject at a lower instruction-set level of this machine, from a process of its own."""
    level, own = request.param, jink._engine.level
    if not (own.startswith("v") and level < own):
        pytest.skip(f"{level} is no lower level than {own}, which runs here")
    if find_spec(f"jink._native_{level}") is None:
        pytest.skip(f"{level} is not installed: only built by make install LEVELS=all")
    out = tmp_path_factory.mktemp(level) / "out.npz"
    command = [sys.executable, "-c", LEVEL_RUN, str(Path(__file__).parents[1]), str(out)]
    subprocess.run(command, check=True, env=os.environ | {"JINK_ISA": level})
    return dict(np.load(out))


@claims("levels")
def test_instruction_set_levels_agree(name, lower_level):
    """To 1e-12 of the filter's own scale; layers in single precision to 1e-6."""
    within = 1e-6 if "imm-corrected" in name else 1e-12
    t, z, offsets, _ = fleet()
    here = build(name).filter(t, z, offsets=offsets)
    there = {part: lower_level[f"{name}/{part}"] for part in ("x", "P", "mode_probability", "status")}
    sd = np.sqrt(np.einsum("kii->ki", here.P))
    started = here.status > 0
    scale, outer = (np.abs(here.x) + sd)[started], (sd[:, :, None] * sd[:, None, :])[started]
    assert_array_equal(there["status"], here.status)
    assert (np.abs(there["x"] - here.x)[started] <= within * scale).all()
    assert (np.abs(there["P"] - here.P)[started] <= 10 * within * outer).all()
    assert_allclose(there["mode_probability"], here.mode_probability, atol=1e-11)


@claims("smooth")
def test_smoothed_batch_is_a_loop(name):
    t, z, offsets, tracks = fleet(9, 1)
    f = build(name)
    together = f.smooth(t, z, offsets=offsets, threads=2)
    for b, (tb, zb) in enumerate(tracks):
        assert_same(f.smooth(tb, zb), together, slice(offsets[b], offsets[b + 1]), ("x", "P", "mode_probability"))


@claims("neighbours")
def test_a_neighbour_of_nothing_but_nan_changes_nothing(name):
    t, z, offsets, _ = fleet(8, 2)
    f = build(name)
    before = f.filter(t, z, offsets=offsets)
    a, b = offsets[3], offsets[4]
    z[a:b] = np.nan
    after = f.filter(t, z, offsets=offsets)
    others = np.r_[:a, b : len(t)]
    for name_ in RESULTS:
        assert_array_equal(getattr(before, name_)[others], getattr(after, name_)[others])
    assert (after.status[a:b] == 0).all() and np.isnan(after.x[a:b]).all()


@claims("live")
def test_live_is_the_batch_filter(name):
    t, z = scene(40)
    est = build(name).filter(t, z)
    live = build(name).start()
    for k in range(40):
        now = live.update(t[k], z[k])
        sd = np.sqrt(np.diag(est.P[k]))
        assert np.all(np.abs(now.x - est.x[k]) <= 1e-12 * (np.abs(est.x[k]) + sd))
        assert_allclose(now.mode_probability, est.mode_probability[k], rtol=1e-12, atol=1e-12)
        assert now.status == jink.STATUS[est.status[k]]


@claims("saved")
def test_saved_and_loaded_is_the_same(name, tmp_path):
    t, z = scene()
    f = build(name)
    f.save(tmp_path / "f.json")
    loaded = jink.load(tmp_path / "f.json")
    assert_same(f.filter(t, z), loaded.filter(t, z))
    loaded.save(tmp_path / "g.json")
    assert (tmp_path / "f.json").read_text() == (tmp_path / "g.json").read_text()


@claims("live")
def test_live_batch_is_many_live_targets(name):
    """n targets scan by scan, some missing; saved and restored half way."""
    n, N = 11, 30
    rng = np.random.default_rng(6)
    t = np.cumsum(rng.uniform(0.5, 3.0, N))
    z = np.stack([flight(t, 2, rng)[0] + rng.normal(0, 25.0, (N, 2)) for _ in range(n)])
    z[rng.random((n, N)) < 0.2] = np.nan
    f = build(name)
    batch, singles = f.start(n), [f.start() for _ in range(n)]
    for k in range(N):
        if k == N // 2:
            state = batch.save()
            batch = f.start(n, state=state)
        now = batch.update(t[k], z[:, k])
        ones = [s.update(t[k], z[i, k]) for i, s in enumerate(singles)]
        for i, one in enumerate(ones):
            assert jink.STATUS[now.status[i]] == one.status
            if now.status[i]:
                sd = np.sqrt(np.diag(now.P[i]))
                assert np.all(np.abs(now.x[i] - one.x) <= 1e-11 * (np.abs(one.x) + sd))
            else:
                assert np.isnan(now.x[i]).all()


@claims("live")
def test_live_targets_that_follow_many_scans_are_those_updated_scan_by_scan(name):
    """n targets, in two calls, with a noise of each row; and one target has the bits of a batch."""
    n, N = 11, 30
    rng = np.random.default_rng(7)
    t = np.cumsum(rng.uniform(0.5, 3.0, N))
    z = np.stack([flight(t, 2, rng)[0] + rng.normal(0, 25.0, (N, 2)) for _ in range(n)], axis=1)
    z[rng.random((N, n)) < 0.2] = np.nan
    noise = rng.uniform(300.0, 900.0, (N, n, 2))
    f = build(name)
    updated, followed, one = f.start(n), f.start(n), f.start(1)
    scans = [updated.update(t[k], z[k], covariance=noise[k]) for k in range(N)]
    parts = [
        followed.follow(t[c], z[c].reshape(-1, 2), covariance=noise[c].reshape(-1, 2))
        for c in np.split(np.arange(N), [9])
    ]
    alone, batch = one.follow(t, z[:, 3], covariance=noise[:, 3]), f.filter(t, z[:, 3], covariance=noise[:, 3])
    for result in ("x", "P", "mode_probability", "nis", "status"):
        wanted = np.concatenate([scan.results[result] for scan in scans])
        assert_array_equal(np.concatenate([part.results[result] for part in parts]), wanted)
        assert_array_equal(alone.results[result], batch.results[result])
    with pytest.raises(ValueError, match="t: lies before"):
        followed.follow(t[:1], z[0])
    with pytest.raises(ValueError, match="z: expected 22 rows, one per scan and target, got 11"):
        followed.follow(t[-1] + [1.0, 2.0], z[0])


@claims("smooth")
@pytest.mark.parametrize("lag", [1, 3])
def test_fixed_lag_is_the_smoother_of_what_was_seen(name, lag):
    """At scan k the estimate of scan k - lag equals smoothing the rows up to k."""
    t, z = scene(30)
    live = build(name).start(lag=lag)
    for k in range(30):
        now = live.update(t[k], z[k])
        if k < 5:
            continue
        whole = build(name).smooth(t[: k + 1], z[: k + 1])
        sd = np.sqrt(np.diag(whole.P[k - lag]))
        assert np.all(np.abs(now.x - whole.x[k - lag]) <= 1e-9 * (np.abs(now.x) + sd)), k
        assert_allclose(now.mode_probability, whole.mode_probability[k - lag], atol=1e-9)
