"""Arguments, states, arrays and files that do not fit: an error that names them, never a wrong number or a crash.

What could end the process runs in the engine's checks first; these tests hold the checks.
"""

from __future__ import annotations

import json
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import jink
from benchmarks import border
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS

CV = jink.ConstantVelocity(acceleration_psd=1.0)
KALMAN = jink.Kalman(CV, jink.Position(sd=10.0))
CHAIN = [[0.9, 0.1], [0.1, 0.9]]
TWO = [CV, jink.ConstantAcceleration(jerk_psd=1.0)]
LINE = [[0.8, 0.2, 0.0], [0.1, 0.8, 0.1], [0.0, 0.2, 0.8]]
SENSOR = jink.Position(sd=10.0)
MADE = {
    "imm": lambda **more: jink.IMM(TWO, SENSOR, CHAIN, **more),
    "gpb1": lambda **more: jink.GPB1(TWO, SENSOR, CHAIN, **more),
    "gpb2": lambda **more: jink.GPB2(TWO, SENSOR, CHAIN, **more),
    "digraph": lambda **more: jink.ActiveDigraph(
        [jink.ConstantVelocity(acceleration_psd=q) for q in (0.1, 1.0, 10.0)], SENSOR, LINE, alive=2, **more
    ),
}
SEVERAL = {name: make() for name, make in MADE.items()}
DIGRAPH = SEVERAL["digraph"]
x, P = np.zeros(4), np.eye(4)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: KALMAN.start(8).begin(10**6, x, P, 0.0), "target: there is no target 1000000; expected 0 to 7"),
        (lambda: KALMAN.start(8).begin(-1, x, P, 0.0), "target: there is no target -1"),
        (lambda: KALMAN.start(8).reset(10**7), "target: there is no target"),
        (lambda: KALMAN.start().begin(np.zeros(1), np.zeros((1, 1)), 0.0), r"x: expected shape \(4,\), got \(1,\)"),
        (lambda: KALMAN.start().begin(x, np.eye(3), 0.0), r"P: expected shape \(4, 4\)"),
        (lambda: KALMAN.start().begin(x, -P, 0.0), "P: is not symmetric and positive definite"),
        (lambda: KALMAN.start().begin(x, np.triu(np.ones((4, 4))), 0.0), "P: is not symmetric"),
        (lambda: KALMAN.start().begin(np.full(4, np.nan), P, 0.0), "x: has values that are not finite"),
        (lambda: KALMAN.start().begin(x, P, np.inf), "time: is infinite"),
        (lambda: KALMAN.start().update(0.0, [1, 2], covariance=np.ones((1, 1))), r"covariance: expected \(2, 2\)"),
        (lambda: KALMAN.start().update(0.0, [1, 2], covariance=np.array([-1.0, 5.0])), "covariance: has a variance"),
        (lambda: KALMAN.start().update(0.0, [1, 2], covariance=np.array([[1.0, 9], [9, 1]])), "covariance: is not pos"),
        (lambda: KALMAN.start().update(0.0, [1, 2], input=np.zeros(0)), r"input: expected shape \(2,\), got \(0,\)"),
        (lambda: KALMAN.start().update(np.inf, [1, 2]), "t: expected a finite time"),
        (lambda: KALMAN.start().predict(np.nan), "t: expected a finite time"),
        (lambda: KALMAN.start(64).predict(np.zeros(2)), "t: expected one time or one for each target"),
    ],
)
def test_live_arguments_are_checked(call, match):
    with pytest.raises(ValueError, match=match):
        call()


def live_after(f, rows=6):
    live = f.start()
    for k in range(rows):
        live.update(float(k), [10.0 * k, 5.0 * k])
    return live


@pytest.mark.parametrize("f", [KALMAN, *SEVERAL.values()], ids=["kalman", *SEVERAL])
def test_a_changed_state_is_refused_and_nothing_is_touched(f):
    state, rng = live_after(f).save(), np.random.default_rng(0)
    other = live_after(f, 3)
    before = other.save()
    for _ in range(2000):
        bad = bytearray(state)
        bad[int(rng.integers(len(bad)))] ^= int(rng.integers(1, 256))
        with pytest.raises(ValueError, match="state: "):
            other.restore(bytes(bad[: int(rng.integers(len(bad) + 1))] if rng.random() < 0.1 else bad))
    assert other.save() == before
    other.restore(state)
    assert other.save() == state


def test_a_state_of_another_filter_is_refused():
    like = jink.Kalman(jink.ConstantVelocity(acceleration_psd=2.0), jink.Position(sd=10.0))
    with pytest.raises(ValueError, match="state: was saved by another filter"):
        like.start(state=live_after(KALMAN).save())
    with pytest.raises(ValueError, match=r"another number of targets \(1\)"):
        KALMAN.start(2).restore(live_after(KALMAN).save())


def test_a_state_with_a_true_checksum_and_a_false_mode_is_refused():
    state = bytearray(live_after(DIGRAPH).save())
    numbers = np.frombuffer(bytes(state[48:])).copy()
    places = [k for k in range(len(numbers)) if numbers[k] in (-1.0, 0.0, 1.0, 2.0)]

    def signed(values):
        digest = 1469598103934665603
        for byte in values.tobytes():
            digest = (digest ^ byte) * 1099511628211 % 2**64
        return bytes(state[:40]) + digest.to_bytes(8, "little") + values.tobytes()

    assert signed(numbers) == bytes(state)
    refused = 0
    for k in places:
        changed = numbers.copy()
        changed[k] = 1e6
        live = DIGRAPH.start()
        try:
            live.restore(signed(changed))
        except ValueError as error:
            assert "names a mode that there is not" in str(error)
            refused += 1
        else:
            live.update(9.0, [1.0, 2.0])
    assert refused >= 2


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("x", lambda a: np.zeros((len(a), 8))[:, ::2]),
        ("x", lambda a: a.astype(np.float32)),
        ("P", np.asfortranarray),
        ("status", lambda a: np.zeros(len(a))),
        ("x", lambda a: np.broadcast_to(a[:1], a.shape)),
    ],
)
def test_out_takes_what_the_engine_can_write_into(name, change):
    t, z = np.arange(50.0), np.zeros((50, 2))
    est = KALMAN.filter(t, z)
    est.results = {**est.results, name: change(est.results[name])}
    with pytest.raises(ValueError, match=f"out: expected {name} as a contiguous, writable array"):
        KALMAN.filter(t, z, out=est)


def test_one_live_object_serves_several_threads():
    live = SEVERAL["imm"].start(64, lag=3)
    z, done = np.zeros((64, 2)), []

    def work():
        for k in range(200):
            try:
                live.update(float(k), z)
            except ValueError as error:
                assert "order of time" in str(error)
        done.append(1)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(done) == 4 and np.isfinite(live.predict(300.0).x).all()


def test_more_threads_than_the_system_starts():
    tracks = 5000
    est = KALMAN.filter(
        np.tile(np.arange(4.0), tracks), np.zeros((4 * tracks, 2)), offsets=4 * np.arange(tracks + 1), threads=100_000
    )
    assert (est.status[3::4] == jink.Status.updated).all()


def test_a_filter_file_has_limits(tmp_path):
    network = {"kind": "Network", "weights": [[[0.1] * 3] * 200, [[0.1] * 200]], "biases": [[0.0] * 200, [0.0]]}
    noise = {"kind": "NoiseNetwork", "network": network, "inputs": "log-nis", "output": "log-variance"}
    noise |= {"centre": [0, 0, 0], "scale": [1, 1, 1], "least": 0.1, "most": 10.0, "start": 1.0}
    motion = {"kind": "NetworkNoise", "motion": {"kind": "ConstantVelocity", "acceleration_sd": 1.0}, "network": noise}
    body = {"jink": "filter", "version": 1, "units": "SI", "filter": "Kalman", "motions": [motion]}
    body["sensors"] = [{"kind": "Position", "sd": 10.0}]
    path = tmp_path / "wide.json"
    path.write_text(json.dumps(body))
    with pytest.raises(ValueError, match=r"wide.json: network: expected layers of 1 to 128, got one of 200"):
        jink.load(path)
    path.write_text("[" * 100_000)
    with pytest.raises(ValueError, match="nests too deeply"):
        jink.load(path)


@pytest.mark.parametrize("value", [1e155, -1e160, 1e300])
@pytest.mark.parametrize("outliers", [None, jink.Outliers()])
@pytest.mark.parametrize("make", MADE.values(), ids=MADE)
def test_a_measurement_beyond_the_range_of_numbers_is_gated(make, outliers, value):
    f = make(outliers=outliers)
    t, z = np.arange(40.0), np.random.default_rng(0).normal(size=(40, 2))
    z[20, 0] = value
    for run in (f.filter, f.smooth) if not f.not_smoothed else (f.filter,):
        est = run(t, z)
        assert np.isfinite(est.x[1:]).all() and np.isfinite(est.P[1:]).all()
        assert np.isfinite(est.log_likelihood_scan).all()
    assert f.filter(t, z).status[20] == jink.Status.gated


@pytest.mark.parametrize("f", [KALMAN, SEVERAL["imm"], SEVERAL["gpb2"]], ids=["kalman", "imm", "gpb2"])
def test_a_row_beyond_the_range_of_numbers_does_not_count_as_the_second_position(f):
    t, z = np.arange(5.0), 100.0 * np.arange(10.0).reshape(5, 2)
    far, missing = z.copy(), z.copy()
    far[1, 0], missing[1] = 1e155, np.nan
    with_it, without = f.filter(t, far), f.filter(t, missing)
    assert with_it.status[1] == jink.Status.gated
    for name in ("x", "P", "mode_probability"):
        np.testing.assert_array_equal(with_it.results[name][2:], without.results[name][2:])


def test_range_rate_at_the_site():
    sensor = jink.Polar(range_sd=10.0, azimuth_sd=0.01, range_rate_sd=1.0)
    f = jink.Kalman(CV, sensor, outliers=jink.Outliers())
    t = np.arange(40.0)
    z = np.column_stack([200.0 + 50 * t, np.full(40, 0.5), np.full(40, 50.0)])
    z[:3] = 0.0
    est = f.filter(t, z)
    assert np.isfinite(est.x[1:]).all() and np.isfinite(est.P[1:]).all()


@pytest.mark.parametrize(
    ("sensor", "far"),
    [
        (jink.Position(sd=10.0), [1e155, 5.0]),
        (jink.Polar(range_sd=10.0, azimuth_sd=0.01), [1e155, 0.5]),
        (jink.Polar(range_sd=10.0, azimuth_sd=0.01, height_sd=10.0, earth_radius=6.4e6), [1e3, 0.5, -1e300]),
    ],
)
def test_what_lies_beyond_all_distances_starts_no_track(sensor, far):
    """With or without a share of outliers: the track starts from the first position that can be one."""
    t = np.arange(20.0)
    z = np.tile([1e3, 0.5, 100.0][: len(far)], (20, 1))
    z[0] = far
    for outliers in (None, jink.Outliers()):
        est = jink.Kalman(CV, sensor, outliers=outliers).filter(t, z)
        assert est.status[0] == jink.Status.none
        assert est.status[1] == jink.Status.initialised
        assert np.isfinite(est.x[1:]).all() and np.isfinite(est.P[1:]).all()


@pytest.mark.parametrize("name", ["anfis-kf", "nn-kf", "input-estimation"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_a_forged_state_of_an_aid_or_a_detector_gives_no_nan(name, value):
    """With a true checksum every number reaches the engine: refused, or all estimates after it are finite."""
    f = FILTERS[name](Purpose(sensor=SENSOR, sd=10.0)).filter
    state = live_after(f, 5).save()
    taken = 0
    for place in range(border.HEADER, len(state), 8):
        forged = bytearray(state)
        forged[place : place + 8] = np.float64(value).tobytes()
        try:
            live = f.start(state=border.signed(forged))
            estimates = [live.update(6.0 + k, [1.0, 2.0]) for k in range(3)]
        except ValueError:  # also of a state that is later than the rows
            continue
        taken += 1
        for estimate in estimates:
            assert np.isfinite(estimate.x).all() and np.isfinite(estimate.P).all(), place
    assert taken > 5


def test_a_forged_state_that_runs_before_it_has_started_is_refused():
    state = bytearray(live_after(KALMAN).save())
    started = len(state) - 16
    assert np.frombuffer(state[started:]).tolist() == [1.0, 1.0]
    state[started : started + 8] = bytes(8)
    with pytest.raises(ValueError, match="state: runs before it has started"):
        KALMAN.start(state=border.signed(state))


def test_a_list_that_gets_shorter_while_it_is_read_is_refused():
    z: list = [1.0, 2.0]

    class Number:
        def __float__(self):
            z.clear()
            return 1.0

    z[0] = Number()
    with pytest.raises(ValueError, match="z: expected 2 components"):
        KALMAN.start().update(0.0, z)


@pytest.mark.parametrize("t", [[], [[]], "", "x", 10**400, [1.0, 2.0]])
def test_a_live_time_is_one_time(t):
    live = KALMAN.start()
    with pytest.raises((TypeError, ValueError), match=r"t: expected|time: expected"):
        live.update(t, [1.0, 2.0])
    with pytest.raises((TypeError, ValueError), match="z: expected"):
        live.update(0.0, [[1.0], [2.0, 3.0]])
    with pytest.raises((TypeError, ValueError), match="z: expected"):
        live.update(0.0, 10**400)
