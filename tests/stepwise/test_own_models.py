"""Models of the user's own: jink's models written again in NumPy give what the engine gives."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.situations import RADAR, SITUATIONS, flight, make_data, times
from oracle.twin import distances
from own_models import (
    Accelerating,
    Gauge,
    Radar,
    RadarExactly,
    Straight,
    StraightOneStep,
    Turning,
    TurningExactly,
)

import jink
from jink import _engine
from jink.filters.row_noise import RowNoise
from jink.models.motion import component_names

SITE = RADAR.kwargs["site"]
POLAR = jink.Polar(range_sd=20.0, azimuth_sd=0.003, site=SITE)
POSITION = jink.Position(sd=25.0)
SOJOURN = jink.Sojourn(seconds=[60.0, 20.0, 15.0])
LEADING = [[0.9, 0.06, 0.04], [0.1, 0.85, 0.05], [0.2, 0.05, 0.75]]
ROBUST = jink.Outliers(share=0.01, restart_after=2)

CV = jink.ConstantVelocity(acceleration_psd=0.6)
CA = jink.ConstantAcceleration(jerk_psd=0.3, acceleration_prior_sd=8.0)
CT = jink.CoordinatedTurn(acceleration_psd=0.4, turn_rate_psd=2e-5, turn_rate_prior_sd=0.05)
OWN_CV, OWN_CA = Straight(0.6), Accelerating(0.3, 8.0)
OWN_CT = TurningExactly(0.4, 2e-5, 0.05)
OWN_RADAR = RadarExactly(20.0, 0.003, SITE)

FOUR = np.diag([1e4, 4e4, 1e4, 4e4])
SEVEN = np.diag([1e4, 4e4, 50.0, 1e4, 4e4, 50.0, 1e-3])


def prior(n):
    return jink.Prior(
        [1000.0, 0.0, 2000.0, 0.0] if n == 4 else [1000.0, 0, 0, 2000.0, 0, 0, 0], FOUR if n == 4 else SEVEN
    )


def imm(motions, sensor, transition=LEADING, **more):
    return jink.IMM(motions, sensor, transition, **more)


# each: (of jink's models, of models of one's own)
PAIRS = {
    "kalman-cv": lambda **k: (jink.Kalman(CV, POSITION, **k), jink.Kalman(OWN_CV, POSITION, **k)),
    "kalman-ca": lambda **k: (jink.Kalman(CA, POSITION, **k), jink.Kalman(OWN_CA, POSITION, **k)),
    "kalman-ct": lambda **k: (jink.Kalman(CT, POSITION, **k), jink.Kalman(OWN_CT, POSITION, **k)),
    "kalman-ct-ukf": lambda **k: (
        jink.Kalman(CT, POLAR, linearisation="ukf", **k),
        jink.Kalman(OWN_CT, POLAR, linearisation="ukf", **k),
    ),
    "kalman-radar": lambda **k: (
        jink.Kalman(CV, POLAR, initial=prior(4), **k),
        jink.Kalman(CV, OWN_RADAR, initial=prior(4), **k),
    ),
    "kalman-radar-ukf": lambda **k: (
        jink.Kalman(CV, POLAR, initial=prior(4), linearisation="ukf", **k),
        jink.Kalman(OWN_CV, Radar(20.0, 0.003, SITE), initial=prior(4), linearisation="ukf", **k),
    ),
    "kalman-converted": lambda **k: tuple(
        jink.Kalman(m, jink.Polar(range_sd=20.0, azimuth_sd=0.003, site=SITE, method="converted"), **k)
        for m in (CV, OWN_CV)
    ),
    "kalman-gauge": lambda **k: (jink.Kalman(CV, POSITION, **k), jink.Kalman(CV, Gauge(25.0), **k)),
    "imm-gauge": lambda **k: (imm([CV, CA, CT], POSITION, **k), imm([CV, CA, OWN_CT], Gauge(25.0), **k)),
    "imm-one-own": lambda **k: (imm([CV, CA, CT], POSITION, **k), imm([CV, CA, OWN_CT], POSITION, **k)),
    "imm-all-own": lambda **k: (
        imm([CV, CA, CT], POSITION, **k),
        imm([OWN_CV, OWN_CA, OWN_CT], POSITION, **k),
    ),
    "imm-unbiased": lambda **k: tuple(
        imm(m, POSITION, mixing="unbiased", **k) for m in ([CV, CA, CT], [CV, OWN_CA, OWN_CT])
    ),
    "imm-sojourn": lambda **k: tuple(imm(m, POSITION, SOJOURN, **k) for m in ([CV, CA, CT], [OWN_CV, CA, OWN_CT])),
    "imm-known-turn": lambda **k: tuple(
        imm([m, jink.KnownTurn(0.06, acceleration_psd=1.0), CA], POSITION, **k) for m in (CV, OWN_CV)
    ),
    "imm-radar": lambda **k: (
        imm([CV, CA, CT], POLAR, initial=prior(7), **k),
        imm([CV, OWN_CA, CT], OWN_RADAR, initial=prior(7), **k),
    ),
    "imm-radar-ukf": lambda **k: (
        imm([CV, CA, CT], POLAR, initial=prior(7), linearisation="ukf", **k),
        imm([CV, CA, OWN_CT], OWN_RADAR, initial=prior(7), linearisation="ukf", **k),
    ),
}


def measured(sensor, t, rng, missing=0.1, partial=0.05):
    z = flight(t, 2, rng)[0]
    if isinstance(sensor, jink.Position | Gauge):
        z = z + rng.normal(0, 25.0, z.shape)
    else:
        x = np.insert(z, [1, 2], 0.0, axis=1)
        z = OWN_RADAR.h(x) + rng.normal(size=z.shape) * [20.0, 0.003]
    z[2:][rng.random(len(t) - 2) < missing] = np.nan
    if getattr(sensor, "method", "") != "converted":
        z[2:][rng.random((len(t) - 2, 2)) < partial] = np.nan
    return z


def scene(sensor, N=60, seed=0, jumps=False):
    """Irregular times, some at the same instant; misses whole and partial; outliers and a jump of 50 km."""
    rng = np.random.default_rng(seed)
    t = times(N, rng, 0.05)
    z = measured(sensor, t, rng)
    if jumps:
        z[N // 3, 0] += 5e4
        z[2 * N // 3 :, 0] += 5e4
    return t, z


def fleet(sensor, B=9, seed=0):
    lengths = np.random.default_rng(seed).integers(1, 50, B)
    lengths[4] = 0
    parts = [
        scene(sensor, n, 50 + b) if n > 2 else (np.arange(n, dtype=float), np.ones((n, 2)) * 1e4)
        for b, n in enumerate(lengths)
    ]
    return (
        np.concatenate([t for t, _ in parts]),
        np.concatenate([z for _, z in parts]),
        np.r_[0, np.cumsum(lengths)],
    )


def assert_agrees(own, native, tolerance=1e-9):
    far = {k: f"{v:.1e}" for k, v in distances(own, native).items() if not v <= tolerance}
    assert not far, far


def tolerance_of(name, smooth):
    """Fusing messages of several modes costs a digit, in the engine as here."""
    return 1e-8 if smooth and name.startswith("imm") else 1e-9


@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
@pytest.mark.parametrize("name", PAIRS)
def test_equals_the_engine(name, smooth):
    native, own = PAIRS[name]()
    t, z = scene(native.sensors[0])
    run = "smooth" if smooth else "filter"
    want, got = getattr(native, run)(t, z), getattr(own, run)(t, z)
    assert got.components == want.components and got.modes[0] == want.modes[0]
    assert_agrees(got, want, tolerance_of(name, smooth))
    assert_allclose(got.log_likelihood, want.log_likelihood, rtol=1e-10)


@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
@pytest.mark.parametrize("name", ["kalman-cv", "kalman-gauge", "imm-all-own", "imm-gauge"])
def test_gating_restart_and_coasting_equal_the_engine(name, smooth):
    native, own = PAIRS[name](outliers=ROBUST, coast=40.0)
    t, z = scene(native.sensors[0], 90, 3, jumps=True)
    t[50:] += 100.0
    want, got = (getattr(f, "smooth" if smooth else "filter")(t, z) for f in (native, own))
    assert {3, 4, 5} <= set(want.status)
    assert_agrees(got, want, tolerance_of(name, smooth))


@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
@pytest.mark.parametrize("name", ["kalman-ct", "imm-one-own", "imm-radar"])
def test_ragged_batch_equals_the_engine_and_a_loop(name, smooth):
    native, own = PAIRS[name]()
    t, z, offsets = fleet(native.sensors[0])
    want, got = (getattr(f, "smooth" if smooth else "filter")(t, z, offsets=offsets) for f in (native, own))
    assert_agrees(got, want, tolerance_of(name, smooth))
    for b in (0, 5, 8):
        rows = slice(offsets[b], offsets[b + 1])
        alone = getattr(own, "smooth" if smooth else "filter")(t[rows], z[rows])
        assert_allclose(alone.x, got.x[rows], rtol=1e-12)
        assert_allclose(alone.log_likelihood[0], got.log_likelihood[b], rtol=1e-12)


@pytest.mark.parametrize("name", ["kalman-cv", "kalman-ca", "kalman-ct", "imm-all-own"])
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_known_input_and_row_noise(name, smooth):
    native, own = PAIRS[name]()
    t, z = scene(POSITION, seed=4)
    rng = np.random.default_rng(5)
    root = 20.0 * (np.eye(2) + 0.3 * rng.normal(size=(len(t), 2, 2)))
    more = {"input": rng.normal(0, 2.0, (len(t), 2)), "covariance": root @ root.transpose(0, 2, 1)}
    run = "smooth" if smooth else "filter"
    assert_agrees(getattr(own, run)(t, z, **more), getattr(native, run)(t, z, **more), tolerance_of(name, smooth))
    of_columns = more | {"covariance": RowNoise.of_covariances(more["covariance"])}
    for each in (own, native):
        np.testing.assert_array_equal(getattr(each, run)(t, z, **of_columns).x, getattr(each, run)(t, z, **more).x)
    more["covariance"] = np.diagonal(more["covariance"], axis1=1, axis2=2)
    assert_agrees(own.filter(t, z, **more), native.filter(t, z, **more))


@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_several_sensors(smooth):
    sensors = [POSITION, POLAR, jink.Bearing(0.01, site=SITE)]
    native = imm([CV, CA, CT], sensors, outliers=ROBUST)
    own = imm([CV, CA, CT], [POSITION, OWN_RADAR, sensors[2]], outliers=ROBUST)
    t, z = scene(POSITION, 60, 6)
    polar = scene(POLAR, 60, 6)[1]
    which = np.random.default_rng(1).integers(0, 3, 60)
    which[:2] = 0
    z = np.where((which == 1)[:, None], polar, z)
    z[which == 2] = np.c_[polar[which == 2, 1], np.full((which == 2).sum(), np.nan)]
    run = "smooth" if smooth else "filter"
    assert_agrees(
        getattr(own, run)(t, z, sensor=which),
        getattr(native, run)(t, z, sensor=which),
        1e-8 if smooth else 1e-9,
    )


def test_probability_integral_transform():
    native, own = PAIRS["imm-all-own"]()
    t, z = scene(POSITION, seed=8)
    assert_allclose(own.filter(t, z, outputs=["pit"]).pit, native.filter(t, z, outputs=["pit"]).pit, atol=1e-9)


@pytest.mark.parametrize("name", ["kalman-ct", "kalman-radar", "imm-one-own", "imm-radar"])
def test_live_is_the_batch_filter(name):
    own = PAIRS[name](outliers=ROBUST)[1]
    t, z = scene(own.sensors[0], 40, jumps=True)
    est = own.filter(t, z)
    live = own.start()
    for k in range(40):
        if k == 20:
            live = own.start(state=live.save())
        now = live.update(t[k], None if np.isnan(z[k]).all() else z[k])
        assert_allclose(now.x, est.x[k], rtol=1e-12)
        assert_allclose(now.P, est.P[k], rtol=1e-11)
        assert_allclose(now.mode_probability, est.mode_probability[k], rtol=1e-12)
        assert_allclose(now.log_likelihood, est.log_likelihood_scan[k], rtol=1e-12)
        assert (now.time, now.status) == (t[k], jink.STATUS[est.status[k]])
    assert_allclose(live.predict(t[-1]).x, est.x[-1], rtol=1e-12)
    assert live.predict(t[-1] + 5.0).status == "predicted"
    with pytest.raises(ValueError, match="order of time"):
        live.update(t[0], z[0])
    live.reset()
    assert live.predict(t[-1]).status == "none"


@pytest.mark.parametrize("name", ["kalman-ct", "imm-all-own"])
def test_live_targets_together_equal_the_engine(name):
    native, own = PAIRS[name]()
    n, N, rng = 7, 30, np.random.default_rng(6)
    t = times(N, rng, 0.0)
    z = np.stack([measured(POSITION, t, rng, missing=0.2) for _ in range(n)])
    a, b = native.start(n), own.start(n)
    for k in range(N):
        want, got = a.update(t[k], z[:, k]), b.update(t[k], z[:, k])
        assert_array_equal(got.status, want.status)
        sd = np.sqrt(np.einsum("kii->ki", want.P))
        assert np.nanmax(np.abs(got.x - want.x) / (np.abs(want.x) + sd), initial=0.0) < 1e-9
        assert_allclose(got.nis, want.nis, rtol=1e-8, atol=1e-9)
        if k == N // 2:
            b = own.start(n, state=b.save())
    ahead, expected = b.predict(t[-1] + 3.0), a.predict(t[-1] + 3.0)
    assert_allclose(ahead.mode_probability, expected.mode_probability, atol=1e-9)
    assert np.abs(ahead.x - expected.x).max() < 1e-6


@pytest.mark.parametrize("name", ["kalman-ct", "imm-one-own"])
def test_fixed_lag_is_the_smoother_of_what_was_seen(name):
    own = PAIRS[name]()[1]
    t, z = scene(POSITION, 20)
    live = own.start(lag=3)
    for k in range(20):
        now = live.update(t[k], z[k])
        if k >= 5:
            whole = own.smooth(t[: k + 1], z[: k + 1])
            assert now.time == t[k - 3]
            assert_allclose(now.x, whole.x[k - 3], rtol=1e-9, atol=1e-9)
            assert_allclose(now.mode_probability, whole.mode_probability[k - 3], atol=1e-9)


class Hidden:
    """One of jink's models as one of the user's own."""

    def __init__(self, motion, axes):
        self.native_form, self.name = motion.native(axes), motion.name
        self.components = component_names([motion], axes)
        self.prior_variance = {c: v for c, v in zip(self.components, self.native_form.prior_variance, strict=True) if v}

    def _linearised(self, x, dt):
        n = len(self.components)
        P = np.tile(np.eye(n), (len(dt), 1, 1))
        return _engine.native.linearise_motion(self.native_form, False, dt, x, P, None)

    def f(self, x, dt):
        return self._linearised(x, dt)[0]

    def jacobian(self, x, dt):
        return self._linearised(x, dt)[1]

    def Q(self, dt):
        return self._linearised(np.zeros((len(dt), len(self.components))), dt)[2]


@pytest.mark.parametrize("name", SITUATIONS)
def test_every_situation_of_the_engine(name):
    """Sensors in three axes, Doppler, heights, every noise: with one mode hidden from the engine."""
    twin = SITUATIONS[name]
    native, data = twin.native(), make_data(twin, 40, seed=1)
    motions = [Hidden(native.motions[0], twin.axes), *native.motions[1:]]
    if isinstance(native.motions[0], jink.KnownTurn):  # whose turn rate jink reports
        motions = [*native.motions[:-1], Hidden(native.motions[-1], twin.axes)]
    own = twin.native()
    own.motions = tuple(motions)
    rules = {k: getattr(own, k) for k in ("linearisation", "coast")}
    if len(motions) > 1:
        rules |= {k: getattr(own, k) for k in ("transition", "transition_step", "mode_probability", "mixing")}
    own._prepare(**rules)
    for run in ("filter", "smooth"):
        want, got = (getattr(f, run)(data.time, data.z, **data.keywords()) for f in (native, own))
        assert_agrees(got, want, tolerance_of(name, run == "smooth"))


def test_functions_of_one_elapsed_time_and_another_order_of_components():
    t, z = scene(POSITION)
    want = jink.Kalman(CV, POSITION).filter(t, z)
    got = jink.Kalman(StraightOneStep(0.6), POSITION).filter(t, z)
    assert got.components == ("px", "py", "vx", "vy")
    assert_allclose(got.x[:, [0, 2, 1, 3]], want.x, rtol=1e-9, atol=1e-9)
    mixed = imm([StraightOneStep(0.6), CA, CT], POSITION)
    assert_agrees(mixed.filter(t, z), imm([CV, CA, CT], POSITION).filter(t, z))


def test_jacobians_by_differences():
    """Of f and of h: fourth order, so nine digits remain."""
    t, z = scene(POLAR)
    exact = imm(
        [CV, CT],
        POLAR,
        0.95,
        initial=jink.Prior([1000.0, 0, 2000.0, 0, 0], np.diag([1e4, 4e4, 1e4, 4e4, 1e-3])),
    )
    by_differences = imm([CV, Turning(0.4, 2e-5, 0.05)], Radar(20.0, 0.003, SITE), 0.95, initial=exact.initial)
    assert_agrees(by_differences.filter(t, z), exact.filter(t, z), 1e-7)
    assert_agrees(by_differences.smooth(t, z), exact.smooth(t, z), 1e-6)


@pytest.mark.parametrize("name", ["kalman-radar", "imm-radar"])
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
def test_gating_by_a_sensor_of_ones_own(name, smooth):
    """It has no position to restart from, so neither may the engine."""
    native, own = PAIRS[name](outliers=jink.Outliers(share=0.01, restart_after=0))
    t, z = scene(POLAR, 60, 3)
    z[[20, 21, 40], 0] += 5e4
    want, got = (getattr(f, "smooth" if smooth else "filter")(t, z) for f in (native, own))
    assert 3 in want.status
    assert_agrees(got, want, tolerance_of(name, smooth))


class Dragging:
    """A body that slows down by drag: v' = −drag |v| v."""

    components = ("px", "vx", "py", "vy", "drag")
    prior_variance = {"drag": 1e-8}  # noqa: RUF012
    name = "dragging"

    def f(self, x, dt):
        speed = np.hypot(x[:, 1], x[:, 3])
        slowed = x.copy()
        for p in (0, 2):
            slowed[:, p] += dt * x[:, p + 1]
            slowed[:, p + 1] -= dt * x[:, 4] * speed * x[:, p + 1]
        return slowed

    def Q(self, dt):
        Q = np.zeros((len(dt), 5, 5))
        Q[:, :4, :4] = Straight(0.01).Q(dt)
        Q[:, 4, 4] = 1e-14 * dt
        return Q


def test_components_of_ones_own_names():
    """The union is reported; of a component a mode says nothing of it counts with mean 0, prior variance."""
    f = imm([CV, CT, Dragging()], POSITION)
    assert f.components == ("px", "vx", "py", "vy", "turn_rate", "drag")
    assert f.modes == ("constant_velocity", "coordinated_turn", "dragging")
    t, z = scene(POSITION)
    est = f.filter(t, z)
    assert np.isfinite(est.P[5:]).all() and (np.linalg.eigvalsh(est.P[5:]) > 0).all()
    straight = jink.IMM([CV, Dragging()], POSITION, 0.9999999, mode_probability=[1.0, 0.0]).filter(t[:1], z[:1])
    assert_allclose(straight.sd("drag"), 1e-4)
    assert_allclose(straight["drag"], 0.0)


def test_a_component_enters_from_its_own_prior():
    """Estimated once it matters: the drag of a body that really slows down."""
    t = np.arange(0.0, 60.0, 0.5)
    drag, v0 = 2e-4, 400.0
    x = np.log1p(drag * v0 * t) / drag
    z = np.stack([x, 0.5 * x], axis=1) + np.random.default_rng(0).normal(0, 2.0, (len(t), 2))
    f = jink.Kalman(Dragging(), jink.Position(sd=2.0))
    last = f.filter(t, z)
    assert abs(last["drag"][-1] * np.sqrt(1.25) / drag - 1) < 0.03  # Euler's steps cost 2 %
    assert last.sd("drag")[-1] < 0.02 * drag


class Broken:
    """Standing still, but for what is given."""

    def __init__(self, **functions):
        self.f, self.Q = lambda x, dt: x, lambda dt: np.eye(4)
        vars(self).update(functions)


@pytest.mark.parametrize(
    ("functions", "message"),
    [
        ({"f": lambda x, dt: x[:, :3]}, r"Broken\.f: .*expected shape \(5, 4\).*got \(5, 3\)"),
        ({"f": lambda x, dt: np.linalg.inv(x)}, r"Broken\.f: .*LinAlgError"),
        ({"Q": lambda dt: np.ones(4)}, r"Broken\.Q: .*expected shape .*got \(4,\)"),
        ({"jacobian": lambda x, dt: x}, r"Broken\.jacobian: .*expected shape \(5, 4, 4\)"),
        ({"components": ("px", "px")}, r"Broken\.components: expected different names"),
        (
            {"components": ("px", "vx", "py", "vy", "drag"), "Q": lambda dt: np.eye(5)},
            r"Broken\.prior_variance: expected a variance for 'drag'",
        ),
        ({"prior_variance": {"vz": 1.0}}, r"Broken\.prior_variance: expected some of .*, got 'vz'"),
        ({"Q": lambda dt: np.eye(3)}, r"the state has 3 components in 2 axes; name them"),
    ],
)
def test_what_is_wrong_when_the_filter_is_built(functions, message):
    with pytest.raises(ValueError, match=message):
        jink.Kalman(Broken(**functions), POSITION)


@pytest.mark.parametrize("smooth", [False, True])
def test_nan_of_a_function_names_it_and_the_scan(smooth):
    class Failing(Straight):
        def f(self, x, dt):
            y = super().f(x, dt)
            y[dt == 7.0] = np.nan
            return y

    t, z = np.arange(10.0), np.zeros((10, 2))
    t[6:] += 6.0
    run = getattr(jink.Kalman(Failing(1.0), POSITION), "smooth" if smooth else "filter")
    with pytest.raises(
        ValueError, match=r"Failing\.f: has NaN or infinite values for x \(1, 4\) and dt \(1,\), at scan 6"
    ):
        run(t, z)


def test_errors_of_sensors():
    class Loose(Radar):
        state = None

    class Short(RadarExactly):
        def h(self, x):
            return x[:, 0]

    class Unmeasured(Radar):
        state = ("px", "drag")

    with pytest.raises(ValueError, match=r"Loose: the modes have different states.*attribute state"):
        imm([CV, CA], Loose(1.0, 1.0, SITE), 0.9)
    with pytest.raises(
        ValueError,
        match=r"Unmeasured: the measurement depends on drag; expected it among the components of ConstantVelocity",
    ):
        jink.Kalman(CV, Unmeasured(1.0, 1.0, SITE))
    with pytest.raises(ValueError, match=r"initial: expected jink.Prior.*RadarExactly measures no position"):
        jink.Kalman(CV, OWN_RADAR).filter([0.0], [[1.0, 1.0]])
    with pytest.raises(ValueError, match=r"Short\.h: expected shape \(1, 2\) for x \(1, 4\), got \(1,\), at scan 0"):
        jink.Kalman(CV, Short(1.0, 1.0, SITE), initial=prior(4)).filter([0.0], [[1.0, 1.0]])
    with pytest.raises(TypeError, match="sensor: expected one of jink's sensors or one with h"):
        jink.Kalman(CV, object())
    with pytest.raises(TypeError, match="motions: expected a motion model of jink or one with f"):
        jink.Kalman(object(), POSITION)
    with pytest.raises(ValueError, match=r"input: expected a motion with G\(dt\).*StraightOneStep has none"):
        jink.Kalman(StraightOneStep(1.0), POSITION).filter(np.arange(2.0), np.ones((2, 2)), input=np.ones((2, 2)))
    no_extent = Radar(1.0, 1.0, SITE)
    no_extent.extent = 5.0
    with pytest.raises(ValueError, match=r"Radar\.extent: expected 2 numbers because the filter has outliers"):
        jink.Kalman(CV, no_extent, outliers=ROBUST)


@pytest.mark.parametrize(
    ("time", "z"),
    [
        ([0.0, 0.0, 1.0, 0.5], np.zeros((4, 2))),
        ([0.0, 1.0, 0.0, np.nan], np.zeros((4, 2))),
        ([0.0, 1.0, 0.0, 0.5], [[0, 0], [0, 0], [0, np.inf], [0, 0]]),
    ],
)
def test_wrong_rows_are_refused_in_the_same_words(time, z):
    native, own = PAIRS["kalman-cv"]()
    words = []
    for f in (native, own):
        with pytest.raises(ValueError, match=r"row \d") as error:
            f.filter(time, z, offsets=[0, 2, 2, 4])
        words.append(str(error.value))
    assert words[0] == words[1]


def test_an_exception_of_a_function_says_where():
    class Failing(Straight):
        def f(self, x, dt):
            if (dt == 3.0).any():
                raise ZeroDivisionError("own trouble")
            return super().f(x, dt)

    with pytest.raises(ZeroDivisionError, match="own trouble") as error:
        jink.Kalman(Failing(1.0), POSITION).filter([0.0, 3.0], np.zeros((2, 2)))
    assert error.value.__notes__ == ["raised by Failing.f", "at scan 1"]


@pytest.mark.parametrize("own", [OWN_CV, OWN_CT])
def test_a_saved_filter_names_the_class_and_its_numbers(own, tmp_path):
    """It is read back only where the caller agrees that the module is imported."""
    path, filter = tmp_path / "f.json", jink.IMM([own, CA], POSITION, 0.9)
    filter.save(path)
    assert f'"code": "{type(own).__module__}:{type(own).__name__}"' in path.read_text()
    with pytest.raises(ValueError, match=r"motions\[0\]: is a model of your own, .*own=True"):
        jink.load(path)
    again, (t, z) = jink.load(path, own=True), scene(POSITION, 40, 2)
    assert_array_equal(again.filter(t, z).x, filter.filter(t, z).x)


def test_what_is_not_at_the_top_of_a_module_cannot_be_saved(tmp_path):
    class Local(Straight):
        pass

    with pytest.raises(TypeError, match="is code and cannot be saved to a file, unless its class stands at the top"):
        jink.Kalman(Local(1.0), POSITION).save(tmp_path / "f.json")
    with_code = Straight(1.0)
    with_code.helper = len
    with pytest.raises(TypeError, match=r"Straight.helper: is code and cannot be saved"):
        jink.Kalman(with_code, POSITION).save(tmp_path / "f.json")
    (tmp_path / "g.json").write_text(
        '{"jink": "filter", "version": 1, "units": "SI", "filter": "Kalman",'
        '"sensors": [{"kind": "Position", "sd": 1}],'
        '"motions": [{"kind": "own", "code": "no_such_module:Model"}]}'
    )
    with pytest.raises(ValueError, match="module no_such_module cannot be imported"):
        jink.load(tmp_path / "g.json", own=True)


@pytest.mark.parametrize("sd", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("psd", [1e-6, 1e6])
def test_extremes_stay_finite(sd, psd):
    """Jumps of 50 km, a gap of hours, the noise wrong by orders of magnitude: positive definite all along."""
    f = jink.IMM([Straight(psd), OWN_CA, OWN_CT], jink.Position(sd=sd), SOJOURN)
    t, z = scene(POSITION, 80, 2, jumps=True)
    t[40:] += 1e4
    for est in (f.filter(t, z), f.smooth(t, z)):
        started = est.status > 0
        assert np.isfinite(est.x[started]).all()
        sds = np.sqrt(np.einsum("kii->ki", est.P[started]))
        sds = np.where(sds > 0, sds, 1.0)
        assert np.linalg.eigvalsh(est.P[started] / (sds[:, :, None] * sds[:, None, :])).min() > -1e-10
