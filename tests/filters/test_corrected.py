"""The correction in the plane: the engine against the textbook, and what it leaves alone."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.corrected import corrected

import jink
from jink.filters.corrected import Corrected
from jink.models.plane_corrector import ODD, PlaneCorrector, even_inputs

SD = 50.0


def corrector(modes=4, hidden=5, kept=3, seed=0, size=0.15, **more):
    """Random weights, ranges and bounds that the data leave now and then."""
    rng, even = np.random.default_rng(seed), even_inputs(modes)
    width = np.full(even + ODD, 6.0)
    return PlaneCorrector(
        low=-width,
        high=width,
        centre=rng.normal(0, 0.2, even + ODD) * np.r_[np.ones(even), np.zeros(ODD)],
        scale=rng.uniform(0.5, 2.0, even + ODD),
        even=rng.normal(0, 0.3, (hidden, even + kept)),
        odd=rng.normal(0, 0.3, (hidden, ODD + kept)),
        bias=rng.normal(0, 0.3, hidden),
        along=rng.normal(0, size, (3, hidden)),
        along_bias=rng.normal(0, size, 3),
        across=rng.normal(0, size, (2, hidden)),
        keep=rng.uniform(0, 0.9, kept),
        recall=rng.normal(0, 2.0, (kept, hidden)),
        recall_bias=rng.normal(0, 1.0, kept),
        recall_across=rng.normal(0, 2.0, (kept, hidden)),
        fade=0.5,
        **more,
    )


def turning(seed=3, tracks=9, scans=60, axes=2):
    """Targets that turn at their own rates, with misses, gaps and an outlier."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.5, 3.0, scans))
    rate = np.where((time > time[20]) & (time < time[40]), 1.0, 0.0) * rng.uniform(-0.1, 0.1, (tracks, 1))
    heading = rng.uniform(0, 6, (tracks, 1)) + np.cumsum(rate * np.diff(time, prepend=0.0), axis=1)
    speed = 200.0 * np.stack([np.cos(heading), np.sin(heading), 0.02 + 0 * heading], axis=-1)[..., :axes]
    z = np.cumsum(speed * np.diff(time, prepend=0.0)[:, None], axis=1) + SD * rng.normal(size=(tracks, scans, axes))
    z[1, 10:13] = np.nan
    z[2, 30] += 5e3
    z[3, 15:17] += 4e5
    return np.broadcast_to(time, (tracks, scans)), z


def filters(kind="fighter", axes=2, **more):
    sensor = jink.Position(sd=SD, axes=axes)
    inner = jink.default_filter(kind, sensor)
    inner = jink.IMM(inner.motions, sensor, inner.transition, outliers=jink.Outliers(hindsight=False))
    return inner, Corrected(inner, corrector(len(inner.motions), **more))


def run(f, time, z, **more):
    B, S, m = z.shape
    return f.filter(time.reshape(-1), z.reshape(-1, m), offsets=np.arange(B + 1) * S, **more)


def scans_of(f, time, z):
    """What the filter says of one track before and after every measurement: each time once without it."""
    doubled = np.full((2 * len(z), z.shape[1]), np.nan)
    doubled[1::2] = z
    said = f.filter(np.repeat(time, 2), doubled)
    for k in range(len(z)):
        yield {
            "x_before": said.x[2 * k],
            "P_before": said.P[2 * k],
            "x": said.x[2 * k + 1],
            "P": said.P[2 * k + 1],
            "mu_before": said.mode_probability[2 * k],
            "mu": said.mode_probability[2 * k + 1],
            "z": z[k, :2],
            "R": SD**2 * np.eye(2),
            "time": time[k],
            "taken": said.status[2 * k + 1] == jink.Status.updated,
            "began": said.status[2 * k + 1] in (jink.Status.initialised, jink.Status.restarted),
        }


@pytest.mark.parametrize(
    ("kind", "axes", "hidden", "kept"), [("fighter", 2, 5, 3), ("aircraft", 2, 16, 0), ("aircraft", 3, 17, 1)]
)
def test_engine_and_textbook_agree(kind, axes, hidden, kept):
    """To what the single precision of the engine's layers leaves, in sds."""
    (inner, aided), (time, z) = filters(kind, axes, hidden=hidden, kept=kept), turning(axes=axes)
    got = run(aided, time, z)
    x, P = (v.reshape(*z.shape[:2], *v.shape[1:]) for v in (got.x, got.P))
    moved = 0.0
    for b in range(len(z)):
        scans = list(scans_of(inner, time[b], z[b]))
        want_x, want_P = corrected(list(inner.components), aided.corrector, scans)
        begun = np.isfinite(x[b]).all(axis=1)
        scale = np.sqrt(np.abs(np.array(want_P)).max(axis=0).diagonal())
        assert_allclose(x[b][begun] / scale, np.array(want_x)[begun] / scale, rtol=1e-9, atol=1e-6)
        assert_allclose(P[b][begun], np.array(want_P)[begun], rtol=2e-6, atol=1e-9 * np.abs(want_P).max())
        moved = max(moved, np.abs(np.array(want_x)[begun] - np.array([s["x"] for s in scans])[begun]).max())
    assert moved > 5.0


def test_the_filter_itself_is_untouched():
    (inner, aided), (time, z) = filters(), turning()
    alone, got = run(inner, time, z), run(aided, time, z)
    for name in ("mode_probability", "log_likelihood_scan", "nis", "status"):
        assert_array_equal(getattr(alone, name), getattr(got, name))
    begun = np.isin(got.status, (jink.Status.initialised, jink.Status.restarted))
    assert_array_equal(alone.x[begun], got.x[begun])
    idle = got.status != jink.Status.updated
    assert_array_equal(alone.P[idle], got.P[idle])
    assert (alone.x[~idle] != got.x[~idle]).any()


def test_a_correction_moves_on_with_the_target_until_the_next_measurement():
    (inner, aided), (time, z) = filters(kind="aircraft", trust=1e9), turning()
    time, z = time[4], z[4]
    z[40:] = np.nan
    z[45] = z[39] + 3e5  # rejected
    alone, got = (f.filter(time, z) for f in (inner, aided))
    at = [[inner.components.index(letter + axis) for axis in "xy"] for letter in "pv"]
    position, velocity = ((got.x - alone.x)[:, which] for which in at)
    assert np.abs(velocity[39]).min() > 0.01
    assert got.status[45] == jink.Status.gated
    for k in range(40, 60):
        assert_allclose(velocity[k], velocity[39], rtol=1e-6)
        assert_allclose(position[k], position[39] + (time[k] - time[39]) * velocity[39], rtol=1e-6)


def test_smoothing_leaves_it_out():
    (inner, aided), (time, z) = filters(), turning()
    B, S, m = z.shape
    rows = {"offsets": np.arange(B + 1) * S}
    for how in ({}, {"lag": 2}):
        alone, got = (f.smooth(time.reshape(-1), z.reshape(-1, m), **rows, **how) for f in (inner, aided))
        assert_array_equal(alone.x, got.x)
        assert_array_equal(alone.P, got.P)
    lagged = [f.start(lag=1) for f in (inner, aided)]
    for t, each in zip(time[0], z[0], strict=True):
        one, other = (live.update(t, each) for live in lagged)
        assert_array_equal(one.x, other.x)


def test_live_batch_and_threads_agree():
    (_, aided), (time, z) = filters(), turning()
    together = run(aided, time, z)
    assert_array_equal(together.x, run(aided, time, z, threads=2).x)
    x = together.x.reshape(*z.shape[:2], -1)
    for b in (0, 2, 3):
        live, kept = aided.start(), None
        for k in range(z.shape[1]):
            said = live.update(time[b, k], z[b, k])
            if np.isfinite(x[b, k]).all():
                assert_allclose(said.x, x[b, k], rtol=1e-11, atol=1e-9)
            if k == 25:
                kept = live.save()
        again = aided.start(state=kept)
        for k in range(26, z.shape[1]):
            said = again.update(time[b, k], z[b, k])
        assert_allclose(said.x, x[b, -1], rtol=1e-11, atol=1e-9)


@pytest.mark.parametrize("angle", [0.7, 2.5, -1.1])
@pytest.mark.parametrize("mirrored", [False, True])
def test_turned_and_mirrored_targets_are_corrected_alike(angle, mirrored):
    (_, aided), (time, z) = filters(), turning()
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    plain, turned = run(aided, time, z), run(aided, time, z @ turn.T)
    known = np.isfinite(plain.x).all(axis=1)
    for letter in "pv":
        at = [aided.components.index(letter + axis) for axis in "xy"]
        assert_allclose(turned.x[known][:, at], plain.x[known][:, at] @ turn.T, rtol=1e-7, atol=1e-4)


def test_it_fades_outside_its_range_and_where_innovations_speak_against_it():
    (inner, aided), (time, z) = filters(), turning()
    c = aided.corrector
    alone = run(inner, time, z)
    far = replace(c, low=np.add(c.high, 100.0), high=np.add(c.high, 101.0))
    assert_array_equal(run(Corrected(inner, far), time, z).x, alone.x)
    # a correction as large as this one is wrong: the less it is trusted beforehand, the less of it is left
    wrong = replace(c, along_bias=[2.0, 2.0, 0.0], memory=1.0)
    late = np.arange(z.shape[1])[None, :].repeat(len(z), 0).reshape(-1) > 40
    left = [
        np.abs(run(Corrected(inner, replace(wrong, trust=t)), time, z).x - alone.x)[late].mean() for t in (0.1, 1e9)
    ]
    assert left[0] < 0.4 * left[1]


def test_saved_and_loaded(tmp_path):
    (_, aided), (time, z) = filters(), turning()
    aided.save(tmp_path / "corrected.json")
    again = jink.load(tmp_path / "corrected.json")
    assert again == aided
    assert_array_equal(run(again, time, z).x, run(aided, time, z).x)


def test_a_file_of_a_network_that_remembers_nothing_may_leave_that_out(tmp_path):
    (_, aided), file = filters(kept=0), tmp_path / "corrected.json"
    aided.save(file)
    said = json.loads(file.read_text())
    for name in ("keep", "recall", "recall_bias", "recall_across"):
        assert said["corrector"].pop(name) == []
    file.write_text(json.dumps(said))
    assert jink.load(file) == aided


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bias": [0.0] * 3}, "even: expected finite numbers of shape"),
        ({"scale": [0.0] * 24}, "scale: expected positive"),
        ({"keep": [0.5] * 2}, "even: expected finite numbers of shape"),
        ({"keep": [0.5, 0.5, 1.0]}, "keep: expected"),
        ({"memory": 1.5}, "memory: expected"),
        ({"fade": 0.0}, "fade"),
    ],
)
def test_what_does_not_fit_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        replace(corrector(), **change)


def test_filters_that_it_does_not_fit_are_refused():
    sensor = jink.Position(sd=SD)
    with pytest.raises(ValueError, match="expected 3 modes"):
        Corrected(jink.default_filter("fighter", sensor), corrector(3))
    with pytest.raises(ValueError, match="a mode that accelerates"):
        Corrected(jink.IMM([jink.ConstantVelocity(acceleration_sd=s) for s in (1.0, 9.0)], sensor, 0.9), corrector(2))
    with pytest.raises(TypeError, match=r"expected a jink\.IMM"):
        Corrected(jink.Kalman(jink.ConstantVelocity(acceleration_sd=1.0), sensor), corrector(1))
    with pytest.raises(ValueError, match="at most 128 units"):
        Corrected(jink.default_filter("fighter", sensor), corrector(4, hidden=129))


def test_the_engine_refuses_numbers_that_its_layers_do_not_take():
    from jink._engine import native

    _, aided = filters()
    declaration = native.Declaration(aided.declaration)
    own = aided.corrector.numbers()
    wrong = ((18, [5, 3], [1.0]), (16, [5, 3], own), (18, [5], own), (18, [5, 33], own), (18, [999, 3], own))
    for inputs, sizes, numbers in wrong:
        declaration.aid = native.Aid(
            kind=native.AidInputs.plane, inputs=inputs, outputs=1, sizes=sizes, numbers=numbers
        )
        with pytest.raises(ValueError, match="aid"):
            native.Engine(declaration)


def test_a_state_that_is_given_knows_nothing_of_corrections_before():
    (inner, aided), (time, z) = filters(kind="aircraft", trust=1e9), turning()
    live = [f.start() for f in (inner, aided)]
    for t, each in zip(time[4, :40], z[4, :40], strict=True):
        alone, got = (f.update(t, each) for f in live)
    assert (live[0].predict(time[4, 40]).x != live[1].predict(time[4, 40]).x).any()
    for f in live:
        f.begin(alone.x, alone.P, time[4, 39])
    assert_array_equal(live[0].predict(time[4, 40]).x, live[1].predict(time[4, 40]).x)
    assert (got.x != alone.x).any()
