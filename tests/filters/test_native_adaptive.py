"""The native adaptive filters against the textbook, to 1e-9 scaled by conditioning: irregular steps, whole and partial
misses.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from oracle import many
from oracle import motion as om
from oracle.acceleration_limits import SurprisedStatistical
from oracle.adaptive_imm import adaptive_imm, levels
from oracle.chain import Sojourn
from oracle.current_statistical import CurrentStatistical, FuzzyCurrentStatistical
from oracle.pseudo_bayesian import gpb1, gpb2, static
from oracle.two_stage import augmented, two_stage
from oracle.variable_structure import (
    acceleration_grid,
    graph_transition,
    most_probable,
    neighbours,
    one_change,
    switched,
    variable_structure,
)

import jink
from jink.filters.adaptive_imm import aimm
from jink.filters.variable_structure import line_graph, line_transition

SD = 5.0
TOLERANCE = 1e-9


def reports(axes, tracks=6, scans=45, seed=1, misses=True):
    """Manoeuvring tracks (B, N, axes) at common irregular times, seen with 5 m; scans missing whole and in part."""
    rng = np.random.default_rng([seed, axes])
    time = np.cumsum(rng.uniform(0.3, 2.0, scans))
    acceleration = rng.normal(0, 4, (tracks, scans, axes)) + 15.0 * (rng.random((tracks, scans, 1)) < 0.15)
    dt = np.diff(time, prepend=time[0])[:, None]
    velocity = 30.0 + np.cumsum(acceleration * dt, axis=1)
    z = np.cumsum(velocity * dt, axis=1) + rng.normal(0, SD, (tracks, scans, axes))
    if misses:
        z[:, 9] = np.nan
        z[0, 15:18] = np.nan
        z[-1, 20, 0] = z[1, 30, -1] = np.nan
    return time, z


def run(filter, time, z):
    """x (B, N, n), P, mode probabilities of the native filter, all tracks in one batch."""
    B, N, axes = z.shape
    est = filter.filter(np.tile(time, B), z.reshape(-1, axes), offsets=np.arange(B + 1) * N)
    return tuple(a.reshape(B, N, *a.shape[1:]) for a in (est.x, est.P, est.mode_probability))


def assert_close(got, x, P, mu=None, rows=slice(1, None), tolerance=TOLERANCE):
    """x over |x| + sd, P over sd sd', probabilities absolute; scaled by the covariances' conditioning over 1e5."""
    x, P = x[:, rows], P[:, rows]
    sd = np.sqrt(np.einsum("...ii->...i", P))
    present = np.where(sd > 0, sd, 1.0)
    unit = P / (present[..., :, None] * present[..., None, :]) + (sd == 0)[..., None] * np.eye(P.shape[-1])
    scale = max(1.0, float(np.linalg.cond(unit).max()) / 1e5)
    far = {
        "x": np.abs(got[0][:, rows] - x) / (np.abs(x) + present),
        "P": np.abs(got[1][:, rows] - P) / (present[..., :, None] * present[..., None, :]),
    }
    if mu is not None:
        far["mu"] = np.abs(got[2][:, rows] - mu[:, rows])
    assert {k: f"{v.max():.1e}" for k, v in far.items() if not v.max() <= tolerance * scale} == {}, scale


def assert_same(filter, oracle, time, z):
    assert_close(run(filter, time, z), oracle.x, oracle.P, oracle.mu)


def position(axes):
    return jink.Position(sd=SD, axes=axes)


def R(axes):
    return SD**2 * np.eye(axes)


def stay(p, M):
    return np.full((M, M), (1 - p) / (M - 1)) + np.eye(M) * (p - (1 - p) / (M - 1))


LIMITS = jink.FuzzyLimits(threshold=40.0, up=0.9, down=1.02, operating=36.0)
TWO_SIDED = jink.FuzzyLimits(threshold=40.0, up=0.9, down=1.1, operating=36.0, threshold_down=25.0, operating_down=20.0)
TRIANGULAR = jink.FuzzyLimits(threshold=40.0, up=0.9, down=1.3, operating=36.0, membership="triangular")
ACROSS = jink.FuzzyLimits(threshold=20.0, up=0.8, down=0.8, operating=18.0)
SIDES = {"threshold": 40.0, "threshold_min": -25.0, "k1": 0.9, "k2": 1.1}


def statistical(**more):
    return jink.CurrentStatistical(**more, time_constant=12.0, acceleration_prior_sd=8.0)


def surprised(axes, **more):
    return SurprisedStatistical(axes, 12.0, acceleration_prior_sd=8.0, **more)


def across(axes):
    return FuzzyCurrentStatistical(axes, 12.0, threshold=20.0, k1=0.8, k2=0.8)


MOTIONS = {  # the same model twice: jink's, and the oracle's of so many axes
    "cv": (jink.ConstantVelocity(acceleration_sd=0.7), partial(om.ConstantVelocity, acceleration_sd=0.7)),
    "brisk": (
        jink.ConstantVelocity(acceleration_psd=30.0),
        partial(om.ConstantVelocity, acceleration_psd=30.0),
    ),
    "ca": (
        jink.ConstantAcceleration(jerk_psd=0.5, acceleration_prior_sd=8.0),
        partial(om.ConstantAcceleration, jerk_psd=0.5, acceleration_prior_sd=8.0),
    ),
    "singer": (
        jink.Singer(acceleration_sd=5.0, time_constant=15.0),
        partial(om.Singer, acceleration_sd=5.0, time_constant=15.0),
    ),
    "left": (
        jink.KnownTurn(0.06, acceleration_sd=2.0),
        partial(om.KnownTurn, turn_rate=0.06, acceleration_sd=2.0),
    ),
    "csaf": (
        jink.CurrentStatistical(acceleration_max=30.0, time_constant=12.0, acceleration_prior_sd=8.0),
        partial(CurrentStatistical, acceleration_max=30.0, time_constant=12.0, acceleration_prior_sd=8.0),
    ),
    "csaf-low": (  # accelerations go beyond these limits, which do not freeze it
        jink.CurrentStatistical(
            acceleration_max=6.0, acceleration_min=3.0, time_constant=12.0, acceleration_prior_sd=8.0
        ),
        partial(
            CurrentStatistical,
            acceleration_max=6.0,
            acceleration_min=-3.0,
            time_constant=12.0,
            acceleration_prior_sd=8.0,
        ),
    ),
    "facs": (
        jink.CurrentStatistical(limits=LIMITS, time_constant=12.0, acceleration_prior_sd=8.0),
        partial(
            FuzzyCurrentStatistical,
            time_constant=12.0,
            threshold=40.0,
            k1=0.9,
            k2=1.02,
            acceleration_prior_sd=8.0,
        ),
    ),
    "facs-sides": (statistical(limits=TWO_SIDED), partial(surprised, **SIDES)),
    "facs-triangular": (
        statistical(limits=TRIANGULAR),
        partial(surprised, threshold=40.0, k1=0.9, k2=1.3, straight=True),
    ),
    "facs-wide": (
        statistical(limits=TWO_SIDED, widening=jink.LimitWidening(nis=6.0, times=1.5)),
        partial(surprised, **SIDES, nis=6.0, times=1.5),
    ),
    "facs-along": (
        statistical(limits=TWO_SIDED, across=ACROSS),
        lambda axes: surprised(axes, **SIDES, across=across(axes)),
    ),
    "facs-along-wide": (
        statistical(limits=TWO_SIDED, across=ACROSS, widening=jink.LimitWidening(nis=6.0, times=1.5)),
        lambda axes: surprised(axes, **SIDES, across=across(axes), nis=6.0, times=1.5),
    ),
    "csaf-wide": (
        statistical(acceleration_max=9.0, widening=jink.LimitWidening(nis=8.0, times=3.0)),
        partial(surprised, threshold=9.0, k1=0.0, k2=0.0, nis=8.0, times=3.0),
    ),
}
LIMITED = ["facs-sides", "facs-triangular", "facs-wide", "facs-along", "facs-along-wide", "csaf-wide"]


def bank(names, axes):
    """jink's and the oracle's motion models."""
    return [MOTIONS[n][0] for n in names], [MOTIONS[n][1](axes) for n in names]


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("name", ["csaf", "csaf-low", "facs", *LIMITED])
def test_current_statistical(name, axes):
    time, z = reports(axes)
    native, oracle = bank([name], axes)
    want = many.imm(oracle, time, z, R(axes), np.ones((1, 1)), np.ones(1))
    assert_same(jink.Kalman(native[0], position(axes)), want, time, z)
    if name == "csaf-low":
        a = want.x[:, 5:, 2::3]
        assert (a > 6.0).any() and (a < -3.0).any()


@pytest.mark.parametrize("angle", [0.4, 2.0])
def test_limits_along_the_track_turn_with_the_plane(angle):
    """And limits of each axis do not, so that the test can fail."""
    time, z = reports(2, misses=False)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    whole = np.kron(turn, np.eye(3))
    far = {}
    for name in ("facs-wide", "facs-along-wide"):
        f = jink.Kalman(MOTIONS[name][0], position(2))
        x, P, _ = run(f, time, z)
        turned_x, turned_P, _ = run(f, time, z @ turn.T)
        sd = np.sqrt(np.einsum("...ii->...i", turned_P[:, 1:]))
        far[name] = np.max(np.abs(turned_x - x @ whole.T)[:, 1:] / (np.abs(turned_x[:, 1:]) + sd))
        far[name] = max(far[name], np.max(np.abs(turned_P - whole @ P @ whole.T)[:, 1:] / (sd[..., None] ** 2).max()))
    assert far["facs-along-wide"] < 1e-9 < 1e-3 < far["facs-wide"]


BANKS = [["cv", "facs"], ["brisk", "csaf"], ["csaf", "facs"], ["cv", "ca", "facs"]]
BANKS += [["cv", name] for name in LIMITED]


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("names", BANKS, ids="+".join)
def test_current_statistical_modes_in_an_imm(names, axes):
    time, z = reports(axes)
    native, oracle = bank(names, axes)
    M = len(names)
    Pi, mu = stay(0.9, M), np.arange(1.0, M + 1) / np.arange(1.0, M + 1).sum()
    want = many.imm(oracle, time, z, R(axes), Pi, mu)
    assert_same(jink.IMM(native, position(axes), Pi, mode_probability=mu), want, time, z)


BIAS = {"sd": 0.7, "bias_sd": 3.0, "bias_prior": 64.0}
ESTIMATORS = {
    "two-stage": jink.TwoStageAcceleration(acceleration_sd=0.7, bias_sd=3.0, bias_prior_sd=8.0),
    "augmented": jink.AugmentedAcceleration(acceleration_sd=0.7, bias_sd=3.0, bias_prior_sd=8.0),
}


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("name", ESTIMATORS)
def test_estimators_of_the_acceleration(name, axes):
    """The joint filter is a filter along each axis."""
    time, z = reports(axes)
    z[np.isnan(z).any(axis=2)] = np.nan  # a partial miss is tested below, axis by axis
    oracle = {"two-stage": two_stage, "augmented": augmented}[name]
    each = oracle(time, many.each_axis(z)[..., 0], SD**2, **BIAS)
    x, P = many.joined(each.x, axes), many.joined(each.P, axes)
    whole = np.zeros((*z.shape[:2], 3 * axes, 3 * axes))
    for a in range(axes):
        whole[..., 3 * a : 3 * a + 3, 3 * a : 3 * a + 3] = P[:, :, a]
    got = run(jink.Kalman(ESTIMATORS[name], position(axes)), time, z)
    assert_close(got, x.reshape(*z.shape[:2], -1), whole)


def test_a_partial_miss_is_a_miss_of_its_axis():
    time, z = reports(2)
    each = two_stage(time, many.each_axis(z)[..., 0], SD**2, **BIAS)
    got = run(jink.Kalman(ESTIMATORS["two-stage"], position(2)), time, z)[0]
    want = many.joined(each.x, 2).reshape(*z.shape[:2], -1)
    np.testing.assert_allclose(got[:, 1:], want[:, 1:], rtol=1e-9, atol=1e-8)


def test_two_stage_without_bias_noise_is_the_augmented_filter():
    time, z = reports(2)
    noises = {"acceleration_sd": 0.7, "bias_sd": 0.0, "bias_prior_sd": 8.0}
    a, b = (
        run(jink.Kalman(kind(**noises), position(2)), time, z)
        for kind in (jink.TwoStageAcceleration, jink.AugmentedAcceleration)
    )
    assert_close(a, b[0], b[1])
    sd = np.sqrt(np.einsum("...ii->...i", b[1]))[:, 1:]
    assert np.max(np.abs(a[0] - b[0])[:, 1:] / (np.abs(b[0])[:, 1:] + sd)) < 1e-12


@pytest.mark.parametrize("side", ESTIMATORS)
@pytest.mark.parametrize("intervals", [[20.0], [10.0, 20.0]], ids=["aimm3", "aimm5"])
def test_adaptive_imm_along_one_axis(intervals, side):
    time, z = reports(1)
    M = 2 * len(intervals) + 1
    mu = np.array([0.6, *[0.4 / (M - 1)] * (M - 1)])
    want = adaptive_imm(time, z, R(1), intervals, 0.7, 3.0, 64.0, stay(0.97, M), mu, side)
    rising = sorted(levels(intervals))
    f = aimm(rising, position(1), 0.97, acceleration_sd=0.7, estimator=ESTIMATORS[side])
    want.mu = want.mu[..., [list(levels(intervals)).index(v) for v in rising]]
    assert_same(f, want, time, z)


@pytest.mark.parametrize("side", ESTIMATORS)
def test_adaptive_imm_with_levels_in_standard_deviations(side):
    time, z = reports(1)
    M, counts = 5, [1.0, 2.5]
    mu = np.array([0.6, *[0.4 / (M - 1)] * (M - 1)])
    want = adaptive_imm(time, z, R(1), counts, 0.7, 3.0, 64.0, stay(0.97, M), mu, side, in_sd=True)
    rising = sorted(levels(counts))
    f = aimm(rising, position(1), 0.97, acceleration_sd=0.7, estimator=ESTIMATORS[side], in_sd=True)
    want.mu = want.mu[..., [list(levels(counts)).index(v) for v in rising]]
    assert_same(f, want, time, z)
    fixed = aimm(rising, position(1), 0.97, acceleration_sd=0.7, estimator=ESTIMATORS[side])
    assert np.nanmax(np.abs(run(f, time, z)[0] - run(fixed, time, z)[0])) > 1.0


@pytest.mark.parametrize("side", ESTIMATORS)
def test_adaptive_imm_in_the_plane(side):
    """One set of levels, added on both axes, as the oracle has them."""
    time, z = reports(2)
    z[np.isnan(z).any(axis=2)] = np.nan
    mu = np.array([0.6, 0.2, 0.2])
    want = adaptive_imm(time, z, R(2), [20.0], 0.7, 3.0, 64.0, stay(0.97, 3), mu, side)
    cv = jink.ConstantVelocity(acceleration_sd=0.7)
    motions = [jink.AccelerationLevel(cv, level, estimated=True) for level in levels([20.0])]
    f = jink.AdaptiveIMM(motions, position(2), 0.97, estimator=ESTIMATORS[side], mode_probability=mu)
    assert_same(f, want, time, z)


MIXED = [["cv", "brisk"], ["cv", "ca"], ["cv", "brisk", "ca"], ["ca", "singer", "cv"], ["facs", "cv"]]


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("names", MIXED, ids="+".join)
@pytest.mark.parametrize("method", ["gpb1", "gpb2", "mm"])
def test_other_interactions(method, names, axes):
    """Modes of the same and of different dimensions."""
    time, z = reports(axes)
    native, oracle = bank(names, axes)
    M = len(names)
    Pi, mu = stay(0.9, M), np.arange(1.0, M + 1) / np.arange(1.0, M + 1).sum()
    if method == "mm":
        want = static(oracle, time, z, R(axes), mu)
        f = jink.StaticMM(native, position(axes), mode_probability=mu)
    else:
        want = {"gpb1": gpb1, "gpb2": gpb2}[method](oracle, time, z, R(axes), Pi, mu)
        f = {"gpb1": jink.GPB1, "gpb2": jink.GPB2}[method](native, position(axes), Pi, mode_probability=mu)
    assert_same(f, want, time, z)


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("method", ["ds", "ad"])
def test_variable_structure_over_noise_levels(method, axes):
    """Slots that take on the numbers of the modes alive."""
    time, z = reports(axes)
    M, first = 12, 3
    sds = np.geomspace(0.3, 30.0, M)
    native = [jink.ConstantVelocity(acceleration_sd=sd) for sd in sds]
    oracle = [om.ConstantVelocity(axes, acceleration_sd=sd) for sd in sds]
    graph = neighbours(M, 1)
    Pi = graph_transition(graph, 0.9)
    np.testing.assert_allclose(line_transition(M, 1, 0.9), Pi)
    if method == "ds":
        f, propose = (
            jink.DigraphSwitching(native, position(axes), Pi, first_mode=first),
            partial(switched, graph),
        )
    else:
        f, propose = (
            jink.ActiveDigraph(native, position(axes), Pi, first_mode=first),
            partial(most_probable, 3),
        )
    got = run(f, time, z)
    want = variable_structure(oracle, time, z, R(axes), Pi, got[2][0, 1], propose)
    assert_close(got, want.x, want.P, want.mu)
    likeliest = want.mu[:, 2:].argmax(axis=-1)
    assert len(np.unique(likeliest)) >= 5  # the sets did move
    assert ((got[2] > 0).sum(axis=-1)[:, 1:] <= 3).all()


@pytest.mark.parametrize("method", ["ds", "ad"])
def test_variable_structure_in_continuous_time(method):
    """Which modes are likeliest next depends on how long it is until then."""
    time, z = reports(2)
    time = np.cumsum(np.where(np.arange(len(time)) % 7 == 3, 20.0, 1.0) * np.diff(time, prepend=0.0))
    M, sds = 9, np.geomspace(0.3, 30.0, 9)
    native = [jink.ConstantVelocity(acceleration_sd=sd) for sd in sds]
    oracle = [om.ConstantVelocity(2, acceleration_sd=sd) for sd in sds]
    graph = neighbours(M, 2)
    chain = jink.Sojourn(seconds=np.linspace(3.0, 15.0, M).tolist(), to=graph_transition(graph, 0.0))
    kind, propose = {
        "ds": (jink.DigraphSwitching, partial(switched, graph)),
        "ad": (partial(jink.ActiveDigraph, alive=4), partial(most_probable, 4)),
    }[method]
    got = run(kind(native, position(2), chain, first_mode=4), time, z)
    over = one_change(chain.generator(M))
    want = variable_structure(oracle, time, z, R(2), over, got[2][0, 1], propose)
    assert_close(got, want.x, want.P, want.mu, tolerance=1e-8)  # ill-conditioned after steps of half a minute
    as_if_a_second = variable_structure(oracle, time, z, R(2), over(1.0), got[2][0, 1], propose)
    assert np.abs(as_if_a_second.mu - want.mu)[:, 2:].max() > 0.1


@pytest.mark.parametrize("reach", [1, 2])
def test_digraph_switching_over_another_graph(reach):
    """A graph that is given beside the transition matrix."""
    time, z = reports(2)
    sds = np.geomspace(0.3, 30.0, 7)
    native = [jink.ConstantVelocity(acceleration_sd=sd) for sd in sds]
    oracle = [om.ConstantVelocity(2, acceleration_sd=sd) for sd in sds]
    Pi = stay(0.85, 7)
    f = jink.DigraphSwitching(native, position(2), Pi, graph=line_graph(7, reach))
    got = run(f, time, z)
    want = variable_structure(oracle, time, z, R(2), Pi, got[2][0, 1], partial(switched, neighbours(7, reach)))
    assert_close(got, want.x, want.P, want.mu)


@pytest.mark.parametrize("method", ["ds", "ad"])
@pytest.mark.parametrize("names", [["cv", "ca", "singer", "brisk"], ["cv", "brisk", "ca", "facs"]], ids="+".join)
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_variable_structure_over_different_motion_models(method, names, axes):
    time, z = reports(axes)
    native, oracle = bank(names, axes)
    graph = neighbours(len(names), 1)
    Pi = graph_transition(graph, 0.9)
    if method == "ds":
        f, propose = jink.DigraphSwitching(native, position(axes), Pi), partial(switched, graph)
    else:
        f, propose = jink.ActiveDigraph(native, position(axes), Pi, alive=2), partial(most_probable, 2)
    got = run(f, time, z)
    want = variable_structure(oracle, time, z, R(axes), Pi, got[2][0, 1], propose)
    assert_close(got, want.x, want.P, want.mu)
    assert len(np.unique(want.mu[:, 2:].argmax(axis=-1))) >= 2


class OneTurn(om.CoordinatedTurn):
    """The coordinated turn for a batch of one track."""

    def f(self, x, dt):
        return super().f(x[0], dt)[None]

    def F(self, x, dt):
        return super().F(x[0], dt)


@pytest.mark.parametrize("method", ["ds", "ad", "gpb1", "gpb2", "mm"])
def test_straight_accelerated_and_turning(method):
    """Modes of three kinds and dimensions, one track at a time; acceleration and turn rate are checked in
    test_oracle_native.
    """
    time, z = reports(2)
    ct = {"acceleration_sd": 0.8, "turn_rate_sd": 0.01, "turn_rate_prior_sd": 0.1}
    native = [MOTIONS["cv"][0], MOTIONS["ca"][0], jink.CoordinatedTurn(**ct)]
    oracle = [MOTIONS["cv"][1](2), MOTIONS["ca"][1](2), OneTurn(2, **ct)]
    Pi = np.array([[0.8, 0.1, 0.1], [0.2, 0.8, 0.0], [0.2, 0.0, 0.8]])
    mu = np.full(3, 1 / 3)
    if method in ("ds", "ad"):
        kind = {"ds": jink.DigraphSwitching, "ad": partial(jink.ActiveDigraph, alive=2)}[method]
        f = kind(native, position(2), Pi)
        propose = {"ds": partial(switched, Pi > 0), "ad": partial(most_probable, 2)}[method]
    elif method == "mm":
        f = jink.StaticMM(native, position(2), mode_probability=mu)
    else:
        f = {"gpb1": jink.GPB1, "gpb2": jink.GPB2}[method](native, position(2), Pi, mode_probability=mu)
    got = run(f, time, z)
    for b in range(len(z)):
        one = z[b : b + 1]
        if method in ("ds", "ad"):
            want = variable_structure(oracle, time, one, R(2), Pi, got[2][b, 1], propose)
        elif method == "mm":
            want = static(oracle, time, one, R(2), mu)
        else:
            want = {"gpb1": gpb1, "gpb2": gpb2}[method](oracle, time, one, R(2), Pi, mu)
        pv = [0, 1, 3, 4]
        mine = tuple(a[b : b + 1] for a in got)
        block = np.ix_(range(1), range(len(time)), pv, pv)
        assert_close((mine[0][..., pv], mine[1][block], mine[2]), want.x[..., pv], want.P[block], want.mu)


def test_adaptive_grid_over_acceleration_levels():
    """Modes that differ in their known acceleration: a point lies anywhere between two of them."""
    time, z = reports(1)
    half, M = 20.0, 41
    cv = jink.ConstantVelocity(acceleration_sd=0.7)
    motions = [jink.AccelerationLevel(cv, v) for v in np.linspace(-half, half, M)]
    f = jink.AdaptiveGrid(motions, position(1), 0.9, unlikely=0.1, likely=0.9)
    got = run(f, time, z)
    want, grids = acceleration_grid(time, z, R(1), 0.7, stay(0.9, 3), np.full(3, 1 / 3), half, 1.0)
    assert_close(got, want.x, want.P)
    assert np.ptp(grids[:, -1, 1]) > 1.0  # the grids did move
    shared = np.zeros_like(got[2])  # each point's probability, shared out between the two levels it lies between
    for j in range(3):
        place = grids[..., j] + half
        low = np.minimum(place.astype(int), M - 2)
        for step, share in ((0, low + 1 - place), (1, place - low)):
            b, k = np.indices(low.shape)
            np.add.at(shared, (b, k, low + step), share * np.nan_to_num(want.mu[..., j]))
    np.testing.assert_allclose(got[2][:, 1:], shared[:, 1:], atol=1e-8)


def test_sojourn_times_reach_every_interaction():
    """A continuous-time chain: exp(G dt) over each step."""
    time, z = reports(2)
    native, oracle = bank(["cv", "brisk"], 2)
    chain = Sojourn([30.0, 8.0])
    for method, kind in ((gpb1, jink.GPB1), (gpb2, jink.GPB2)):
        f = kind(native, position(2), jink.Sojourn(seconds=[30.0, 8.0]))
        got = run(f, time, z[:1])
        at = np.flatnonzero(np.diff(time) > 0)
        want = method(oracle, time[:3], z[:1, :3], R(2), chain.over(time[2] - time[1]), chain.stationary())
        assert len(at) and np.allclose(got[2][0, 2], want.mu[0, 2], rtol=1e-9)
