"""The near-optimal reference: a Gaussian hypothesis tree that knows how the targets are drawn.

Each hypothesis says when the target last changed between quiet and manoeuvring. Every scan each of them goes
on, and some are born: all manoeuvring ones may end now, all quiet ones may start one now, their pasts merged
into one Gaussian. Beyond K, the lightest is merged into its neighbour in time. That this is close to the
exact posterior mean is shown, not assumed: the squared error over its covariance (NEES per component) is 1,
and more hypotheses change nothing.

Source: Blackman & Popoli 1999, ch. 16 (hypothesis trees); Salmond, SPIE 1305, 1990 (merging by moments).
"""

from __future__ import annotations

import math

import numpy as np

from ..checks import by_hints
from ..frozen import frozen
from ..metrics.consistency import nees
from .hypotheses import Array, Hypotheses, fuse_lightest, join, moments, switch, update
from .priors import Prior

CHUNK = 250  # runs at a time: their hypotheses stay in the processor's cache


@frozen
class Reference:
    """What the reference knows after each scan.

    x (runs, scans, n) and P (runs, scans, n, n) in ``components``; position, velocity, acceleration
    (runs, scans, axes) in m and s; manoeuvring (runs, scans): probability that any axis is;
    log_likelihood_scan (runs, scans): log p(z_k | z_0 … z_{k−1}).
    """

    components: tuple[str, ...]
    x: Array
    P: Array
    position: Array
    velocity: Array
    acceleration: Array
    manoeuvring: Array
    log_likelihood_scan: Array

    def nees(self, position: Array, velocity: Array) -> Array:
        """Squared error of position and velocity over its covariance, per component, (runs, scans).

        eᵀ P⁻¹ e / (2 axes); 1 on average over runs and scans proves the reference, truth being (runs, scans, axes).
        """
        axes = position.shape[2]
        index = [self.components.index(f"{c}{axis}") for c in "pv" for axis in "xyz"[:axes]]
        error = np.concatenate([self.position - position, self.velocity - velocity], axis=2)
        return nees(error, self.P[..., index, :][..., index]) / (2 * axes)


@by_hints
def near_optimal(z: Array, prior: Prior, *, sd: float, T: float = 1.0, hypotheses: int = 32) -> Reference:
    """Filter positions of targets drawn from ``prior``, starting quiet at an unknown place and velocity.

    z (runs, scans, axes) m, NaN where missing; sd of each measured component (m); T (s) between scans;
    hypotheses kept per run (and per axis where the prior has independent axes).
    Errors: ValueError for wrong shapes, or a run without measurements.
    """
    z = np.asarray(z, dtype=float)
    if z.ndim != 3 or (not prior.per_axis and z.shape[2] != 2):
        raise ValueError(f"z: expected (runs, scans, {'axes' if prior.per_axis else '2'}), got {z.shape}")
    if not (sd > 0 and T > 0 and hypotheses >= 8):
        raise ValueError(
            f"sd, T and hypotheses: expected sd and T above 0 and hypotheses from 8, got {sd}, {T} and {hypotheses}"
        )
    empty = (~np.isfinite(z)).all(axis=1).any(axis=-1)
    if empty.any():
        raise ValueError(
            f"z: expected a measurement in every axis of each run; run {int(np.argmax(empty))} has an axis without one"
        )
    runs, scans, axes = z.shape
    rows = z.swapaxes(1, 2).reshape(runs * axes, scans, 1) if prior.per_axis else z
    done = [_run(rows[k : k + CHUNK], prior, sd, T, hypotheses) for k in range(0, len(rows), CHUNK)]
    x, P, busy, log_likelihood = (np.concatenate(parts) for parts in zip(*done, strict=True))
    if prior.per_axis:
        return _join_axes(x, P, busy, log_likelihood, axes)
    return _turning(x, P, busy, log_likelihood)


def _run(z: Array, prior: Prior, sd: float, T: float, hypotheses: int) -> tuple[Array, Array, Array, Array]:
    runs, scans, _ = z.shape
    n = prior.size
    x, P = np.empty((runs, scans, n)), np.empty((runs, scans, n, n))
    busy, log_likelihood = np.empty((runs, scans)), np.empty((runs, scans))
    h = _start(z, prior, sd)
    for k in range(scans):
        if k:
            h = prior.predict(_branch(h, prior, T, k), T)
        log_likelihood[:, k] = update(h, z[:, k], sd * sd, prior.measured)
        while len(h) > hypotheses:
            h = fuse_lightest(h)
        weight = np.exp(h.log_weight)
        mean, cov = moments(weight, h.x, h.P)
        x[:, k], P[:, k], busy[:, k] = mean.T, np.moveaxis(cov, -1, 0), (weight * (h.kind > 0)).sum(axis=1)
    return x, P, busy, log_likelihood


def _start(z: Array, prior: Prior, sd: float, velocity_sd: float = 1e5) -> Hypotheses:
    """One quiet hypothesis per run, around its first measurement ± 10⁴ sd, velocity 0 ± velocity_sd (m/s)."""
    runs, n = len(z), prior.size
    x, P = np.zeros((n, runs, 1)), np.zeros((n, n, runs, 1))
    for column, m in enumerate(prior.measured):
        first = np.isfinite(z[:, :, column]).argmax(axis=1)
        x[m, :, 0] = z[np.arange(runs), first, column]
        P[m, m], P[m + 1, m + 1] = (1e4 * sd) ** 2, velocity_sd**2
    return Hypotheses(np.zeros((runs, 1)), np.zeros((runs, 1), np.int8), np.zeros((runs, 1), np.int32), x, P)


def _branch(h: Hypotheses, prior: Prior, T: float, scan: int) -> Hypotheses:
    start, end = min(T / prior.quiet_time, 1 - 1e-9), min(T / prior.manoeuvre_time, 1 - 1e-9)
    born = switch(h, True, math.log(start), prior.levels(), scan)
    if h.kind.any():
        born += switch(h, False, math.log(end), [(0.0, 0.0)], scan)
    h.log_weight = h.log_weight + np.where(h.kind > 0, math.log1p(-end), math.log1p(-start))
    return join([h, *born])


def _join_axes(x: Array, P: Array, busy: Array, log_likelihood: Array, axes: int) -> Reference:
    """Independent axes side by side: px vx ax py vy ay …"""
    runs, scans = len(x) // axes, x.shape[1]
    apart = x.reshape(runs, axes, scans, 3).swapaxes(1, 2)
    cov = np.zeros((runs, scans, axes, 3, axes, 3))
    for a, block in enumerate(np.moveaxis(P.reshape(runs, axes, scans, 3, 3), 1, 0)):
        cov[:, :, a, :, a] = block
    names = tuple(f"{c}{axis}" for axis in "xyz"[:axes] for c in "pva")
    quiet = (1 - busy.reshape(runs, axes, scans)).prod(axis=1)
    n = 3 * axes
    return Reference(
        components=names,
        x=apart.reshape(runs, scans, n),
        P=cov.reshape(runs, scans, n, n),
        position=apart[..., 0],
        velocity=apart[..., 1],
        acceleration=apart[..., 2],
        manoeuvring=1 - quiet,
        log_likelihood_scan=log_likelihood.reshape(runs, axes, scans).sum(axis=1),
    )


def _turning(x: Array, P: Array, busy: Array, log_likelihood: Array) -> Reference:
    velocity, rate = x[..., [1, 3]], x[..., 4:]
    acceleration = rate * np.stack([-velocity[..., 1], velocity[..., 0]], axis=-1)
    names = ("px", "vx", "py", "vy", "turn_rate")
    return Reference(names, x, P, x[..., [0, 2]], velocity, acceleration, busy, log_likelihood)
