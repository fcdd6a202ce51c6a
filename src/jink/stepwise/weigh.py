"""What a measurement says of modes and filter: Bayes' rule, NIS, probability integral transform."""

from math import erfc

import numpy as np

from .._engine import native
from .functions import Array
from .states import Outcome, States

LOG_TWO_PI = float(np.log(2 * np.pi))


def weigh(s: States, prior: Array, nis: list[Array], det: list[Array], out: Outcome) -> None:
    """Bayes' rule over the modes, and the log-likelihood of the measurement under their mixture."""
    score = np.log(prior) - 0.5 * (np.log(np.stack(det, axis=1)) + np.stack(nis, axis=1))
    most = score.max(axis=1)
    weight = np.exp(score - most[:, None])
    total = weight.sum(axis=1)
    s.probability = weight / total[:, None]
    likelihood = most + np.log(total) - 0.5 * LOG_TWO_PI * out.dof
    out.log_likelihood = np.where(out.measured, likelihood, 0.0)


def matched_nis(y: list[Array], joint: list[Array], prior: Array) -> Array:
    """NIS of the innovation moment-matched over the modes; nothing is present where y is 0 and S is 1."""
    mean, S = (y[0], joint[0]) if len(y) == 1 else native.mix(y, joint, prior)
    whitened = native.solve(native.root(S), mean[:, :, None])[:, :, 0]
    return (whitened * whitened).sum(axis=1)


def probability_transform(prior: Array, e: list[Array], S: list[Array]) -> Array:
    """Rosenblatt's transform of the measurement under the mixture, one component after the other."""
    log_prior = np.log(np.maximum(prior, 1e-300))
    pit: Array = np.empty(e[0].shape)
    cdf = np.frompyfunc(lambda u: 0.5 * erfc(-u * 0.7071067811865476), 1, 1)
    for r in range(pit.shape[1]):
        weight = np.exp(log_prior - log_prior.max(axis=1, keepdims=True))
        variance = np.stack([v[:, r] for v in S], axis=1)
        u = np.stack([v[:, r] for v in e], axis=1) / np.sqrt(variance)
        pit[:, r] = (weight * np.asarray(cdf(u), dtype=float)).sum(axis=1) / weight.sum(axis=1)
        log_prior = log_prior - 0.5 * (u * u + np.log(variance))
    return pit
