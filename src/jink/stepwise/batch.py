"""Whole tracks through a stepwise filter: scan by scan over all tracks that are long enough."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .functions import Array, at_scan
from .scan import Scan
from .smoothing import backward
from .states import Outcome, Record, States

SLOTS = ("x", "P", "mode_probability", "log_likelihood", "log_likelihood_scan", "nis", "nis_dof", "pit")


def run(
    engine: Scan,
    time: Array,
    z: Array,
    columns: int,
    offsets: Array,
    sensor: Array | None,
    noise: Array | None,
    full_noise: bool,
    input: Array | None,
    prior_x: Array | None,
    prior_P: Array | None,
    slots: list[Array | None],
    status: Array | None,
    covariances: list[tuple[int, int, Array]],
    smooth: bool,
    until: NDArray[np.int64] | None,
    threads: int,
) -> None:
    """As the engine's run; results go into the slots, one thread."""
    _check(time, z, offsets)
    if prior_x is None:
        engine.check_start()
    to: dict[str, Any] = {name: slot for name, slot in zip(SLOTS, slots, strict=True) if slot is not None}
    to |= {"covariances": covariances} if covariances else {}
    engine.with_pit = "pit" in to
    which = sensor if sensor is not None else np.zeros(len(time), dtype=np.int32)
    order, first, active = _by_length(offsets)
    s = engine.new(len(order))
    if prior_x is not None and prior_P is not None:
        some = np.arange(active[0] if len(active) else 0)
        engine.start.from_prior(
            s, some, prior_x[order[some]], prior_P[order[some]], time[first[some]], engine.components
        )
    records: list[Record] = []
    total = np.zeros(len(order))
    for k, count in enumerate(active):
        rows = first[:count] + k
        part = s.take(slice(0, count))
        before = part.time.copy()
        R, u = (None if a is None else a[rows] for a in (noise, input))
        with at_scan(k):
            out = engine.step(part, time[rows], z[rows], which[rows], R, u)
        s.put(slice(0, count), part)
        total[:count] += out.log_likelihood
        _scatter(to, status, rows, part, out)
        if smooth:
            records.append(engine.record(part, before, out, z[rows], which[rows], R, u))
        else:
            estimate(engine, to, rows, part.x, part.P, part.probability, part.started)
    if "log_likelihood" in to:
        to["log_likelihood"][order] = total
    if until is not None:
        lag = _scans(until, offsets)
        for k in range(len(records)):
            *_, (_, x, P, probability) = backward(engine, records[k : k + lag + 1])
            estimate(engine, to, first[: active[k]] + k, x, P, probability, records[k].started)
        return
    for k, x, P, probability in backward(engine, records):
        estimate(engine, to, first[: active[k]] + k, x, P, probability, records[k].started)


def _scans(until: NDArray[np.int64], offsets: Array) -> int:
    """The lag in scans, the same for every row that is not at the end of its track."""
    last = np.repeat(offsets[1:] - 1, np.diff(offsets))
    ahead = (until - np.arange(len(until)))[until < last]
    if len(set(ahead.tolist())) > 1:
        raise ValueError("lag_seconds: models of your own are smoothed with a lag in scans; expected lag=")
    return int(ahead[0]) if len(ahead) else int(np.diff(offsets).max(initial=0))


def _check(time: Array, z: Array, offsets: Array) -> None:
    """Times must not go back within a track, and infinite measurements mean nothing."""
    late = np.zeros(len(time), dtype=bool)
    late[1:] = np.diff(time) < 0
    late[offsets[:-1][offsets[:-1] < len(time)]] = False
    wrong = np.flatnonzero(late | ~np.isfinite(time))
    if len(wrong):
        row = int(wrong[0])
        track = int(np.searchsorted(offsets, row, side="right")) - 1
        why = "lies before the row before it; rows of a track must be in the order of time"
        raise ValueError(f"time: row {row} of track {track} {why if np.isfinite(time[row]) else 'is not a time'}")
    infinite = np.flatnonzero(np.isinf(z).any(axis=1))
    if len(infinite):
        raise ValueError(f"z: row {infinite[0]} is infinite; a missing component is NaN or None")


def _by_length(offsets: Array) -> tuple[Array, Array, Array]:
    """Tracks from the longest to the shortest, their first rows, and how many have a k-th row."""
    lengths = np.diff(offsets)
    order = np.argsort(-lengths, kind="stable")
    longest = int(lengths.max(initial=0))
    shorter = np.searchsorted(np.sort(lengths), np.arange(longest), side="right")
    return order, offsets[:-1][order], len(lengths) - shorter


def _scatter(to: dict[str, Array], status: Array | None, rows: Array, s: States, out: Outcome) -> None:
    values = {
        "log_likelihood_scan": out.log_likelihood,
        "nis": np.where(out.scored, out.nis, np.nan),
        "nis_dof": np.where(out.scored, out.dof, 0.0),
        "pit": np.where(out.scored[:, None], out.pit, np.nan),
    }
    for name, value in values.items():
        if name in to:
            to[name][rows] = value
    if status is not None:
        status[rows] = out.status(s.started)


def estimate(
    engine: Scan,
    to: dict[str, Any],
    rows: Any,
    x: list[Array],
    P: list[Array],
    probability: Array,
    started: Array,
) -> None:
    """Write the estimates that are asked for; NaN where a track has not started."""
    if to.keys() & {"x", "P", "covariances"}:
        mean, C = engine.combine(x, P, probability)
        if "x" in to:
            to["x"][rows] = np.where(started[:, None], mean, np.nan)
        if "P" in to:
            to["P"][rows] = np.where(started[:, None, None], C, np.nan)
        for i, j, out in to.get("covariances", ()):
            out[rows] = np.where(started, C[:, i, j], np.nan)
    if "mode_probability" in to:
        to["mode_probability"][rows] = np.where(started[:, None], probability, np.nan)
