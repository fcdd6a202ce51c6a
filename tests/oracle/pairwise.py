"""Smoothing several modes by recursion on the estimates of pairs of modes: what smoother.py is compared with.

Backward over pairs (i at k, j at k+1): one Rauch-Tung-Striebel step from mode i's filtered estimate through
the augmentation i -> j; collapse over j for each i with the pair weights; combine over i as the filter does.

With rule "future" the step goes to the pair's own smoothed state: mode j's smoothed estimate divided by its
prediction is what the future measures, and that updates the pair's prediction (after Helmick, Blair, Hoffman,
IEEE T-IT 41(6), 1995). The other rules step to mode j's smoothed state as if it did not depend on i and
differ in the pair weights; they are several times farther from the exact answer (test_oracle_imm.py) and can
diverge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oracle.gaussian import Predicted, predict, symmetric
from oracle.mixture import Mode, augment, match, selection
from oracle.tracker import Estimate, Filter, Scan, estimate

Array = NDArray[np.float64]


def log_normal(d: Array, S: Array) -> float:
    _, logdet = np.linalg.slogdet(2 * np.pi * S)
    return float(-0.5 * (logdet + d @ np.linalg.solve(S, d)))


@dataclass
class Pair:
    """Mode i at k predicted as mode j at k+1: x_j = B x_i + (what entered and the process noise, covariance
    `noise`).
    """

    ahead: Predicted
    B: Array
    noise: Array


def pair(filter: Filter, scan: Scan, modes: list[Mode], i: int, j: int) -> Pair:
    source, target = filter.motions[i], filter.motions[j]
    at = augment(source, modes[i], target, modes[j], filter.mixing)
    ahead = predict(target, at.x, at.P, scan.dt, scan.u, filter.linearisation)
    A = selection(source, target)
    new = at.P - A @ modes[i].P @ A.T
    return Pair(ahead, ahead.A @ A, ahead.noise + ahead.A @ new @ ahead.A.T)


def rts(mode: Mode, step: Pair, target: Mode) -> Mode:
    """C = P B' P^-1, x + C (x_s - x^-), (I - C B) P (I - C B)' + C (noise + P_s) C'."""
    C = np.linalg.solve(step.ahead.P, step.B @ mode.P).T
    ICB = np.eye(len(mode.x)) - C @ step.B
    P = ICB @ mode.P @ ICB.T + C @ (step.noise + target.P) @ C.T
    return Mode(mode.x + C @ (target.x - step.ahead.x), symmetric(P))


def log_weight(rule: str, smoothed: Mode, ahead: Predicted) -> float:
    """What the smoothed state of mode j says of its having come from mode i.

    "kim": nothing (Kim 1994). "point": N(x_s; x^-, P^-), the smoothed mean as if it were the state.
    "density": N(x_s; x^-, P^- + P_s), the density of the mean with its uncertainty.
    """
    if rule == "kim":
        return 0.0
    P = ahead.P + smoothed.P if rule == "density" else ahead.P
    return log_normal(smoothed.x - ahead.x, P)


def future(predicted: Predicted, smoothed: Mode) -> tuple[Array, Array, Array]:
    """What is measured from this scan on, as one measurement y = H (x - x^-) + e, e ~ N(0, diag(1/w)): (y, H,
    1/w).

    Its information is P_s^-1 - P^-1, of the moment-matched prediction and the smoothed estimate of one mode,
    in the coordinates where P^- = I; directions in which smoothing taught nothing (or matching made it worse)
    are left out.
    """
    root = np.linalg.cholesky(predicted.P)
    whiten = np.linalg.inv(root)
    P = whiten @ smoothed.P @ whiten.T
    w, V = np.linalg.eigh(np.linalg.inv(symmetric(P)) - np.eye(len(P)))
    eta = V.T @ np.linalg.solve(P, whiten @ (smoothed.x - predicted.x))
    keep = w > 1e-9
    return eta[keep] / w[keep], (V.T @ whiten)[keep], 1 / w[keep]


def given_future(ahead: Predicted, predicted: Predicted, seen: tuple[Array, Array, Array]) -> tuple[Mode, float]:
    """The pair's own smoothed state at k+1, its prediction updated by the future, and that update's log-
    likelihood.
    """
    y, H, variance = seen
    nu, S = y - H @ (ahead.x - predicted.x), H @ ahead.P @ H.T + np.diag(variance)
    K = np.linalg.solve(S, H @ ahead.P).T
    IKH = np.eye(len(ahead.x)) - K @ H
    P = IKH @ ahead.P @ IKH.T + K @ np.diag(variance) @ K.T
    return Mode(ahead.x + K @ nu, symmetric(P)), log_normal(nu, S)


def back(filter: Filter, before: Scan, after: Scan, smoothed: list[Mode], mu_s: Array, rule: str):
    """Smoothed modes and probabilities at k from those at k+1."""
    M = len(filter.motions)
    gamma, pairs = np.zeros((M, M)), [[before.modes[0]] * M for _ in range(M)]
    for j in range(M):
        log_g = np.full(M, -np.inf)
        seen = future(after.predicted[j], smoothed[j]) if rule == "future" else None
        for i in range(M):
            prior = after.Pi[i, j] * before.mu[i]
            if prior <= 0:
                continue
            step = pair(filter, after, before.modes, i, j)
            if seen is None:
                target, log_weigh = smoothed[j], log_weight(rule, smoothed[j], step.ahead)
            else:
                target, log_weigh = given_future(step.ahead, after.predicted[j], seen)
            log_g[i] = np.log(prior) + log_weigh
            pairs[i][j] = rts(before.modes[i], step, target)
        if np.isfinite(log_g).any():
            weight = np.exp(log_g - log_g.max())
            gamma[:, j] = mu_s[j] * weight / weight.sum()
    mu, modes = gamma.sum(axis=1), []
    for i in range(M):
        used = [j for j in range(M) if gamma[i, j] > 0]
        modes.append(match(gamma[i, used] / mu[i], [pairs[i][j] for j in used]) if used else before.modes[i])
    return modes, mu


def smooth(filter: Filter, filtered: Estimate, rule: str = "future") -> Estimate:
    """Backward over the filter's scans; no information crosses a start or restart."""
    scans = filtered.scans
    out = [replace(s) for s in scans]
    for k in range(len(scans) - 2, -1, -1):
        before, after = scans[k], scans[k + 1]
        if not before.modes or not after.linked:
            continue
        out[k].modes, out[k].mu = back(filter, before, after, out[k + 1].modes, out[k + 1].mu, rule)
    return estimate(filter, out)
