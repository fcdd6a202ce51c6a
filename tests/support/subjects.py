"""What the contract is tested on: compositions by name and every registered filter, which clauses they do not
claim, and the data they see.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.situations import flight, times

import jink
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS

CV = {"acceleration_psd": 2.0}
CA = {"jerk_psd": 0.3, "acceleration_prior_sd": 8.0}
CT = {"acceleration_psd": 0.4, "turn_rate_psd": 2e-5, "turn_rate_prior_sd": 0.05}
SOJOURN = {"seconds": [60.0, 20.0, 15.0]}


@dataclass(frozen=True)
class Subject:
    """A composition: its motion models and a constructor from (motions, sensor, more keywords)."""

    motions: Callable[[], list]
    build: Callable


def kalman(motions, sensor, **more):
    return jink.Kalman(motions[0], sensor, **more)


def imm(motions, sensor, **more):
    M = len(motions)
    seconds = (SOJOURN["seconds"] * M)[:M]
    return jink.IMM(motions, sensor, more.pop("transition", jink.Sojourn(seconds=seconds)), **more)


def with_(build, **fixed):
    return lambda motions, sensor, **more: build(motions, sensor, **{**fixed, **more})


def mixed():
    return [jink.ConstantVelocity(**CV), jink.ConstantAcceleration(**CA), jink.CoordinatedTurn(**CT)]


SUBJECTS = {
    "kalman-cv": Subject(lambda: [jink.ConstantVelocity(**CV)], kalman),
    "kalman-cv-discrete": Subject(lambda: [jink.ConstantVelocity(acceleration_sd=1.0)], kalman),
    "kalman-ca": Subject(lambda: [jink.ConstantAcceleration(**CA)], kalman),
    "kalman-singer": Subject(lambda: [jink.Singer(acceleration_sd=5.0, time_constant=15.0)], kalman),
    "kalman-known-turn": Subject(lambda: [jink.KnownTurn(0.05, acceleration_psd=1.0)], kalman),
    "kalman-ct": Subject(lambda: [jink.CoordinatedTurn(**CT)], kalman),
    "kalman-ct-ukf": Subject(lambda: [jink.CoordinatedTurn(**CT)], with_(kalman, linearisation="ukf")),
    "imm-3cv": Subject(lambda: [jink.ConstantVelocity(acceleration_psd=q) for q in (0.1, 4.0, 90.0)], imm),
    "imm-mixed": Subject(mixed, imm),
    "imm-unbiased": Subject(mixed, with_(imm, mixing="unbiased")),
    "imm-robust": Subject(mixed, with_(imm, outliers=jink.Outliers())),
    "imm-turns": Subject(
        lambda: [jink.KnownTurn(w, acceleration_psd=1.0) for w in (-0.05, 0.0, 0.05)],
        imm,
    ),
    "imm-ukf": Subject(mixed, with_(imm, linearisation="ukf")),
}


def registered(name):
    """The filter that `jink track --filter NAME` and the race build, for a fast target."""
    return lambda motions, sensor, **more: FILTERS[name](Purpose(sensor=sensor, kind="fighter")).filter


NAMED = {f"{name} (registered)": name for name in FILTERS}
SUBJECTS |= {subject: Subject(list, registered(name)) for subject, name in NAMED.items()}

NONLINEAR = dict.fromkeys(
    [
        "kalman-ct",
        "kalman-ct-ukf",
        "imm-3cv",
        "imm-mixed",
        "imm-unbiased",
        "imm-robust",
        "imm-turns",
        "imm-ukf",
    ],
    "not a linear filter",
)
OWN = dict.fromkeys(NAMED, "its parameters are its own; the clause is tested on compositions of the same parts")


def because(reason, *names):
    """These registered filters do not claim a clause, for this reason."""
    return {f"{name} (registered)": reason for name in names}


LED_ASTRAY = "50 km throws its turn rate off, and without gating it takes long to come back"
CHOLESKY = dict.fromkeys(["kalman-ct-ukf", "imm-ukf"], "sigma points lie along the axes of the Cholesky factor")
NETWORK = because("its network was not trained to take the axes for equal", "nnvsmm")
# what a smoother of theirs would have to be, and what the refusal says instead: test_smoothing_is_refused
NOT_SMOOTHED = (
    because("its noise depends on the covariance that it is added to", "two-stage")
    | because("the modes alive are others in every scan", "vsmm-ds", "vsmm-ad", "vsmm-ag")
    | because("it changes its past estimate by decisions", "input-estimation", "variable-dimension")
    | because("its correction is learned for the filtered estimate", "anfis-kf", "nn-kf")
    | because("its weights are a network's scores, not probabilities", "nnvsmm-modes")
)
NOT_CLAIMED: dict[str, dict[str, str]] = {
    "linear_gaussian": NONLINEAR | OWN,
    "identical_modes": OWN,
    "split_gap_state": NONLINEAR
    | OWN
    | {
        "kalman-cv-discrete": "its noise is per step, not continuous",
        "kalman-known-turn": "its noise is a straight line's over each step, not carried along the turn",
    },
    "split_gap_probability": because(
        "every row, measured or not, chooses anew which modes are alive", "vsmm-ds", "vsmm-ad", "vsmm-ag"
    )
    | because("its detectors look back over so many rows, measured or not", "variable-dimension"),
    "smooth": NOT_SMOOTHED,
    "outlier_forgotten": {"kalman-ct-ukf": LED_ASTRAY} | because(LED_ASTRAY, "imm-cv-ct"),
    "rotation": CHOLESKY
    | because("its noise follows the acceleration along each axis", "csaf", "facs", "imm-facs")
    | because("its levels lie along the axes", "aimm3", "aimm5")
    | because("its noise follows the residual along each axis", "fuzzy-imm", "fuzzy-kalman")
    | because("its aid corrects each axis by itself", "anfis-kf", "nn-kf")
    | NETWORK,
    "quarter_turn": CHOLESKY
    | because("its rules tell a residual from its opposite", "fuzzy-imm", "fuzzy-kalman")
    | because("its aid tells an innovation from its opposite", "anfis-kf", "nn-kf")
    | NETWORK,
}


def claims(*clauses: str):
    """Parametrise over the subjects that claim a clause, or each of several."""
    excluded = {name for clause in clauses for name in NOT_CLAIMED.get(clause, {})}
    return pytest.mark.parametrize("name", [n for n in SUBJECTS if n not in excluded])


def runs(name, filter):
    """How a subject is run: filtered, and smoothed if it claims that."""
    return [filter.filter] if name in NOT_SMOOTHED else [filter.filter, filter.smooth]


def build(name, sensor=None, **more):
    subject = SUBJECTS[name]
    more.setdefault("initial", jink.TwoPoint(velocity_sd=300.0))
    return subject.build(subject.motions(), sensor or jink.Position(sd=25.0, axes=2), **more)


def scene(N=50, seed=0, missing=0.1):
    rng = np.random.default_rng(seed)
    t = times(N, rng, 0.0)
    z = flight(t, 2, rng)[0] + rng.normal(0, 25.0, (N, 2))
    z[2:][rng.random(N - 2) < missing] = np.nan
    return t, z


def fleet(B=13, seed=0):
    """Ragged tracks of 2 to 60 rows."""
    lengths = np.random.default_rng(seed).integers(2, 60, B)
    tracks = [scene(n, 100 + i) for i, n in enumerate(lengths)]
    offsets = np.r_[0, np.cumsum(lengths)]
    return np.concatenate([t for t, _ in tracks]), np.concatenate([z for _, z in tracks]), offsets, tracks


RESULTS = ("x", "P", "mode_probability", "log_likelihood_scan", "nis", "nis_dof", "status")


def assert_same(a, b, rows=slice(None), names=RESULTS):
    """Bit for bit."""
    for name in names:
        assert_array_equal(np.asarray(getattr(a, name)), np.asarray(getattr(b, name))[rows], err_msg=name)


def assert_close(a, b, rtol=1e-9, rows=slice(None)):
    sd = np.sqrt(np.einsum("kii->ki", b.P[rows]))
    assert_allclose(a.x, b.x[rows], rtol=rtol, atol=rtol * float(np.nanmax(sd)))
    assert_allclose(a.P, b.P[rows], rtol=rtol, atol=rtol * float(np.nanmax(sd)) ** 2)
    assert_allclose(a.mode_probability, b.mode_probability[rows], rtol=rtol, atol=rtol)


def assert_positive(P, status):
    """Symmetric; positive (semi)definite to rounding in units of its own standard deviations."""
    P = P[status > 0]
    assert np.isfinite(P).all()
    assert_allclose(P, P.transpose(0, 2, 1), rtol=1e-12, atol=0)
    sd = np.sqrt(np.einsum("kii->ki", P))
    present = sd > 0
    scale = np.where(present, sd, 1.0)
    scaled = P / (scale[:, :, None] * scale[:, None, :])
    assert np.linalg.eigvalsh(scaled).min(initial=1.0) > -1e-12
