"""What a correction in the plane looks at, and what it should have said, of many tracks at once."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from ..checks import Array
from ..estimate import Status
from ..frozen import frozen

FIRST = 5  # scans of a track that are not learned from
TURNING = 1.5  # m/s²: a target that accelerates more in the plane
FEWEST_TURNING = 50  # rows
# as core/scan/plane_corrector.hpp has them
FAST, SLOW, AVERAGE, MOST, FASTEST = 0.6, 0.85, 0.04, 10.0, 6.0


@frozen(kw_only=True, eq=False)
class Pairs:
    """Rows to learn from: scans of tracks in their order.

    even (N, inputs) and odd (N, ODD); error (N, 4): what the estimate lacks, along and across in position and in
    velocity, over its own sds; weight (N, 4): what a square of it counts, 0 for scans that are only remembered; inverse
    (N, 4, 4) of the covariance of ``error``; begins (N,): nothing is remembered of the row before.
    """

    even: Array
    odd: Array
    error: Array
    weight: Array
    inverse: Array
    begins: np.ndarray

    def __len__(self) -> int:
        return len(self.even)

    @staticmethod
    def joined(parts: list[Pairs]) -> Pairs:
        """One after the other."""
        return Pairs(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Pairs)})

    def some(self, which: np.ndarray) -> Pairs:
        """Of them those of a mask."""
        return Pairs(**{f.name: getattr(self, f.name)[which] for f in fields(self)})


@frozen(kw_only=True)
class Weighing:
    """What the square of an error counts. turning: share of all squares that is of turning targets; cap: NEES over 4 at
    which a square counts half, so that a few lost tracks do not decide.
    """

    turning: float = 0.0
    cap: float = np.inf


PLAIN = Weighing()


@frozen(kw_only=True, eq=False)
class Watched:
    """Of each scan of many tracks (B, S): the combined estimate before and after it, and the modes' probabilities."""

    before: Array
    P_before: Array
    after: Array
    P_after: Array
    prior: Array
    probability: Array
    status: np.ndarray
    names: list[str]

    def block(self, letter: str, when: str = "after") -> tuple[Array, Array]:
        """Position, velocity or acceleration (B, S, 2) in the plane, and their covariance."""
        at = [self.names.index(letter + axis) for axis in "xy"]
        P = getattr(self, f"P_{when}")
        return getattr(self, when)[..., at], P[..., at, :][..., at]


def watch(filter: Any, time: Array, z: Array, covariance: Array | None = None) -> Watched:
    """Run a filter over time (B, S) and z (B, S, axes), every scan once without its measurement and once with it.

    covariance (B, S, axes, axes) of z, where it is not the sensor's.
    """
    B, S, axes = z.shape
    doubled = np.full((B, S, 2, axes), np.nan)
    doubled[:, :, 1] = z
    said = filter.filter(
        np.repeat(time.reshape(-1), 2),
        doubled.reshape(-1, axes),
        offsets=np.arange(B + 1) * 2 * S,
        covariance=None if covariance is None else np.repeat(covariance.reshape(-1, axes, axes), 2, axis=0),
        threads=1,
        outputs=("x", "P", "status", "mode_probability"),
    )
    x, P, mu = (v.reshape(B, S, 2, *v.shape[1:]) for v in (said.x, said.P, said.mode_probability))
    return Watched(
        before=x[:, :, 0],
        P_before=P[:, :, 0],
        after=x[:, :, 1],
        P_after=P[:, :, 1],
        prior=mu[:, :, 0],
        probability=mu[:, :, 1],
        status=said.status.reshape(B, S, 2)[:, :, 1],
        names=list(filter.components),
    )


def pairs_of(
    filter: Any,
    time: Array,
    z: Array,
    R: Array,
    position: Array,
    velocity: Array,
    acceleration: Array | None = None,
    weighing: Weighing = PLAIN,
) -> Pairs:
    """Rows of tracks with their truth in the plane (B, S, 2); R (2, 2) of the measurements, or (B, S, axes, axes).

    Squares count so that all tracks together weigh two, half of it for the position, per row.
    """
    seen = watch(filter, time, z, R if R.ndim > 2 else None)
    even, odd, e, n = inputs_of(seen, time, z, R[..., :2, :2])
    (p, Pp), (v, Pv) = seen.block("p"), seen.block("v")
    off = position - p, velocity - v
    taken = (seen.status == Status.updated) & np.isfinite(z[..., :2]).all(axis=-1)
    good = taken & np.isfinite(off[0] + off[1]).all(axis=-1)
    good[:, :FIRST] = False
    unit = np.stack([np.sqrt(_form(P, d, d)) for P in (Pp, Pv) for d in (e, n)], axis=-1)[taken]
    error = np.stack([(o * d).sum(axis=-1) for o in off for d in (e, n)], axis=-1)[taken] / unit
    at = [seen.names.index(letter + axis) for letter in "pv" for axis in "xy"]
    J = np.zeros((*e.shape[:2], 4, 4))  # to along and across
    for k in (0, 2):
        J[..., k, k : k + 2], J[..., k + 1, k : k + 2] = e, n
    J = J[taken] / unit[:, :, None]
    P = J @ seen.P_after[taken][:, at][:, :, at] @ J.swapaxes(1, 2)
    inverse = np.asarray(np.linalg.inv(P), dtype=float)
    counts, weight = good[taken], np.zeros_like(unit)
    turning = None if acceleration is None else np.hypot(*np.moveaxis(acceleration[good], -1, 0)) > TURNING
    mean = _means([(o[good] ** 2).sum(axis=-1) for o in off], error[counts], inverse[counts], turning, weighing)
    weight[counts] = unit[counts] ** 2 / np.repeat(mean, 2, axis=-1)
    columns = even[taken], odd[taken], np.where(counts[:, None], error, 0.0), weight, inverse
    names = ("even", "odd", "error", "weight", "inverse")
    narrow: dict[str, Any] = {name: a.astype(np.float32) for name, a in zip(names, columns, strict=True)}
    return Pairs(**narrow, begins=_begins(seen.status, taken))


def _begins(status: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Of the scans that were taken, the first ones of a track and after a restart."""
    began = np.isin(status, (Status.initialised, Status.restarted))
    began[:, 0] = True
    track = np.cumsum(began.reshape(-1)).reshape(began.shape)[taken]
    return np.r_[True, np.diff(track) > 0] if len(track) else np.zeros(0, bool)


def _means(squares: list[Array], error: Array, inverse: Array, turning: np.ndarray | None, weighing: Weighing) -> Array:
    """What a square of position and of velocity is divided by in each row, (N, 2)."""
    nees = np.einsum("ni,nij,nj->n", error, inverse, error) / 4
    out = []
    for square in squares:
        mean = np.full(len(square), square.mean())
        if weighing.turning and turning is not None and turning.sum() >= FEWEST_TURNING:
            of_turns = square[turning].sum() / len(square)
            mean = 1.0 / ((1.0 - weighing.turning) / mean + weighing.turning * turning / of_turns)
        if np.isfinite(weighing.cap):
            mean = mean * (1.0 + nees / weighing.cap)
            mean = mean * (square / mean).mean()
        out.append(mean)
    return np.stack(out, axis=-1)


def _form(M: Array, a: Array, b: Array) -> Array:
    return np.einsum("...i,...ij,...j->...", a, M, b)


def _size(M: Array) -> Array:
    return np.sqrt((M[..., 0, 0] + M[..., 1, 1]) / 2)


def inputs_of(seen: Watched, time: Array, z: Array, R: Array) -> tuple[Array, Array, Array, Array]:
    """Even inputs (B, S, inputs), odd ones (B, S, ODD), and the unit vectors along and across: docs/corrector.md."""
    (before, P_before), (_, Pp), (v, Pv), (a, _) = (
        seen.block("p", "before"), seen.block("p"), seen.block("v"), seen.block("a")
    )  # fmt: skip
    speed = np.linalg.norm(v, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        e = np.where((speed > 0)[..., None], v / speed[..., None], [1.0, 0.0])
    n = np.stack([-e[..., 1], e[..., 0]], axis=-1)
    taken = (seen.status == Status.updated) & np.isfinite(z[..., :2]).all(axis=-1)
    nu, S = np.where(taken[..., None], z[..., :2] - before, 0.0), P_before + R
    began = np.isin(seen.status, (Status.initialised, Status.restarted))
    fast, slow, square, quiet, dt = _memory(nu / _size(S)[..., None], seen.probability[..., 0], taken, began, time)
    p_sd, v_sd, z_sd = _size(Pp), _size(Pv), _size(np.broadcast_to(R, Pp.shape))
    pull, tau = p_sd / v_sd**2, p_sd / v_sd
    turn = seen.after[..., seen.names.index("turn_rate")] if "turn_rate" in seen.names else 0.0 * speed

    def ln(values: Array) -> Array:
        return np.log(np.maximum(values, 1e-12))

    def of(vector: Array, along: Array) -> Array:
        return (vector * along).sum(axis=-1)

    modes = seen.probability.shape[-1] - 1
    even = [
        of(nu, e) / np.sqrt(_form(S, e, e)),
        of(a, e) * pull,
        *(seen.probability[..., j] for j in range(modes)),
        ln(p_sd / z_sd),
        ln(dt / tau),
        np.minimum(ln(speed / v_sd), FASTEST),
        (_form(Pv, e, e) - _form(Pv, n, n)) / (2 * v_sd**2),
        of(fast, e),
        of(slow, e),
        *(seen.prior[..., j] for j in range(modes)),
        ln(z_sd),
        ln(dt),
        square,
        quiet,
    ]
    odd = [
        of(nu, n) / np.sqrt(_form(S, n, n)),
        of(a, n) * pull,
        _form(Pv, e, n) / v_sd**2,
        turn * tau,
        of(fast, n),
        of(slow, n),
    ]
    return np.stack(even, axis=-1), np.stack(odd, axis=-1), e, n


def _memory(
    y: Array, quiet_now: Array, taken: np.ndarray, began: np.ndarray, time: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Two fading sums of innovations (B, S, 2), averages of their squares and of the first mode's probability, and the
    time since the scan before that was taken.
    """
    B, S, _ = y.shape
    fast, slow, out_fast, out_slow = np.zeros((B, 2)), np.zeros((B, 2)), np.zeros_like(y), np.zeros_like(y)
    square, quiet, last = np.ones(B), np.full(B, 0.7), np.zeros(B)
    squares, quiets, dt = np.zeros((B, S)), np.zeros((B, S)), np.zeros((B, S))
    for k in range(S):
        new, good = began[:, k], taken[:, k]
        fast, slow = (np.where(new[:, None], 0.0, m) for m in (fast, slow))
        square, quiet, last = np.where(new, 1.0, square), np.where(new, 0.7, quiet), np.where(new, time[:, k], last)
        dt[:, k] = time[:, k] - last
        fast = np.where(good[:, None], FAST * fast + y[:, k], fast)
        slow = np.where(good[:, None], SLOW * slow + y[:, k], slow)
        nis = np.minimum((y[:, k] ** 2).sum(axis=1) / 2, MOST)
        square = np.where(good, square + AVERAGE * (nis - square), square)
        quiet = np.where(good, quiet + AVERAGE * (quiet_now[:, k] - quiet), quiet)
        last = np.where(good, time[:, k], last)
        out_fast[:, k], out_slow[:, k], squares[:, k], quiets[:, k] = fast, slow, square, quiet
    return np.sqrt(1 - FAST**2) * out_fast, np.sqrt(1 - SLOW**2) * out_slow, squares, quiets, dt
