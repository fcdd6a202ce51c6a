"""One track through an interacting multiple model filter (Blom & Bar-Shalom 1988); with one mode, a Kalman
filter.

Per row: transition over dt (identity at dt = 0), mixing, prediction, and, if anything was measured, update
and Bayes: mu_j = c_j N_j / sum. Without a measurement mu = c (Markov only). With outliers, a row whose
density is below the uniform one is not used; after restart_after such rows in succession the track starts
again from the last of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import norm

from oracle.coasting import Coasting, coasted
from oracle.gaussian import Predicted, Updated, predict, update
from oracle.mixture import Mode, combine, mix
from oracle.motion import Motion
from oracle.sensor import PositionVelocity, wrap
from oracle.start import Fix, OnePoint, Prior, TwoPoint, contradicted, one_point, slowed, two_point

Array = NDArray[np.float64]
NONE, UPDATED, PREDICTED, GATED, RESTARTED, INITIALISED = range(6)


@dataclass
class Outliers:
    """A uniform density over the extent of each component: a length, a speed or the full circle."""

    share: float = 0.01
    extent: float = 1e5
    restart_after: int = 2
    velocity_extent: float = 1e3
    hindsight: bool = False

    def log_density(self, row: Row) -> float:
        extents = {"p": self.extent, "v": self.velocity_extent, "a": 2 * np.pi}
        return -sum(np.log(extents[kind]) for kind, there in zip(row.sensor.kinds, row.present, strict=True) if there)


@dataclass
class Filter:
    motions: list[Motion]
    sensors: list
    chain: object
    initial: OnePoint | TwoPoint | Prior
    mixing: str = "prior"
    linearisation: str = "ekf"
    outliers: Outliers | None = None
    mode_probability: Array | None = None
    coasting: Coasting | None = None

    def start_probability(self) -> Array:
        return self.chain.stationary() if self.mode_probability is None else np.asarray(self.mode_probability, float)


@dataclass
class Scan:
    """What is known after one row; `modes` is empty while there is no track."""

    dt: float
    u: Array | None
    Pi: Array
    status: int = NONE
    linked: bool = False  # follows from the scan before, by prediction
    used: Row | None = None  # the measurement that was believed
    modes: list[Mode] = field(default_factory=list)
    predicted: list[Predicted] = field(default_factory=list)
    steps: list[tuple[Array, Array | None]] | None = None  # noise and input of each mode, where they adapt
    mu: Array | None = None
    log_likelihood: float = 0.0
    nis: float = np.nan
    nis_dof: int = 0
    pit: Array | None = None  # of each measured component, NaN for the others
    doubt: Any = None  # if it is followed both ways, see oracle.hindsight


@dataclass
class Row:
    time: float
    z: Array
    R: Array
    sensor: object

    @property
    def present(self) -> Array:
        return ~np.isnan(self.z[: self.sensor.m])

    def fix(self, axes: int) -> Fix | None:
        if getattr(self.sensor, "axes", 0) < axes:
            return None
        found = self.sensor.fix(self.z, self.R)
        if found is None or np.isnan(found[0]).any() or np.isnan(found[1]).any():
            return None
        fix = Fix(self.time, found[0][:axes], found[1][:axes, :axes])
        if "v" in self.sensor.kinds and isinstance(self.sensor, PositionVelocity) and self.present.all():
            fix.velocity, fix.R_velocity = self.z[axes:], self.R[axes:, axes:]
        return fix

    def converted(self) -> Row:
        """The equivalent measurement the update works on; one that is not complete cannot be converted."""
        if not self.present.all():
            return self
        return Row(self.time, *self.sensor.measured(self.z, self.R))


class Track:
    """The filter's memory between rows."""

    def __init__(self, filter: Filter):
        self.filter = filter
        self.scans: list[Scan] = []
        self.first: Fix | None = None  # of a two-point start that waits for its second
        self.contradictions = 0  # second positions in a row that contradicted the first
        self.rejected = 0
        self.surprises: list[
            tuple[float, int]
        ] = []  # NIS of the best fitting mode and dof, of rows accepted since the start
        self.time: float | None = None
        self.seen = self.seen_height = 0.0  # when a measurement was last accepted, and one of the height
        self.modes: list[Mode] = []
        self.mu = filter.start_probability()
        if isinstance(filter.initial, Prior):
            self.modes = filter.initial.modes

    def step(self, row: Row, u: Array | None) -> Scan:
        dt = 0.0 if self.time is None else row.time - self.time
        self.time = row.time
        scan = Scan(dt, u, self.filter.chain.over(dt))
        if not self.modes:
            self.begin(scan, row)
        else:
            self.advance(scan, row)
        if scan.status in (UPDATED, INITIALISED, RESTARTED):
            self.seen = row.time
            height = min(2, len(row.present) - 1)
            if scan.status != UPDATED or row.present[height]:
                self.seen_height = row.time
        scan.modes, scan.mu = self.modes, self.mu
        self.scans.append(scan)
        return scan

    def begin(self, scan: Scan, row: Row) -> None:
        fix = row.fix(self.filter.motions[0].axes)
        if fix is None:
            return
        self.restart(fix)
        scan.status = INITIALISED
        if isinstance(self.filter.initial, TwoPoint) and fix.velocity is None:
            self.first = fix

    def restart(self, fix: Fix) -> None:
        self.modes = [one_point(m, fix, self.filter.initial.velocity_sd) for m in self.filter.motions]
        self.mu = self.filter.start_probability()
        self.rejected = 0
        self.surprises = []

    def advance(self, scan: Scan, row: Row) -> None:
        f = self.filter
        c, mixed = mix(f.motions, self.modes, self.mu, scan.Pi, f.mixing)
        scan.predicted = [
            predict(m, x.x, x.P, scan.dt, scan.u, f.linearisation) for m, x in zip(f.motions, mixed, strict=True)
        ]
        if f.coasting is not None and self.first is None:
            late, height = (
                min(max(row.time - t - f.coasting.after, 0.0), scan.dt) for t in (self.seen, self.seen_height)
            )
            scan.predicted = [
                replace(p, x=coasted(f.coasting, m, x.x, p.x, scan.dt, late, height))
                for m, x, p in zip(f.motions, mixed, scan.predicted, strict=True)
            ]
        self.mu, self.modes = c, [Mode(p.x, p.P) for p in scan.predicted]
        scan.status, scan.linked = PREDICTED, True
        if not row.present.any():
            return
        second = row.fix(f.motions[0].axes) if self.first is not None else None
        if second is not None and second.time > self.first.time:
            self.complete(scan, row, second)
            return
        self.measure(scan, row, c)

    def complete(self, scan: Scan, row: Row, second: Fix) -> None:
        """The second position: velocity from both, or, where it contradicts the first, a new start from it alone."""
        f, scan.status = self.filter, INITIALISED
        bounded = f.initial.bounded and self.contradictions < 2
        if bounded and contradicted(self.first, second, f.initial.velocity_sd):
            self.restart(second)
            self.first, scan.linked = second, False
            self.contradictions += 1
            return
        self.modes = [two_point(m, self.first, second) for m in f.motions]
        if bounded:
            self.modes = [slowed(m, x, f.initial.velocity_sd) for m, x in zip(f.motions, self.modes, strict=True)]
        self.mu = f.start_probability()
        self.first, self.contradictions = None, 0
        scan.used = row.converted()

    def measure(self, scan: Scan, row: Row, c: Array) -> None:
        f, work = self.filter, row.converted()
        updated = [
            update(m, work.sensor, p.x, p.P, work.z, work.R, f.linearisation)
            for m, p in zip(f.motions, scan.predicted, strict=True)
        ]
        with np.errstate(divide="ignore"):
            log_joint = np.log(c) + np.array([u.log_likelihood for u in updated])
        log_density = logsumexp(log_joint)
        if self.first is None:  # before the second point nothing is scored or gated
            self.score(scan, c, updated, work, log_density)
            fit = updated
            if scan.status == GATED and (scale := self.explained(updated, work)):
                # believed after all, by predictions widened to the scale of the innovations
                updated = [
                    update(m, work.sensor, p.x, scale * p.P, work.z, work.R, f.linearisation)
                    for m, p in zip(f.motions, scan.predicted, strict=True)
                ]
                log_joint = np.log(c) + np.array([u.log_likelihood for u in updated])
                log_density = logsumexp(log_joint)
                scan.status = UPDATED
        if scan.status == GATED:
            self.reject(scan, row)
            return
        self.rejected = 0
        if self.first is None:
            self.remember(fit, int(work.present.sum()))
        self.modes, self.mu = [Mode(u.x, u.P) for u in updated], np.exp(log_joint - log_density)
        scan.status, scan.used = UPDATED, work

    def score(self, scan: Scan, c: Array, updated: list[Updated], work: Row, log_density: float) -> None:
        """NIS and log-likelihood; GATED where the row is likelier an outlier."""
        f = self.filter
        scan.nis, scan.nis_dof = matched_nis(c, updated, work)
        scan.pit = probability_integral_transform(c, updated, work)
        scan.log_likelihood = float(log_density)
        if f.outliers is not None:
            inlier = np.log1p(-f.outliers.share) + log_density
            outlier = np.log(f.outliers.share) + f.outliers.log_density(work)
            scan.log_likelihood = float(np.logaddexp(inlier, outlier))
            if inlier < outlier:
                scan.status = GATED

    def remember(self, updated: list[Updated], dof: int) -> None:
        """One row adds at most 25 per dimension."""
        best = min(nis_of(u) for u in updated)
        self.surprises.append((min(best, 25.0 * dof), dof))

    def explained(self, updated: list[Updated], work: Row) -> float:
        """The scale of the innovations if Student's t with the last rows' scale explains the row, else 0.

        While the mean NIS per dimension exceeds 4: t(v; nu, kappa S) with nu = sum w dof, kappa = sum w NIS / nu and
        w = 0.9^age, Gamma((nu + m) / 2) / Gamma(nu / 2) taken as (nu / 2)^(m / 2).
        """
        f, m = self.filter, int(work.present.sum())
        w = 0.9 ** np.arange(len(self.surprises))[::-1]
        total, nu = (float(w @ [s[k] for s in self.surprises]) if self.surprises else 0.0 for k in (0, 1))
        if nu <= 1.5 * m or total / nu <= 4.0:
            return 0.0
        best = min(updated, key=nis_of)
        nis, kappa = nis_of(best), total / nu
        log_t = -0.5 * np.linalg.slogdet(2 * np.pi * kappa * best.S)[1]
        log_t -= 0.5 * (nu + m) * np.log1p(nis / (nu * kappa))
        outlier = np.log(f.outliers.share) + f.outliers.log_density(work)
        return (total + nis) / (nu + m) if np.log1p(-f.outliers.share) + log_t > outlier else 0.0

    def reject(self, scan: Scan, row: Row) -> None:
        self.rejected += 1
        scan.status = GATED
        fix = row.fix(self.filter.motions[0].axes)
        if 0 < self.filter.outliers.restart_after <= self.rejected and fix is not None:
            self.restart(fix)
            scan.linked = False
            scan.status, scan.nis, scan.nis_dof = RESTARTED, np.nan, 0


def nis_of(updated: Updated) -> float:
    return float(updated.innovation @ np.linalg.solve(updated.S, updated.innovation))


def matched_nis(c: Array, updated: list[Updated], row: Row) -> tuple[float, int]:
    """nu' S^-1 nu of the moment-matched innovation: nu = sum c_j nu_j, S = sum c_j (S_j + (nu_j - nu)(nu_j -
    nu)').
    """
    angles = np.array([i in row.sensor.angles for i in range(row.sensor.m)])[row.present]
    nus = np.array([u.innovation for u in updated])
    nus[:, angles] = nus[0, angles] + wrap(nus[:, angles] - nus[0, angles])  # near one another, not across the wrap
    nu = c @ nus
    S = sum(w * (u.S + np.outer(n - nu, n - nu)) for w, u, n in zip(c, updated, nus, strict=True))
    nu[angles] = wrap(nu[angles])
    return float(nu @ np.linalg.solve(S, nu)), len(nu)


def probability_integral_transform(c: Array, updated: list[Updated], row: Row) -> Array:
    """P(z_r <= measured given the components before r) under the predicted mixture (Rosenblatt 1952), (m,).

    Given the components before, mode j weighs c_j N(of those), and component r is Gaussian with the
    conditional moments.
    """
    pit, present = np.full(row.sensor.m, np.nan), np.flatnonzero(row.present)
    with np.errstate(divide="ignore"):
        log_w = np.log(c)
    for r, component in enumerate(present):
        below = np.zeros(len(c))
        log_next = log_w.copy()
        for j, u in enumerate(updated):
            gain = np.linalg.solve(u.S[:r, :r], u.S[:r, r])
            d = u.innovation[r] - gain @ u.innovation[:r]
            sd = np.sqrt(u.S[r, r] - gain @ u.S[:r, r])
            below[j] = norm.cdf(d / sd)
            log_next[j] += norm.logpdf(d, scale=sd)
        pit[component] = np.exp(log_w - logsumexp(log_w)) @ below
        log_w = log_next
    return pit


@dataclass
class Estimate:
    """One track's results, as arrays; x and P over the union of the components."""

    x: Array
    P: Array
    mode_probability: Array
    log_likelihood_scan: Array
    nis: Array
    nis_dof: Array
    status: Array
    scans: list[Scan]

    @property
    def log_likelihood(self) -> float:
        return float(self.log_likelihood_scan.sum())


def track(filter: Filter, time, z, which=None, R=None, u=None) -> Estimate:
    """Filter one track: time (N,), z (N, m), which (N,) sensor per row, R (N, m, m) or None, u (N, axes) or
    None.
    """
    from oracle.hindsight import HindsightTrack

    hindsight = filter.outliers is not None and filter.outliers.hindsight
    run = HindsightTrack(filter) if hindsight else Track(filter)
    for k in range(len(time)):
        sensor = filter.sensors[0 if which is None else which[k]]
        row = Row(float(time[k]), np.array(z[k][: sensor.m], float), sensor.R if R is None else R[k], sensor)
        run.step(row, None if u is None else u[k])
    return estimate(filter, run.scans)


def estimate(filter: Filter, scans: list[Scan]) -> Estimate:
    """Combine each scan's modes; NaN while there is no track."""
    n = combine(filter.motions, [Mode(np.zeros(m.n), np.eye(m.n)) for m in filter.motions], filter.start_probability())
    lost = Mode(np.full(len(n.x), np.nan), np.full(n.P.shape, np.nan))
    M = len(filter.motions)
    out = [combine(filter.motions, s.modes, s.mu) if s.modes else lost for s in scans]
    return Estimate(
        np.array([m.x for m in out]),
        np.array([m.P for m in out]),
        np.array([s.mu if s.modes else np.full(M, np.nan) for s in scans]),
        np.array([s.log_likelihood for s in scans]),
        np.array([s.nis for s in scans]),
        np.array([s.nis_dof for s in scans]),
        np.array([s.status for s in scans], np.uint8),
        scans,
    )
