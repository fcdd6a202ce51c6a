"""Outliers decided with hindsight: a row that may be the target's or not is followed both ways until the next one.

p = (1 - eps) N / ((1 - eps) N + eps / V) says that a row is the target's, N being its density over all modes. Where p
and 1 - p exceed LEAST the track goes on as two banks of weight p (updated) and 1 - p (predicted). The next row has the
density sum w_b c_bj N_bj. Mode by mode, the updated estimates are matched with weights w_b c_bj N_bj and the predicted
ones with w_b c_bj; between these two the next row is again the target's or not. A row of nothing decides nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from oracle.coasting import coasted
from oracle.gaussian import Predicted, predict, update
from oracle.mixture import Mode, match, mix
from oracle.tracker import GATED, PREDICTED, RESTARTED, UPDATED, Row, Scan, Track

Array = NDArray[np.float64]
LEAST = 1e-6


@dataclass
class Bank:
    modes: list[Mode]
    mu: Array
    weight: float


@dataclass
class Doubt:
    """Both banks after a scan, and what the next row said of the row in doubt: is it the target's?"""

    believed: Bank
    doubted: Bank
    used: Row | None
    upheld: bool | None = None


def merged(weights: Array, modes: list[list[Mode]]) -> tuple[list[Mode], Array]:
    """Banks b of modes j with weights (b, j) as one bank, mode by mode, and its mode probabilities."""
    mu = weights.sum(axis=0)
    out = []
    for j in range(weights.shape[1]):
        share = weights[:, j] / mu[j] if mu[j] > 1e-300 else weights.sum(axis=1) / weights.sum()
        out.append(match(share, [bank[j] for bank in modes]))
    return out, mu / mu.sum()


class HindsightTrack(Track):
    """With the banks of the last row, if it is in doubt."""

    doubt: Doubt | None = None

    def advance(self, scan: Scan, row: Row) -> None:
        if self.first is not None:
            super().advance(scan, row)
            return
        banks = [Bank(self.modes, self.mu, 1.0)] if self.doubt is None else [self.doubt.believed, self.doubt.doubted]
        ahead = [self.predicted(scan, row, bank) for bank in banks]
        scan.status, scan.linked = PREDICTED, True
        w = np.array([bank.weight for bank in banks])
        c = w[:, None] * np.array([c for c, _ in ahead])
        plain = [[Mode(p.x, p.P) for p in of] for _, of in ahead]
        none_modes, none_mu = merged(c, plain)
        scan.predicted = [Predicted(m.x, m.P, p.A, p.noise) for m, p in zip(none_modes, ahead[0][1], strict=True)]
        if not row.present.any():
            if self.doubt is not None:
                parts = [Bank(m, own[0], b.weight) for m, own, b in zip(plain, ahead, banks, strict=True)]
                self.doubt = scan.doubt = Doubt(*parts, None)
            self.modes, self.mu = none_modes, none_mu
            return
        self.measured(scan, row, c, [of for _, of in ahead], (none_modes, none_mu))

    def predicted(self, scan: Scan, row: Row, bank: Bank) -> tuple[Array, list[Predicted]]:
        f = self.filter
        c, mixed = mix(f.motions, bank.modes, bank.mu, scan.Pi, f.mixing)
        ahead = [predict(m, x.x, x.P, scan.dt, scan.u, f.linearisation) for m, x in zip(f.motions, mixed, strict=True)]
        if f.coasting is not None:
            late = [min(max(row.time - t - f.coasting.after, 0.0), scan.dt) for t in (self.seen, self.seen_height)]
            ahead = [
                replace(p, x=coasted(f.coasting, m, x.x, p.x, scan.dt, *late))
                for m, x, p in zip(f.motions, mixed, ahead, strict=True)
            ]
        return c, ahead

    def measured(self, scan: Scan, row: Row, c: Array, ahead: list[list[Predicted]], none: tuple) -> None:
        f, work = self.filter, row.converted()
        found = [
            [
                update(m, work.sensor, p.x, p.P, work.z, work.R, f.linearisation)
                for m, p in zip(f.motions, of, strict=True)
            ]
            for of in ahead
        ]
        log_N = np.array([[u.log_likelihood for u in of] for of in found])
        with np.errstate(divide="ignore"):
            log_joint = np.log(c) + log_N
        every = [u for of in found for u in of]
        self.score(scan, c.ravel(), every, work, logsumexp(log_joint))
        target = np.log1p(-f.outliers.share) + logsumexp(log_joint)
        outlier = np.log(f.outliers.share) + f.outliers.log_density(work)
        if self.doubt is not None:
            inlier = np.log1p(-f.outliers.share) + logsumexp(log_joint, axis=1)
            both = np.logaddexp(inlier, outlier + np.log(c.sum(axis=1)))
            for before in reversed(self.scans):  # rows of nothing since then wait for the same decision
                if before.doubt is None or before.doubt.upheld is not None:
                    break
                before.doubt.upheld = bool(both[0] >= both[1])
                if before.doubt.upheld and before.doubt.used is not None:
                    self.accepted_late(before.doubt.used)
            self.doubt = None
        weights = np.exp(log_joint - log_joint.max())
        believed = merged(weights, [[Mode(u.x, u.P) for u in of] for of in found])
        doubtful = abs(target - outlier) < -np.log(LEAST)
        explained = self.explained(every, work) if scan.status == GATED or doubtful else 0.0
        if scan.status == GATED and explained:
            wide = [
                update(m, work.sensor, p.x, explained * p.P, work.z, work.R, f.linearisation)
                for m, p in zip(f.motions, none[0], strict=True)
            ]
            log_wide = np.log(none[1]) + np.array([u.log_likelihood for u in wide])
            believed = [Mode(u.x, u.P) for u in wide], np.exp(log_wide - logsumexp(log_wide))
            scan.status = UPDATED
        self.modes, self.mu = none if scan.status == GATED else believed
        scan.used = None if scan.status == GATED else work
        if scan.status == GATED:
            self.reject(scan, row)
        else:
            self.rejected, scan.status = 0, UPDATED
            self.remember(every, int(work.present.sum()))
        weight = 1.0 / (1.0 + np.exp(np.clip(target - outlier, -700.0, 700.0)))
        if scan.status == RESTARTED or explained or not doubtful:
            return
        self.doubt = scan.doubt = Doubt(Bank(*believed, 1.0 - weight), Bank(*none, weight), work)
        self.modes, self.mu = merged(np.array([(1.0 - weight) * believed[1], weight * none[1]]), [believed[0], none[0]])

    def accepted_late(self, row: Row) -> None:
        self.seen = max(self.seen, row.time)
        if row.present[min(2, len(row.present) - 1)]:
            self.seen_height = max(self.seen_height, row.time)


def decided(scans: list[Scan]) -> list[Scan]:
    """As the smoother takes them: what was in doubt is decided, where a later row did so."""
    out = []
    for scan in scans:
        doubt = scan.doubt
        if doubt is not None and doubt.upheld is not None:
            bank = doubt.believed if doubt.upheld else doubt.doubted
            used = doubt.used if doubt.upheld else None
            status = scan.status if scan.status == PREDICTED else UPDATED if doubt.upheld else GATED
            scan = replace(scan, modes=bank.modes, mu=bank.mu, used=used, status=status)
        out.append(scan)
    return out
