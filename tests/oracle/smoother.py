"""Fixed-interval smoothing: Rauch-Tung-Striebel for one mode, messages from the future for several.

One mode (Rauch, Tung, Striebel 1965): C = P F' (P^-)^-1, x_s = x + C (x_s+ - x^-),
P_s = (I - C F) P (I - C F)' + C (Q + P_s+) C'.

Several (two-filter smoothing; Fraser & Potter 1969; Helmick, Blair, Hoffman, IEEE T-IT 41(6), 1995): what is
measured after scan k says of mode j's state x, about its filtered estimate x_j,

    log p(Z_future | x, j) = s + h'(x - x_j) - (x - x_j)' J (x - x_j) / 2,    zero after the last scan.

Back over a scan: the scan's measurement is added (linearised at the filtered estimate); for each pair (i, j)
the message is moved to the prediction from i, process noise and entering components are integrated out, and
x_i substituted; fused with mode i's filtered estimate it gives the pair's smoothed moments and weight. The
pairs of i match in two moments; their messages are averaged with the pair weights, widened by the spread of
the pairs, and levelled to weigh what the pairs weigh together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from oracle.gaussian import Predicted, parts, predict, symmetric
from oracle.hindsight import decided
from oracle.mixture import Mode, augment, match, selection
from oracle.motion import Motion
from oracle.sensor import wrap
from oracle.tracker import Estimate, Filter, Row, Scan, estimate

Array = NDArray[np.float64]


@dataclass
class Message:
    J: Array
    h: Array
    s: float

    @staticmethod
    def silent(n: int) -> Message:
        return Message(np.zeros((n, n)), np.zeros(n), 0.0)

    def moved(self, d: Array) -> Message:
        """The same function about a point d farther on."""
        return Message(self.J, self.h - self.J @ d, float(self.s + self.h @ d - d @ self.J @ d / 2))

    def before_noise(self, Q: Array) -> Message:
        """E[exp(message(x + w))] over w ~ N(0, Q): J (I + Q J)^-1 and (I + J Q)^-1 h."""
        J, log_det = parallel_sum(root(self.J), root(Q))
        h = self.h - J @ Q @ self.h
        s = self.s + 0.5 * (self.h @ Q @ h - log_det)
        return Message(J, h, float(s))

    def through(self, B: Array) -> Message:
        """As a function of y, where x = B y."""
        return Message(B.T @ self.J @ B, B.T @ self.h, self.s)

    def fused(self, mode: Mode) -> tuple[Mode, float]:
        """Posterior of N(x, P), covariance (P^-1 + J)^-1, and the log of the message's expectation."""
        P, log_det = parallel_sum(np.linalg.cholesky(mode.P), root(self.J))
        log_weight = self.s + 0.5 * (self.h @ P @ self.h - log_det)
        return Mode(mode.x + P @ self.h, P), float(log_weight)


def root(A: Array) -> Array:
    """R with R R' = A, semidefinite: by eigenvalues at unit diagonal, since units differ (radians, m)."""
    scale = np.sqrt(np.maximum(np.diag(A), 0.0))
    scale[scale == 0] = 1.0
    values, vectors = np.linalg.eigh(A / np.outer(scale, scale))
    return scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def parallel_sum(L: Array, R: Array) -> tuple[Array, float]:
    """(A^-1 + B)^-1 = L (I + L' B L)^-1 L' and log det(I + A B) for A = L L' (singular or not) and B = R R'.

    The middle is U'U, U the triangle of the QR decomposition of [I; R' L]: never formed, so never indefinite.
    """
    U = np.linalg.qr(np.vstack([np.eye(L.shape[1]), R.T @ L]), mode="r")
    out = np.linalg.solve(U.T, L.T)
    return out.T @ out, float(2 * np.log(np.abs(np.diag(U))).sum())


def measured(motion: Motion, at: Array, row: Row) -> Message:
    """log N(z; h(x), R) of the present components about `at`, without the part that is the same for every
    mode.
    """
    position, velocity = parts(motion)
    present = np.flatnonzero(row.present)
    h = row.sensor.h(at[position], at[velocity])
    H = np.zeros((len(h), motion.n))
    H[:, position], H[:, velocity] = row.sensor.H(at[position], at[velocity])
    nu = row.z[: len(h)] - h
    for i in row.sensor.angles:
        nu[i] = wrap(nu[i])
    nu, H = nu[present], H[present]
    information = np.linalg.inv(row.R[np.ix_(present, present)])
    return Message(H.T @ information @ H, H.T @ information @ nu, float(-0.5 * nu @ information @ nu))


def back(filter: Filter, before: Scan, after: Scan, messages: list[Message]):
    """Smoothed modes, probabilities and messages at k, from the messages at k+1."""
    motions, M = filter.motions, len(filter.motions)
    heard = []
    for motion, mode, message in zip(motions, after.modes, messages, strict=True):
        if after.used is not None:
            m = measured(motion, mode.x, after.used)
            message = Message(message.J + m.J, message.h + m.h, message.s + m.s)
        heard.append(message if after.linked else Message.silent(motion.n))
    fused: list[list[Mode]] = [[] for _ in range(M)]
    told: list[list[Message]] = [[] for _ in range(M)]
    log_w, Pi = np.zeros((M, M)), after.Pi if after.linked else np.eye(M)
    for i in range(M):
        for j in range(M):
            message = pair(filter, before, after, i, j, heard[j])
            mode, log_weight = message.fused(before.modes[i])
            fused[i].append(mode)
            told[i].append(message)
            log_w[i, j] = np.log(max(Pi[i, j] * before.mu[i], 1e-200)) + log_weight
    log_w -= logsumexp(log_w)
    mu = np.exp(logsumexp(log_w, axis=1))
    out = [collapse(before.modes[i], before.mu[i], log_w[i], fused[i], told[i]) for i in range(M)]
    return [mode for mode, _ in out], mu, [message for _, message in out]


def pair(filter: Filter, before: Scan, after: Scan, i: int, j: int, heard: Message) -> Message:
    """Mode j's message at k+1 as mode i at k hears it."""
    source, target = filter.motions[i], filter.motions[j]
    if not after.linked:
        return Message.silent(source.n)
    start = augment(source, before.modes[i], target, before.modes[j], filter.mixing)
    ahead = stepped(filter, after, j, start)
    A = selection(source, target)
    enters = start.P - A @ before.modes[i].P @ A.T
    noise = ahead.noise + ahead.A @ enters @ ahead.A.T
    return heard.moved(ahead.x - after.modes[j].x).before_noise(noise).through(ahead.A @ A)


def stepped(filter: Filter, after: Scan, j: int, start: Mode) -> Predicted:
    """Mode j's step to a scan; with the noise and the input that it was filtered with, where these adapt."""
    Q, u = after.steps[j] if after.steps is not None else (None, after.u)
    return predict(filter.motions[j], start.x, start.P, after.dt, u, filter.linearisation, Q)


def collapse(filtered: Mode, mu: float, log_w: Array, fused: list[Mode], told: list[Message]):
    """One mode's smoothed estimate and message from its pairs, whose weights sum to its probability."""
    share = np.exp(log_w - logsumexp(log_w))
    mode = match(share, fused)
    spread = sum(a * np.outer(m.x - mode.x, m.x - mode.x) for a, m in zip(share, fused, strict=True))
    J = sum(a * m.J for a, m in zip(share, told, strict=True))
    h = sum(a * m.h for a, m in zip(share, told, strict=True))
    message = Message(J, h, 0.0).before_noise(spread)
    message.s = 0.0
    message.s = float(logsumexp(log_w) - np.log(max(mu, 1e-200)) - message.fused(filtered)[1])
    return mode, message


def rts(filter: Filter, before: Scan, after: Scan, smoothed: Mode) -> Mode:
    """One mode's step."""
    (mode,) = before.modes
    ahead = stepped(filter, after, 0, mode)
    C = np.linalg.solve(ahead.P, ahead.A @ mode.P).T
    ICF = np.eye(len(mode.x)) - C @ ahead.A
    P = ICF @ mode.P @ ICF.T + C @ (ahead.noise + smoothed.P) @ C.T
    return Mode(mode.x + C @ (smoothed.x - ahead.x), symmetric(P))


def smooth(filter: Filter, filtered: Estimate) -> Estimate:
    """Backward over the filter's scans; no information crosses a start or restart."""
    scans = decided(filtered.scans)
    out = [replace(s) for s in scans]
    messages = [Message.silent(m.n) for m in filter.motions]
    for k in range(len(scans) - 2, -1, -1):
        before, after = scans[k], scans[k + 1]
        if not before.modes:
            continue
        if len(filter.motions) > 1:
            out[k].modes, out[k].mu, messages = back(filter, before, after, messages)
        elif after.linked:
            out[k].modes = [rts(filter, before, after, out[k + 1].modes[0])]
    return estimate(filter, out)
