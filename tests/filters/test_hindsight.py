"""A row that may be the target's or not is followed both ways, and decided by the next one."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from agreement import assert_agrees
from oracle.situations import (
    BOUNDED,
    CA,
    CT,
    CV,
    DOPPLER,
    HEIGHT,
    LEADING,
    ONE,
    P1,
    P2,
    P3,
    PV2,
    RADAR,
    SOJOURN,
    TWO,
    make_data,
)
from oracle.twin import Data, Twin, run_oracle
from own_models import Straight

import jink

DOUBTING = {"share": 0.01, "extent": 1e5, "restart_after": 2, "hindsight": True}
COASTING = {"after": 3.0, "manoeuvre": 2.0, "climb": 5.0}
TWINS = {
    "kalman-1": Twin([CV], [P1], 1, outliers=DOUBTING, initial=TWO),
    "kalman-ca": Twin([CA], [P2], 2, outliers=DOUBTING, initial=ONE),
    "imm-mixed": Twin([CV, CA, CT], [P2], 2, LEADING, outliers=DOUBTING, initial=TWO),
    "imm-3": Twin([CV, CA, CT], [P3], 3, SOJOURN, outliers=DOUBTING, initial=BOUNDED, coasting=COASTING),
    "imm-velocity": Twin([CV, CA], [PV2], 2, 0.9, outliers=DOUBTING, initial=ONE),
    "imm-doppler": Twin([CV, CT], [DOPPLER], 2, 0.9, outliers=DOUBTING, initial=TWO),
    "imm-height": Twin([CV, CT], [HEIGHT], 3, 0.9, outliers=DOUBTING, initial=TWO),
    "imm-ukf": Twin([CV, CT], [RADAR], 2, 0.9, linearisation="ukf", outliers=DOUBTING, initial=TWO),
    "imm-sensors": Twin([CV, CA, CT], [P2, DOPPLER, RADAR], 2, LEADING, outliers=DOUBTING, initial=ONE),
}


def doubtful(twin: Twin, N: int = 60, seed: int = 0, every: int = 4) -> Data:
    """Every fourth row some standard deviations off, so that it is now the target's, now not; a tenth of the rows
    missing.
    """
    data = make_data(twin, N, seed, partial=0.02)
    data.z[N // 3, 0] -= 5e4
    data.z[2 * N // 3 :, 0] -= 5e4
    rng = np.random.default_rng([seed, 77])
    sensors = [p.sensor() for p in twin.sensors]
    for k in range(6, N, every):
        sensor = sensors[0 if data.sensor is None else data.sensor[k]]
        data.z[k, : sensor.m] += rng.choice([-1, 1]) * rng.uniform(4.0, 12.0) * np.sqrt(np.diag(sensor.R))
    return data


def agrees(twin: Twin, data: Data, smooth: bool = False) -> None:
    doubts = [s.doubt for s in run_oracle(twin, data).scans if s.doubt is not None]
    assert len(doubts) >= 3, "nothing was in doubt"
    assert_agrees(twin, data, smooth)


@pytest.mark.parametrize("name", TWINS)
def test_filter_agrees_with_the_textbook(name):
    agrees(TWINS[name], doubtful(TWINS[name], 48))


@pytest.mark.parametrize("name", ["kalman-ca", "imm-mixed", "imm-3", "imm-sensors"])
def test_smoother_agrees_with_the_textbook(name):
    """The textbook's does not coast."""
    agrees(replace(TWINS[name], coasting=None), doubtful(TWINS[name], 40), smooth=True)


def test_both_decisions_occur():
    twin = TWINS["imm-mixed"]
    scans = [s for seed in range(3) for s in run_oracle(twin, doubtful(twin, seed=seed)).scans]
    assert {s.doubt.upheld for s in scans if s.doubt is not None} >= {True, False}


def many(twin: Twin, tracks: int = 21) -> tuple[np.ndarray, np.ndarray, np.ndarray, dict]:
    """Tracks of different lengths, laid end to end."""
    each = [doubtful(twin, 12 + 2 * k, seed=k) for k in range(tracks)]
    offsets = np.r_[0, np.cumsum([len(d.time) for d in each])]
    time, z = (np.concatenate([getattr(d, name) for d in each]) for name in ("time", "z"))
    sensor = None if each[0].sensor is None else np.concatenate([d.sensor for d in each])
    return time, z, offsets, {} if sensor is None else {"sensor": sensor}


@pytest.mark.parametrize("name", ["kalman-ca", "imm-mixed", "imm-sensors"])
@pytest.mark.parametrize("verb", ["filter", "smooth"])
def test_neighbours_and_threads_change_no_bit(name, verb):
    f = TWINS[name].native()
    time, z, offsets, more = many(TWINS[name])
    whole = getattr(f, verb)(time, z, offsets=offsets, threads=3, **more)
    for a, b in itertools.pairwise(offsets):
        part = {k: v[a:b] for k, v in more.items()}
        one = getattr(f, verb)(time[a:b], z[a:b], **part)
        for field in ("x", "P", "mode_probability", "log_likelihood_scan", "nis", "status"):
            np.testing.assert_array_equal(getattr(whole, field)[a:b], getattr(one, field), err_msg=field)


def test_live_tracking_is_the_batch_and_says_what_it_decided():
    twin = TWINS["imm-mixed"]
    f, data = twin.native(), doubtful(twin)
    batch = f.filter(data.time, data.z)
    scans = run_oracle(twin, data).scans
    live, decided = f.start(), []
    for k in range(len(data.time)):
        if k == 30:
            state = live.save()
            live = f.start()
            live.restore(state)
        e = live.update(data.time[k], data.z[k])
        np.testing.assert_allclose(e.x, batch.x[k], rtol=1e-9, atol=1e-9)
        doubt = scans[k].doubt
        assert e.doubt == pytest.approx(doubt.doubted.weight if doubt else 0.0, abs=1e-9)
        decided.append(e.decided)
    rows = [(k, s) for k, s in enumerate(scans) if s.doubt is not None and s.doubt.used is not None]
    said = ["updated" if s.doubt.upheld else "gated" for _, s in rows if s.doubt.upheld is not None]
    assert [d for d in decided if d is not None] == said


@pytest.mark.parametrize("name", ["kalman-ca", "imm-mixed", "imm-3"])
@pytest.mark.parametrize("lag", [1, 3])
def test_a_lag_in_a_batch_is_the_live_one(name, lag):
    f = TWINS[name].native()
    time, z, offsets, _ = many(TWINS[name], 8)
    batch = f.smooth(time, z, offsets=offsets, lag=lag)
    for first, end in itertools.pairwise(offsets):
        live = f.start(lag=lag)
        late = [live.update(time[k], z[k]).x for k in range(first, end)][lag:]
        np.testing.assert_allclose(late, batch.x[first : end - lag], rtol=1e-8, atol=1e-8)


def test_no_lag_is_the_filter_and_a_long_one_the_smoother():
    f = TWINS["imm-mixed"].native()
    time, z, offsets, _ = many(TWINS["imm-mixed"], 8)
    for lagged, whole in (
        (f.smooth(time, z, offsets=offsets, lag=0), f.filter(time, z, offsets=offsets)),
        (f.smooth(time, z, offsets=offsets, lag=60), f.smooth(time, z, offsets=offsets)),
    ):
        for field in ("x", "P", "mode_probability", "status"):
            np.testing.assert_array_equal(getattr(lagged, field), getattr(whole, field), err_msg=field)


def test_where_nothing_is_in_doubt_nothing_changes():
    rng = np.random.default_rng(0)
    time = 4.0 * np.arange(80)
    z = np.c_[150.0 * time, 20.0 * time] + np.clip(rng.normal(0, 25.0, (80, 2)), -50.0, 50.0)
    z[40] += 5e4
    both = []
    for hindsight in (False, True):
        f = jink.default_filter("aircraft", jink.Position(sd=25.0))
        f = jink.IMM(f.motions, f.sensors[0], f.transition, outliers=jink.Outliers(extent=1e5, hindsight=hindsight))
        both += [f.filter(time, z), f.smooth(time, z)]
    for field in ("x", "P", "mode_probability", "log_likelihood_scan", "status", "nis"):
        np.testing.assert_array_equal(getattr(both[0], field), getattr(both[2], field), err_msg=field)
        np.testing.assert_array_equal(getattr(both[1], field), getattr(both[3], field), err_msg=field)


def test_a_row_believed_with_hindsight_alone_keeps_its_track():
    """The row at 10 s is gated, as is the one at 11 s, which upholds it: the track waits for 20 s from 10 s on."""
    doubting = jink.Outliers(extent=1e4, restart_after=0, hindsight=True)
    motion, sensor = jink.ConstantVelocity(acceleration_psd=0.1), jink.Position(sd=10.0, axes=1)
    f = jink.Kalman(motion, sensor, outliers=doubting, coast=20.0)
    time = np.array([*range(12), 29.9, 30.1])
    z = np.array([*[0.0] * 10, 57.6, 74.5, np.nan, np.nan])[:, None]
    first, final = (verb(time, z).status[10:] for verb in (f.filter, f.smooth))
    gated, updated, predicted, none = (jink.Status[name] for name in ("gated", "updated", "predicted", "none"))
    np.testing.assert_array_equal(first, [gated, gated, predicted, none])
    np.testing.assert_array_equal(final, [updated, gated, predicted, none])


def test_filters_that_cannot_say_so():
    sensor, doubting = jink.Position(sd=25.0), jink.Outliers(hindsight=True)
    cv = jink.ConstantVelocity(acceleration_sd=1.0)
    with pytest.raises(ValueError, match="hindsight"):
        jink.GPB2([cv, cv], sensor, 0.9, outliers=doubting)
    with pytest.raises(TypeError, match="hindsight"):
        jink.Kalman(Straight(1.0), sensor, outliers=doubting)
