"""Linear filters of positions for many tracks at once: the textbook steps with any leading dimensions.

Arrays are (tracks, ...): a mode's x (B, n) and P (B, n, n), probabilities (B, M), measurements z (B, axes)
with NaN where missing. All tracks share their times. Nothing else is clever: dense matrices, Joseph's form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from oracle.gaussian import parts
from oracle.mixture import Mode, selection, union
from oracle.motion import Motion
from oracle.start import Fix, two_point

Array = NDArray[np.float64]


@dataclass
class Stepped(Mode):
    """A mode with what its last step was made with: Q (B, n, n) and the known acceleration u (B, axes), or None."""

    Q: Array
    u: Array | None


@dataclass
class Updated:
    """A mode after the update; residual z - H x- (B, axes) and log N(residual; 0, S) (B,)."""

    mode: Mode
    residual: Array
    S: Array
    log_likelihood: Array


@dataclass
class Estimates:
    """x (B, N, n), P (B, N, n, n) over the union of the components, mu (B, N, M); NaN before the start.

    modes: of each row each mode by itself.
    """

    x: Array
    P: Array
    mu: Array
    modes: list[list[Mode]] = field(default_factory=list)


def symmetric(P: Array) -> Array:
    return (P + np.swapaxes(P, -1, -2)) / 2


def apply(A: Array, x: Array) -> Array:
    return np.einsum("...ij,...j->...i", A, x)


def outer(a: Array) -> Array:
    return a[..., :, None] * a[..., None, :]


def predict(motion: Motion, mode: Mode, dt: float, u: Array | None = None, noise: Array | None = None) -> Mode:
    """x- = f(x) + G u, P- = F P F' + Q, where Q is the motion's own unless given."""
    x, F = motion.f(mode.x, dt), motion.F(mode.x, dt)
    if u is not None:
        x = x + apply(motion.input_matrix(dt), u)
    Q = motion.noise(mode.x, dt) if noise is None else noise
    P = symmetric(F @ mode.P @ F.T + Q)
    return Stepped(x, P, np.broadcast_to(Q, P.shape), u)


def measure_matrix(motion: Motion) -> Array:
    """H (axes, n): the positions."""
    return np.eye(motion.n)[parts(motion)[0]]


def update(motion: Motion, mode: Mode, z: Array, R: Array) -> Updated:
    """Update with positions; a missing one has an empty row in H, unit noise and no residual: no effect."""
    there = ~np.isnan(z)
    H = measure_matrix(motion) * there[..., None]
    noise = np.where(there[..., :, None] & there[..., None, :], R, np.eye(motion.axes))
    residual = np.where(there, z - apply(H, mode.x), 0.0)
    Ht = np.swapaxes(H, -1, -2)
    S = H @ mode.P @ Ht + noise
    K = mode.P @ Ht @ np.linalg.inv(S)
    keep = np.eye(motion.n) - K @ H
    P = keep @ mode.P @ np.swapaxes(keep, -1, -2) + K @ (noise * there[..., None]) @ np.swapaxes(K, -1, -2)
    square = np.einsum("...i,...ij,...j->...", residual, np.linalg.inv(S), residual)
    log_det = np.linalg.slogdet(S)[1] + there.sum(-1) * np.log(2 * np.pi)
    after = replace(mode, x=mode.x + apply(K, residual), P=symmetric(P))
    return Updated(after, residual, S, -(log_det + square) / 2)


def match(weights: Array, modes: list[Mode]) -> Mode:
    """Mean and covariance of a Gaussian mixture, weights (B, M)."""
    w = [weights[..., j] for j in range(len(modes))]
    x = sum(a[..., None] * m.x for a, m in zip(w, modes, strict=True))
    P = sum(a[..., None, None] * (m.P + outer(m.x - x)) for a, m in zip(w, modes, strict=True))
    return Mode(x, P)


def augment(source: Motion, mode: Mode, target: Motion) -> Mode:
    """The source's estimate in the target's components; one it lacks enters with the target's prior."""
    A = selection(source, target)
    new = [0.0 if c in source.components else target.prior_variance(c) for c in target.components]
    return Mode(apply(A, mode.x), A @ mode.P @ A.T + np.diag(new))


def mixed(motions: list[Motion], modes: list[Mode], weights: Array) -> list[Mode]:
    """Each mode's start: the mixture of all estimates with weights[:, i, j] (B, M, M), sums over i one."""
    out = []
    for j, target in enumerate(motions):
        sources = [augment(motions[i], modes[i], target) for i in range(len(motions))]
        out.append(match(weights[:, :, j], sources))
    return out


def combine(motions: list[Motion], modes: list[Mode], mu: Array) -> Mode:
    """The moment-matched estimate; a velocity-only mode's acceleration is zero."""
    names = union(motions)
    lifted = []
    for motion, mode in zip(motions, modes, strict=True):
        A = np.array([[float(c == name) for c in motion.components] for name in names])
        lifted.append(Mode(apply(A, mode.x), A @ mode.P @ A.T))
    return match(mu, lifted)


def backward_weights(Pi: Array, mu: Array) -> tuple[Array, Array]:
    """Predicted probabilities c_j = sum_i Pi_ij mu_i (B, M) and mixing weights Pi_ij mu_i / c_j (B, M, M).

    Pi (M, M) or one per track (B, M, M). A target that nothing can reach has weights of zero.
    """
    joint = Pi * mu[..., :, None]
    c = joint.sum(axis=-2)
    return c, np.divide(joint, c[..., None, :], out=np.zeros_like(joint), where=c[..., None, :] > 0)


def bayes(prior: Array, log_likelihood: Array) -> Array:
    """mu_j = c_j L_j / sum, in logs."""
    with np.errstate(divide="ignore"):
        log = np.log(prior) + log_likelihood
    return np.exp(log - logsumexp(log, axis=-1, keepdims=True))


def scanned(
    motions: list[Motion],
    starts: list[Mode],
    prior: Array,
    z: Array,
    R: Array,
    dt: float,
    inputs: list[Array] | None = None,
) -> tuple[list[Mode], Array]:
    """Each mode predicted from its start and updated, and the probabilities that come of the prior ones.

    A motion model whose noise depends on the position about to be used has `seen_noise`.
    """
    now = []
    for j, (motion, start) in enumerate(zip(motions, starts, strict=True)):
        u, noise = None if inputs is None else inputs[j], None
        if hasattr(motion, "seen_noise"):
            noise = motion.seen_noise(predict(motion, start, dt, u, np.zeros((motion.n, motion.n))), z, R, dt)
        now.append(update(motion, predict(motion, start, dt, u, noise), z, R))
    return [each.mode for each in now], bayes(prior, np.stack([e.log_likelihood for e in now], axis=-1))


def started(motions: list[Motion], time: Array, z: Array, R: Array) -> list[Mode]:
    """Two-point start from the first two rows of z (B, N, axes): the estimates after the second."""
    out = []
    for motion in motions:
        both = [
            two_point(motion, Fix(time[0], first, R), Fix(time[1], second, R))
            for first, second in zip(z[:, 0], z[:, 1], strict=True)
        ]
        out.append(Mode(np.array([m.x for m in both]), np.array([m.P for m in both])))
    return out


def along(
    motions: list[Motion],
    time: Array,
    z: Array,
    R: Array,
    mu: Array,
    step: Callable[[list[Mode], Array, int, float], tuple[list[Mode], Array]],
) -> Estimates:
    """Two-point start with probabilities mu (M,), then modes, mu = step(modes, mu, k, dt) row by row."""
    B, N, _ = z.shape
    modes, mu = started(motions, time, z, R), np.tile(np.asarray(mu, float), (B, 1))
    n = len(union(motions))
    out = Estimates(
        np.full((B, N, n), np.nan), np.full((B, N, n, n), np.nan), np.full((B, N, mu.shape[1]), np.nan), [[]]
    )
    for k in range(1, N):
        if k > 1:
            modes, mu = step(modes, mu, k, time[k] - time[k - 1])
        combined = combine(motions, modes, mu)
        out.x[:, k], out.P[:, k], out.mu[:, k] = combined.x, combined.P, mu
        out.modes.append(modes)
    return out


def each_axis(z: Array) -> Array:
    """(B, N, axes) as (B * axes, N, 1): axes treated independently are simply more tracks."""
    return np.moveaxis(z, 2, 1).reshape(-1, z.shape[1], 1)


def joined(per_axis: Array, axes: int) -> Array:
    """(B * axes, N, n) back to (B, N, axes, n)."""
    split = per_axis.reshape(-1, axes, *per_axis.shape[1:])
    return np.moveaxis(split, 1, 2)


def imm(
    motions: list[Motion],
    time: Array,
    z: Array,
    R: Array,
    Pi: Array,
    mu: Array,
    u: Array | None = None,
) -> Estimates:
    """Interacting multiple models (Blom & Bar-Shalom 1988); u (B, N, M, axes): each mode's known input."""

    def step(modes, mu, k, dt):
        c, weights = backward_weights(Pi, mu)
        inputs = None if u is None else [u[:, k, j] for j in range(len(motions))]
        return scanned(motions, mixed(motions, modes, weights), c, z[:, k], R, dt, inputs)

    return along(motions, time, z, R, mu, step)
