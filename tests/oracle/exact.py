"""Exact answers, at exponential or cubic cost: condition one large Gaussian, and enumerate every sequence of
modes.

For linear models the states x(0..N-1) given a mode sequence are jointly Gaussian; measurements are linear in
them, so filtered and smoothed moments and the likelihood are one conditioning. A jump Markov system's are the
sum over sequences.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from oracle.mixture import Mode, match, selection

Array = NDArray[np.float64]


def joint(motions, sequence, start: Mode, dts, u=None) -> tuple[list[Array], list[list[Array]]]:
    """Means m[k] and covariances C[k][l] of the states along a sequence of motion models (dts[0] unused)."""
    m, C = [start.x], [[start.P]]
    for k in range(1, len(sequence)):
        source, target = motions[sequence[k - 1]], motions[sequence[k]]
        A, new = selection(source, target), np.zeros((target.n, target.n))
        for i, name in enumerate(target.components):
            if name not in source.components:
                new[i, i] = target.prior_variance(name)
        F = target.F(None, dts[k])
        mean = F @ A @ m[-1]
        if u is not None:
            mean = mean + target.input_matrix(dts[k]) @ u[k]
        last = [F @ A @ C[k - 1][j] for j in range(k)]  # covariance of x(k) with x(0..k-1)
        P = F @ (A @ C[k - 1][k - 1] @ A.T + new) @ F.T + target.Q(dts[k])
        for j in range(k):
            C[j].append(last[j].T)
        C.append([*last, P])
        m.append(mean)
    return m, C


def condition(motions, sequence, start: Mode, dts, z, R, u=None) -> tuple[list[Mode], float]:
    """Smoothed moments of every state and log p(z), positions measured, NaN missing."""
    m, C = joint(motions, sequence, start, dts, u)
    sizes = [motions[s].n for s in sequence]
    offsets = np.r_[0, np.cumsum(sizes)]
    mean, cov = np.concatenate(m), np.block(C)
    rows, values, noise = [], [], []
    for k, s in enumerate(sequence):
        for a in range(motions[s].axes):
            if not np.isnan(z[k, a]):
                rows.append(offsets[k] + motions[s].index("p" + "xyz"[a]))
                values.append(z[k, a])
                noise.append(R[a, a])
    S = cov[np.ix_(rows, rows)] + np.diag(noise)
    nu = np.array(values) - mean[rows]
    gain = np.linalg.solve(S, cov[rows]).T
    x, P = mean + gain @ nu, cov - gain @ cov[rows]
    log_likelihood = -0.5 * (np.linalg.slogdet(2 * np.pi * S)[1] + nu @ np.linalg.solve(S, nu))
    cuts = [slice(offsets[k], offsets[k + 1]) for k in range(len(sequence))]
    return [Mode(x[c], P[c, c]) for c in cuts], float(log_likelihood)


def enumerate_sequences(motions, starts: list[Mode], mu, chain, dts, z, R):
    """Exact smoothed (probabilities (N, M), per-mode moments [k][j], log p(z)) over all M^N sequences."""
    N, M = len(dts), len(motions)
    steps = [chain.over(dt) for dt in dts]
    weights, smoothed, sequences = [], [], list(product(range(M), repeat=N))
    for s in sequences:
        moments, log_likelihood = condition(motions, s, starts[s[0]], dts, z, R)
        prior = mu[s[0]] * np.prod([steps[k][s[k - 1], s[k]] for k in range(1, N)])
        weights.append(np.log(prior) + log_likelihood)
        smoothed.append(moments)
    weights = np.array(weights)
    total = np.logaddexp.reduce(weights)
    p = np.exp(weights - total)
    probability, modes = np.zeros((N, M)), []
    for k in range(N):
        modes.append([])
        for j in range(M):
            chosen = [i for i, s in enumerate(sequences) if s[k] == j]
            probability[k, j] = p[chosen].sum()
            modes[k].append(match(p[chosen] / probability[k, j], [smoothed[i][k] for i in chosen]))
    return probability, modes, float(total)
