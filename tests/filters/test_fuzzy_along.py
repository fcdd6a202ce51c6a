"""Rules along and across the track: the textbook, turned and mirrored planes, files, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle.fuzzy import Rules
from oracle.fuzzy_along import fuzzy_imm_along_track
from test_native_adaptive import R, assert_same, position, reports, stay
from test_native_learned import TABLES

import jink
from jink.filters.fuzzy_imm import fuzzy_imm
from jink.filters.loading import load

ACROSS = [
    [(0.0, 5.0, 0.0, 6.0, 0.5), (8.0, 5.0, 2.0, 8.0, 9.0)],
    [(2.0, 4.0, -1.0, 7.0, 30.0), (12.0, 6.0, 3.0, 6.0, 200.0), (20.0, 9.0, 0.0, 9.0, 500.0)],
]


def modes(along=TABLES, across=ACROSS, starts=(1.0, 5.0)):
    return [
        jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=sd), jink.FuzzyRules.of(a), jink.FuzzyRules.of(c))
        for sd, a, c in zip(starts, along, across, strict=False)
    ]


def oracle(along=TABLES, across=ACROSS):
    return [(Rules.table(a), Rules.table(c)) for a, c in zip(along, across, strict=True)]


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_as_the_textbook_has_it(axes):
    """One filter, and an IMM; a scan that is missed, whole or in part, keeps the last variances."""
    time, z = reports(axes)
    z[2, 2] = np.nan  # nothing measured yet: the declared variance holds
    alone = fuzzy_imm_along_track(time, z, R(axes), oracle()[:1], np.ones((1, 1)), np.ones(1), [1.0])
    assert_same(jink.Kalman(modes()[0], position(axes)), alone, time, z)
    mu = np.array([0.6, 0.4])
    both = fuzzy_imm_along_track(time, z, R(axes), oracle(), stay(0.9, 2), mu, [1.0, 25.0])
    assert_same(jink.IMM(modes(), position(axes), 0.9, mode_probability=mu), both, time, z)


def along_track():
    return jink.IMM(modes(), position(2), 0.9, mode_probability=[0.6, 0.4])


@pytest.mark.parametrize("turn", [0.3, 1.0, np.pi / 2, 2.0, np.pi])
def test_a_turned_plane_turns_the_answer(turn):
    time, z = reports(2, tracks=2)
    M = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    plain, turned = along_track().filter(time, z[0]), along_track().filter(time, z[0] @ M.T)
    four = np.kron(M, np.eye(2))
    assert_allclose(turned.x, plain.x @ four.T, rtol=1e-9, atol=1e-6)
    assert_allclose(turned.P, four @ plain.P @ four.T, rtol=1e-9, atol=1e-6)
    assert_allclose(turned.mode_probability, plain.mode_probability, atol=1e-9)


def test_a_mirrored_plane_mirrors_the_answer():
    time, z = reports(2, tracks=2)
    plain, other = along_track().filter(time, z[0]), along_track().filter(time, z[0] * [1.0, -1.0])
    assert_allclose(other.x, plain.x * [1.0, 1.0, -1.0, -1.0], rtol=1e-9, atol=1e-6)


def test_noise_of_both_directions_alike_is_that_of_the_axes():
    """Rules that say one constant everywhere: Q has no direction, and the filter is the plain one."""
    time, z = reports(2, tracks=2)
    rules = jink.FuzzyRules.constant(3.0, 10.0)
    fuzzy = jink.Kalman(jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=3.0), rules, rules), position(2))
    plain = jink.Kalman(jink.ConstantVelocity(acceleration_sd=3.0), position(2))
    assert_allclose(fuzzy.filter(time, z[0]).x, plain.filter(time, z[0]).x, rtol=1e-9)


def test_a_target_that_turns_has_noise_across_its_track():
    """Rules that allow noise across the track only: velocity along it is known far better than across it."""
    time = np.arange(40.0)
    z = np.column_stack([100.0 * time, 60.0 * time]) + np.random.default_rng(3).normal(0, 5.0, (40, 2))
    quiet, loud = jink.FuzzyRules.constant(0.1, 10.0), jink.FuzzyRules.constant(10.0, 10.0)
    filter = jink.Kalman(jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=1.0), quiet, loud), position(2))
    P = filter.filter(time, z).P[-1][1::2, 1::2]
    e = np.array([100.0, 60.0]) / np.hypot(100.0, 60.0)
    n = np.array([-e[1], e[0]])
    assert e @ P @ e < 0.05 * (n @ P @ n)


def test_a_saved_filter_is_the_same(tmp_path):
    time, z = reports(2, tracks=2)
    along_track().save(tmp_path / "filter.json")
    assert np.array_equal(load(tmp_path / "filter.json").filter(time, z[0]).x, along_track().filter(time, z[0]).x)


def test_smoothed_and_live_as_in_batches():
    time, z = reports(2, tracks=2)
    batch = along_track().filter(time, z[0])
    track = along_track().start()
    for t, row in zip(time, z[0], strict=True):
        last = track.update(t, row)
    assert_allclose(last.x, batch.x[-1], rtol=1e-9)
    smooth = along_track().smooth(time, z[0])
    assert np.isfinite(smooth.x[1:]).all() and not np.allclose(smooth.x[20], batch.x[20])


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (
            lambda: jink.FuzzyNoise(jink.ConstantAcceleration(jerk_psd=1.0), *[jink.FuzzyRules.constant(1.0, 9.0)] * 2),
            "FuzzyNoise.across: expected the motion ConstantVelocity, got ConstantAcceleration",
        ),
        (
            lambda: jink.FuzzyNoise(
                jink.ConstantVelocity(acceleration_sd=(1.0, 2.0)), *[jink.FuzzyRules.constant(1.0, 9.0)] * 2
            ),
            "FuzzyNoise.across: expected a motion with one noise for all axes",
        ),
        (
            lambda: fuzzy_imm(position(2), [jink.FuzzyRules.constant(1.0, 9.0)] * 2, across=[]),
            "across: expected one rule table for each of the 2 modes, got 0",
        ),
        (
            lambda: fuzzy_imm(position(2), across="lee"),
            "across: expected rule tables or one of lee-2003, got 'lee'",
        ),
    ],
)
def test_what_does_not_fit_is_refused(wrong, words):
    with pytest.raises(ValueError, match=words.replace("(", r"\(")):
        wrong()


def test_rules_of_another_kind_are_refused():
    with pytest.raises(TypeError, match=r"FuzzyNoise.across: expected FuzzyRules, got float"):
        jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=1.0), jink.FuzzyRules.constant(1.0, 9.0), 3.0)  # pyright: ignore[reportArgumentType]


def test_rules_in_kilometres_are_refused():
    far = jink.FuzzyRules.constant(1.0, 0.01)
    with pytest.raises(ValueError, match=r"residuals up to 0\.02 m"):
        jink.Kalman(
            jink.FuzzyNoise(jink.ConstantVelocity(acceleration_sd=1.0), jink.FuzzyRules.constant(1.0, 9.0), far),
            position(2),
        ).filter(*(a[0] if a.ndim == 3 else a for a in reports(2)))
