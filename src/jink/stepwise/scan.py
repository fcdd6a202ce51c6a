"""One scan of all tracks: mix, predict, update, weigh, gate and start, with the native mix and update."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .._engine import native
from ..models.outliers import Outliers
from . import surprise
from .components import Seen, union
from .functions import Array
from .modes import LibraryMode, Mode, OwnMode
from .sensors import LibrarySensor, Look, OwnSensor, View
from .start import Start, check_priors
from .states import Measurement, Outcome, Predicted, Record, States
from .surprise import BestFit
from .weigh import matched_nis, probability_transform, weigh


class Scan:
    """One scan of a bank of modes on sensors, any of them the user's own. The arguments are the engine's."""

    def __init__(
        self,
        motions: Sequence[Any],
        sensors: Sequence[Any],
        axes: int,
        outliers: Outliers | None,
        given_prior: bool,
        declaration: native.Declaration,
    ) -> None:
        d, unscented = declaration, declaration.unscented
        self.axes, self.unbiased = axes, d.unbiased_mixing
        self.share, self.restart_after, self.coast = d.outlier_share, d.restart_after, d.coast
        self.modes: list[Mode] = [
            LibraryMode(m, axes, unscented) if hasattr(m, "native") else OwnMode(m, axes, unscented) for m in motions
        ]
        self.looks: Sequence[Look] = [
            LibrarySensor(s, outliers) if hasattr(s, "native") else OwnSensor(s, self.modes, axes, outliers)
            for s in sensors
        ]
        self.with_pit = False
        self.components = union(self.modes)
        self.columns = max(look.rows for look in self.looks)
        self.starts = any(look.starts for look in self.looks)
        check_priors(self.modes, self.starts and (not given_prior or d.outlier_share > 0 or d.coast > 0))
        self.views = [[View(look, mode, unscented) for mode in self.modes] for look in self.looks]
        self.reported = [Seen(mode, self.components) for mode in self.modes]
        self._transition = (d.continuous, d.transition, len(self.modes))
        self.initial_probability = np.asarray(d.initial_probability, dtype=float)
        self.start = Start(self.modes, self.initial_probability, axes, d.start, d.velocity_variance)
        self._at = [[_places(j.components, i.components) for i in self.modes] for j in self.modes]

    def new(self, tracks: int) -> States:
        """Tracks that have not started."""
        return States.new(self.modes, self.initial_probability, self.axes, tracks)

    def check_start(self) -> None:
        """Errors: ValueError if no sensor can start a track."""
        if not self.starts:
            names = ", ".join(look.owner for look in self.looks)
            raise ValueError(
                f"initial: expected jink.Prior(x, P), because {names} measures no position from which to start a track"
            )

    def places(self, j: int, i: int) -> Array:
        """Where mode j's components stand in mode i, −1 where it has none."""
        return self._at[j][i]

    def transition(self, dt: Array) -> Array:
        """Mode transition probabilities (B, M, M) over elapsed times."""
        return native.transition_over(*self._transition, dt)

    def source(self, j: int, i: int, x: list[Array], P: list[Array]) -> tuple[Array, Array]:
        """Mode i's estimate as mode j sees it: what i lacks is of j's prior, or (unbiased) of j."""
        at = self._at[j][i]
        if len(at) == len(self.modes[i].components) and (at == np.arange(len(at))).all():
            return x[i], P[i]
        lacking, has = np.flatnonzero(at < 0), np.flatnonzero(at >= 0)
        tracks, n = len(x[i]), len(at)
        mean, C = np.zeros((tracks, n)), np.zeros((tracks, n, n))
        mean[:, has] = x[i][:, at[has]]
        C[:, has[:, None], has] = P[i][:, at[has][:, None], at[has]]
        if self.unbiased:
            mean[:, lacking] = x[j][:, lacking]
            C[:, lacking[:, None], lacking] = P[j][:, lacking[:, None], lacking]
        else:
            C[:, lacking, lacking] = self.modes[j].prior[lacking]
        return mean, C

    def predict(self, j: int, dt: Array, x: Array, P: Array, u: Array | None) -> tuple[Array, Array]:
        """x⁻ and P⁻ = F P Fᵀ + Q of one mode; the diagonal grows by what rounding may have cost."""
        ahead, F, Q = self.modes[j].linearise(dt, x, P, u)
        n = x.shape[1]
        P_ahead = F @ P @ F.transpose(0, 2, 1) + Q
        P_ahead = 0.5 * (P_ahead + P_ahead.transpose(0, 2, 1))
        spread = ((F * F) @ np.einsum("bii->bi", P)[:, :, None])[:, :, 0]
        np.einsum("bii->bi", P_ahead)[:] += 4.0 * n * np.finfo(float).eps * spread
        return ahead, P_ahead

    def propagate(self, s: States, dt: Array, u: Array | None) -> Predicted:
        """Mix and predict every mode."""
        modes = range(len(self.modes))
        if len(self.modes) == 1:
            x, P = self.predict(0, dt, s.x[0], s.P[0], u)
            return Predicted([x], [P], np.ones((len(dt), 1)))
        weights = self.transition(dt) * np.maximum(s.probability, 1e-100)[:, :, None]  # a mode never dies for good
        prior = weights.sum(axis=1)
        weights /= prior[:, None, :]
        ahead = []
        for j in modes:
            xs, Ps = zip(*(self.source(j, i, s.x, s.P) for i in modes), strict=True)
            x, P = native.mix(xs, Ps, np.ascontiguousarray(weights[:, :, j]))
            ahead.append(self.predict(j, dt, x, P, u))
        return Predicted([x for x, _ in ahead], [P for _, P in ahead], prior)

    def step(self, s: States, time: Array, z: Array, sensor: Array, R: Array | None, u: Array | None) -> Outcome:
        """One scan of every track: sensor (B,) index; R of each row, variances or covariances, or None."""
        if self.coast > 0:
            lost = s.started & (time - s.last_accepted > self.coast)
            s.started, s.running = s.started & ~lost, s.running & ~lost
        first_update = np.isnan(s.time)
        s.last_accepted = np.where(first_update, time, s.last_accepted)
        ahead = self.propagate(s, np.where(s.started & ~first_update, time - s.time, 0.0), u)
        s.time = np.array(time, dtype=float)
        if len(self.looks) == 1 or (sensor == sensor[:1]).all():
            return self._finish(s, ahead, int(sensor[0]) if len(sensor) else 0, z, R)
        out = Outcome.new(len(time), self.columns)
        for i in np.unique(sensor):
            rows = np.flatnonzero(sensor == i)
            part = s.take(rows)
            out.put(rows, self._finish(part, ahead.take(rows), int(i), z[rows], None if R is None else R[rows]))
            s.put(rows, part)
        return out

    def measure(self, i: int, z: Array, R: Array | None) -> Measurement:
        """Rows of z as sensor i measures them."""
        look = self.looks[i]
        m = look.rows
        z = np.ascontiguousarray(z[:, :m])
        if R is None:
            noise = np.tile(look.R, (len(z), 1, 1))
        elif R.ndim == 2:
            noise = R[:, :m, None] * np.eye(m)
        else:
            noise = np.ascontiguousarray(R[:, :m, :m])
        return Measurement(z, noise, ~np.isnan(z))

    def _finish(self, s: States, ahead: Predicted, i: int, z: Array, R: Array | None) -> Outcome:
        """Update every mode by sensor i, weigh the modes, gate, and start tracks that need it."""
        look, raw = self.looks[i], self.measure(i, z, R)
        m = Measurement(*look.convert(raw.z, raw.R, raw.present))
        nis, det, e, S, joint, y = self._update(s, ahead, i, m)
        out = Outcome.new(len(z), self.columns)
        out.dof = m.present.sum(axis=1).astype(float)
        out.measured = out.dof > 0
        out.scored = out.measured & s.running
        weigh(s, ahead.prior, nis, det, out)
        out.nis = matched_nis(y, joint, ahead.prior)
        if self.with_pit:
            out.pit[:, : m.z.shape[1]] = np.where(m.present, probability_transform(ahead.prior, e, S), np.nan)
        if self.share > 0:
            log_outlier = -(m.present * look.log_extent).sum(axis=1)
            self._gate(s, ahead, i, m, log_outlier, surprise.best_fit(nis, det), out)
        s.last_accepted = np.where(out.measured & ~out.gated, s.time, s.last_accepted)
        self.start.begin(s, look.fix(raw.z, raw.R, raw.present), out)
        return out

    def _update(self, s: States, ahead: Predicted, i: int, m: Measurement) -> list[list[Array]]:
        """Update every mode by sensor i; of each: NIS, det S, residuals in turn, their S, the whole S, y."""
        innovations = []
        for j, view in enumerate(self.views[i]):
            y, H, added = view.linearise(ahead.x[j], ahead.P[j], m.z, m.present & s.started[:, None])
            s.x[j], s.P[j], *v = native.update(ahead.x[j], ahead.P[j], y, H, m.R + added, m.present)
            innovations.append((*v, np.where(m.present, y, 0.0)))
        return [[v[k] for v in innovations] for k in range(6)]

    def _gate(
        self, s: States, ahead: Predicted, i: int, m: Measurement, log_outlier: Array, best: BestFit, out: Outcome
    ) -> None:
        target, outlier = out.log_likelihood + np.log1p(-self.share), log_outlier + np.log(self.share)
        out.log_likelihood = np.where(out.measured, np.logaddexp(target, outlier), out.log_likelihood)
        out.gated = out.measured & (target < outlier) & s.running
        explained = out.gated & surprise.explains(s, best, out.dof, np.log1p(-self.share), outlier)
        if explained.any():
            wide = ahead.widened(np.where(explained, surprise.scale_with(s, best, out.dof), 1.0))
            nis, det, *_ = self._update(s, wide, i, m)
            weigh(s, ahead.prior, nis, det, replace(out))
            out.gated = out.gated & ~explained
        surprise.add(s, best, out.dof, out.measured & s.running & ~out.gated)
        s.rejections = np.where(out.measured & s.running, np.where(out.gated, s.rejections + 1, 0.0), s.rejections)
        if not out.gated.any():
            return
        rows = np.flatnonzero(out.gated)
        for j in range(len(self.modes)):
            s.x[j][rows], s.P[j][rows] = ahead.x[j][rows], ahead.P[j][rows]
        s.probability[rows] = ahead.prior[rows]
        if self.restart_after > 0:
            out.restarted = out.gated & (s.rejections >= self.restart_after)

    def record(
        self,
        s: States,
        before: Array,
        out: Outcome,
        z: Array,
        sensor: Array,
        R: Array | None,
        u: Array | None,
    ) -> Record:
        """What the smoothers need of a scan just stepped."""
        begun = (out.initialised & (s.first_time == s.time)) | out.restarted
        measurements = []
        for i, look in enumerate(self.looks if len(self.modes) > 1 else ()):
            raw = self.measure(i, z, R)
            m = Measurement(*look.convert(raw.z, raw.R, raw.present))
            m.present = m.present & ((sensor == i) & ~out.gated)[:, None]
            measurements.append(m)
        dt = np.where(np.isnan(before), 0.0, s.time - before)
        kept = ([a.copy() for a in s.x], [a.copy() for a in s.P], s.probability.copy())
        return Record(*kept, dt, u, s.started.copy(), s.started & ~begun, sensor, measurements)

    def combine(self, x: list[Array], P: list[Array], probability: Array) -> tuple[Array, Array]:
        """The modes' estimates in the reported components, matched in two moments."""
        seen = [self._report(j, x[j], P[j]) for j in range(len(self.modes))]
        if len(seen) == 1:
            return seen[0]
        xs, Ps = zip(*seen, strict=True)
        return native.mix(xs, Ps, probability)

    def _report(self, j: int, x: Array, P: Array) -> tuple[Array, Array]:
        view = self.reported[j]
        if view.same:
            return x, P
        X, J = view(x)
        C = J @ P @ J.transpose(0, 2, 1)
        for k in view.unknown:  # as it would enter a mode that has it
            name = self.components[k]
            C[:, k, k] = next(m.prior[m.components.index(name)] for m in self.modes if name in m.components)
        return X, C


def _places(of: Sequence[str], within: Sequence[str]) -> Array:
    """Where components stand in another state, −1 where they do not."""
    return np.array([within.index(c) if c in within else -1 for c in of])
