"""One configuration, twice: as jink's objects and as the oracle's, and how far their results lie apart."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

import jink
from oracle import motion as om
from oracle import sensor as osn
from oracle import start
from oracle.chain import PerScan, Sojourn
from oracle.coasting import Coasting
from oracle.mixture import Mode, union
from oracle.smoother import smooth as oracle_smooth
from oracle.tracker import Estimate, Filter, Outliers, track

ORACLE_MOTION = {
    name: getattr(om, name)
    for name in ("ConstantVelocity", "ConstantAcceleration", "Singer", "CoordinatedTurn", "KnownTurn")
}


@dataclass
class Part:
    """A constructor by its name and keywords, the same on both sides."""

    name: str
    kwargs: dict = field(default_factory=dict)

    def native(self):
        return getattr(jink, self.name)(**self.kwargs)

    def motion(self, axes: int):
        kwargs = {k: v for k, v in self.kwargs.items() if k != "axes"}
        return ORACLE_MOTION[self.name](axes, **kwargs)

    def sensor(self):
        return getattr(osn, self.name)(**self.kwargs)


def part(name: str, **kwargs) -> Part:
    return Part(name, kwargs)


@dataclass
class Twin:
    motions: list[Part]
    sensors: list[Part]
    axes: int = 2
    transition: object = 0.9  # stay, matrix, or {"seconds": ..., "to": ...}
    transition_step: float | None = None
    mode_probability: list[float] | None = None
    mixing: str = "prior"
    linearisation: str = "ekf"
    outliers: dict | None = None
    initial: Part = field(default_factory=lambda: part("OnePoint", velocity_sd=30.0))
    coasting: dict | None = None

    def native(self):
        outliers = None if self.outliers is None else jink.Outliers(**self.outliers)
        sensors = [s.native() for s in self.sensors]
        common = {
            "linearisation": self.linearisation,
            "outliers": outliers,
            "initial": self.initial.native(),
        }
        sensor = sensors if len(sensors) > 1 else sensors[0]
        motions = [m.native() for m in self.motions]
        if len(motions) == 1:
            return jink.Kalman(motions[0], sensor, **common)
        transition = self.transition
        if isinstance(transition, dict):
            transition = jink.Sojourn(**transition)
        return jink.IMM(
            motions,
            sensor,
            transition,
            transition_step=self.transition_step,
            mode_probability=self.mode_probability,
            mixing=self.mixing,
            coasting=None if self.coasting is None else jink.Coasting(**self.coasting),
            **common,
        )

    def oracle(self) -> Filter:
        motions = [m.motion(self.axes) for m in self.motions]
        M = len(motions)
        if isinstance(self.transition, dict):
            chain = Sojourn(**self.transition)
        else:
            chain = PerScan(self.transition if M > 1 else 1.0, M, self.transition_step)
        if self.initial.name == "Prior":
            x, P = np.asarray(self.initial.kwargs["x"]), np.asarray(self.initial.kwargs["P"])
            components = union(motions)
            of = [[components.index(name) for name in m.components] for m in motions]
            initial = start.Prior([Mode(x[i], P[np.ix_(i, i)]) for i in of])
        else:
            initial = getattr(start, self.initial.name)(**self.initial.kwargs)
        outliers = None if self.outliers is None else Outliers(**self.outliers)
        mu = None if self.mode_probability is None else np.asarray(self.mode_probability, float)
        return Filter(
            motions,
            [s.sensor() for s in self.sensors],
            chain,
            initial,
            self.mixing,
            self.linearisation,
            outliers,
            mu,
            None if self.coasting is None else Coasting(**self.coasting),
        )


@dataclass
class Data:
    time: np.ndarray
    z: np.ndarray
    sensor: np.ndarray | None = None
    R: np.ndarray | None = None
    u: np.ndarray | None = None

    def keywords(self) -> dict:
        R = self.R
        if R is not None and all(np.count_nonzero(r - np.diag(np.diag(r))) == 0 for r in R):
            R = np.array([np.diag(r) for r in R])  # as variances
        named = {"sensor": self.sensor, "covariance": R, "input": self.u}
        return {k: v for k, v in named.items() if v is not None}


def run_oracle(twin: Twin, data: Data, smooth: bool = False) -> Estimate:
    f = twin.oracle()
    est = track(f, data.time, data.z, data.sensor, data.R, data.u)
    return oracle_smooth(f, est) if smooth else est


def run_native(twin: Twin, data: Data, smooth: bool = False):
    f = twin.native()
    return (f.smooth if smooth else f.filter)(data.time, data.z, **data.keywords())


def conditioning(est: Estimate) -> float:
    """The worst condition number of a mode's covariance, scaled to unit diagonal."""
    worst = 1.0
    for scan in est.scans:
        for mode in [*scan.modes, *scan.predicted]:
            sd = np.sqrt(np.diag(mode.P))
            worst = max(worst, float(np.linalg.cond(mode.P / np.outer(sd, sd))))
    return worst


def rounding_effect(twin: Twin, data: Data) -> dict[str, float]:
    """How far the smoothed results move when the filter's are rounded in their sixteenth digit."""
    f, rng = twin.oracle(), np.random.default_rng(0)
    est = track(f, data.time, data.z, data.sensor, data.R, data.u)
    base = oracle_smooth(f, est)
    for scan in est.scans:
        for mode in scan.modes:
            noise = rng.normal(size=mode.P.shape)
            mode.x = mode.x * (1 + 1e-16 * rng.normal(size=mode.x.shape))
            mode.P = mode.P * (1 + 1e-15 * (noise + noise.T) / 2)
    return distances(oracle_smooth(f, est), base)


def distances(native, oracle: Estimate) -> dict[str, float]:
    """Largest differences: x over |x| + sd, P over sd sd', probabilities absolute, likelihood and NIS over 1
    + size.
    """
    there = ~np.isnan(oracle.x[:, 0])
    if not np.array_equal(there, ~np.isnan(native.x[:, 0])):
        return {"where there is an estimate": np.inf}
    sd = np.sqrt(np.einsum("kii->ki", oracle.P))[there]
    sd = np.maximum(sd, 1e-150)
    both = ~np.isnan(oracle.nis) & ~np.isnan(native.nis)
    size = 1 + np.abs(oracle.nis[both])

    def largest(a):
        return float(np.max(a, initial=0.0))

    return {
        "status": float(np.sum(native.status != oracle.status)),
        "nis_dof": float(np.sum((native.nis_dof != oracle.nis_dof)[both])),
        "x": largest(np.abs(native.x - oracle.x)[there] / (np.abs(oracle.x)[there] + sd)),
        "P": largest(np.abs(native.P - oracle.P)[there] / (sd[:, :, None] * sd[:, None, :])),
        "mode_probability": largest(np.abs(native.mode_probability - oracle.mode_probability)[there]),
        "log_likelihood_scan": largest(
            np.abs(native.log_likelihood_scan - oracle.log_likelihood_scan) / (1 + np.abs(oracle.log_likelihood_scan))
        ),
        "nis": largest(np.abs(native.nis - oracle.nis)[both] / size),
    }
