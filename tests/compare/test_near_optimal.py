"""The near-optimal reference: published figures, consistency, and exact answers where there are any."""

from __future__ import annotations

from itertools import product

import families
import numpy as np
import pytest

import jink
from jink.compare import near_optimal
from jink.compare.priors import RandomAccelerations, RandomTurns

RUNS, FIRST = 300, 5


def rmse(error):
    """RMSE over runs and scans, both axes together, and its standard error."""
    square = (error[:, FIRST:] ** 2).sum(axis=2).mean(axis=1)
    value = np.sqrt(square.mean())
    return value, square.std(ddof=1) / np.sqrt(len(square)) / (2 * value)


def nees_per_component(runs, reference, names=("px", "vx", "py", "vy")):
    index = [reference.components.index(name) for name in names]
    truth = np.stack([runs.position, runs.velocity], axis=-1).reshape(*runs.position.shape[:2], 4)
    e = (reference.x[..., index] - truth)[:, FIRST:]
    P = reference.P[:, FIRST:][..., index, :][..., index]
    squares = np.einsum("rki,rkij,rkj->rk", e, np.linalg.inv(P), e) / 4
    assert np.allclose(reference.nees(runs.position, runs.velocity)[:, FIRST:], squares, rtol=1e-6)
    nees = squares.mean(axis=1)
    return nees.mean(), nees.std(ddof=1) / np.sqrt(len(nees))


CASES = {
    "random-accelerations": (
        families.random_accelerations,
        RandomAccelerations(),
        (387.7, 1.9),
        (125.5, 1.0),
    ),
    "random-turns": (
        lambda n, s: families.random_turns(n, s)[0],
        RandomTurns(),
        (37.99, 0.17),
        (14.85, 0.15),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_published_figures_and_consistency(name):
    generate, prior, *published = CASES[name]
    runs = generate(RUNS, 7)
    reference = near_optimal(runs.measured, prior, sd=runs.sd)
    errors = reference.position - runs.position, reference.velocity - runs.velocity
    for error, (value, se) in zip(errors, published, strict=True):
        mine, my_se = rmse(error)
        assert abs(mine - value) < 3 * np.hypot(se, my_se)
    consistency, se = nees_per_component(runs, reference)
    assert abs(consistency - 1) < 3 * se + 0.01


@pytest.mark.parametrize("name", CASES)
def test_more_hypotheses_change_nothing(name):
    generate, prior, *_ = CASES[name]
    runs = generate(100, 3)
    few, many = (near_optimal(runs.measured, prior, sd=runs.sd, hypotheses=K) for K in (32, 64))
    for quantity in ("position", "velocity"):
        truth = getattr(runs, quantity)
        ratio = rmse(getattr(few, quantity) - truth)[0] / rmse(getattr(many, quantity) - truth)[0]
        assert ratio == pytest.approx(1, abs=0.003)


def test_on_the_fixed_scenario_it_believes_in_random_manoeuvres():
    runs = families.lee(RUNS, 7)
    reference = near_optimal(runs.measured, RandomAccelerations(), sd=500.0)
    position, p_se = rmse(reference.position - runs.position)
    velocity, v_se = rmse(reference.velocity - runs.velocity)
    assert abs(position - 342.4) < 3 * np.hypot(p_se, 1.4)  # published without error, from 500 runs
    assert abs(velocity - 87.3) < 3 * np.hypot(v_se, 0.4)


@pytest.mark.parametrize("prior", [RandomAccelerations(quiet_time=1e12), RandomTurns(quiet_time=1e12)])
def test_without_manoeuvres_it_is_the_kalman_filter(prior):
    runs = families.lee(3, 1, scans=40)
    reference = near_optimal(runs.measured, prior, sd=500.0)
    kalman = jink.Kalman(
        jink.ConstantVelocity(acceleration_sd=1.0),
        jink.Position(sd=500.0),
        initial=jink.OnePoint(velocity_sd=1e5),
    )
    estimate = kalman.filter(np.tile(np.arange(40.0), 3), runs.measured.reshape(-1, 2), offsets=np.arange(4) * 40)
    index = [reference.components.index(name) for name in kalman.components]
    later = slice(2, None)
    assert np.allclose(reference.x[:, later, index], estimate.x.reshape(3, 40, 4)[:, later], rtol=1e-5, atol=0.05)
    cov = reference.P[..., index, :][..., index][:, later]
    assert np.allclose(cov, estimate.P.reshape(3, 40, 4, 4)[:, later], rtol=1e-3, atol=1)


def exact(z, prior, sd):
    """Posterior mean of [p v] of the last scan by enumerating what happens in every scan (one axis)."""
    scans = len(z)
    F = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
    G = np.array([0.5, 1.0, 0.0])
    total, mean = 0.0, np.zeros(2)
    levels = prior.levels()
    for path in product((0, 1), repeat=scans - 1):
        starts = [k for k, b in enumerate(path) if b and (k == 0 or not path[k - 1])]
        for choice in product(levels, repeat=len(starts)):
            x, P = np.array([z[0], 0, 0]), np.diag([sd**2, 1e10, 0.0])
            log_p, chosen = 0.0, iter(choice)
            for k, busy in enumerate(path):
                before = path[k - 1] if k else 0
                chance = 1 / prior.manoeuvre_time if before else 1 / prior.quiet_time
                log_p += np.log(chance if busy != before else 1 - chance)
                if busy != before:
                    x[2], P[2], P[:, 2] = 0, 0, 0
                if busy and not before:
                    level, spread = next(chosen)
                    x[2], P[2, 2] = level, spread**2
                    log_p -= np.log(len(levels))
                x, P = F @ x, F @ P @ F.T + prior.process_noise_sd**2 * np.outer(G, G)
                S, nu = P[0, 0] + sd**2, z[k + 1] - x[0]
                log_p -= 0.5 * (nu**2 / S + np.log(2 * np.pi * S))
                x, P = x + P[0] / S * nu, P - np.outer(P[0], P[0]) / S
            weight = np.exp(log_p)
            total, mean = total + weight, mean + weight * x[:2]
    return mean / total


def test_a_short_track_against_every_possible_history():
    prior = RandomAccelerations(quiet_time=4.0, manoeuvre_time=4.0)
    rng = np.random.default_rng(0)
    k = np.arange(8.0)
    z = 200 * k + 30 * np.maximum(k - 3, 0) ** 2 + 20 * rng.standard_normal(8)
    reference = near_optimal(z[None, :, None], prior, sd=20.0)
    x, sd = exact(z, prior, 20.0), np.sqrt(np.diagonal(reference.P[0, -1])[:2])
    assert np.all(np.abs(reference.x[0, -1, :2] - x) < 0.05 * sd)


def test_missing_measurements_are_bridged():
    runs = families.random_turns(20, 5, scans=60)[0]
    z = runs.measured.copy()
    z[:, ::3] = np.nan
    z[:, 40] = np.nan, np.nan
    z[3, 41, 0] = np.nan
    reference = near_optimal(z, RandomTurns(), sd=50.0)
    assert np.isfinite(reference.x).all()
    assert np.allclose(reference.log_likelihood_scan[:, 40], 0, atol=1e-12)
    assert rmse(reference.position - runs.position)[0] < 75


def test_the_manoeuvre_probability_is_calibrated():
    runs, rates = families.random_turns(RUNS, 2)
    probability = near_optimal(runs.measured, RandomTurns(), sd=50.0).manoeuvring[:, FIRST:]
    truth = rates[:, FIRST:] != 0
    for low in (0.0, 0.25, 0.5, 0.75):
        said = (probability >= low) & (probability < low + 0.25)
        assert truth[said].mean() == pytest.approx(probability[said].mean(), abs=0.04)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"z": np.zeros((3, 4))}, "expected .runs, scans, axes."),
        ({"z": np.full((2, 5, 2), np.nan)}, "run 0 has an axis without one"),
        ({"sd": 0.0}, "sd, T and hypotheses"),
        ({"hypotheses": 4}, "hypotheses from 8"),
    ],
)
def test_errors_say_what_was_expected(change, message):
    arguments = {"z": np.zeros((2, 5, 2)), "prior": RandomAccelerations(), "sd": 1.0, **change}
    with pytest.raises(ValueError, match=message):
        near_optimal(**arguments)
