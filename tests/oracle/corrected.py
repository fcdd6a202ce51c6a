"""The correction in the plane, scan by scan in the words of docs/corrector.md.

A scan is what a filter said before and after it: a dictionary of x_before, P_before, x, P of the combined estimate by
the names of its components, mu_before, mu, z (2,), R (2, 2), time, and whether the measurement was taken or a track
began.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, hypot, log, sqrt

import numpy as np

FAST, SLOW, AVERAGE, MOST, FASTEST, LARGEST, BOUND = 0.6, 0.85, 0.04, 10.0, 6.0, 0.7, 3.0


@dataclass
class Memory:
    """Of one track."""

    fast: np.ndarray = field(default_factory=lambda: np.zeros(2))
    slow: np.ndarray = field(default_factory=lambda: np.zeros(2))
    square: float = 1.0
    quiet: float = 0.7
    position: np.ndarray = field(default_factory=lambda: np.zeros(2))  # the correction before
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(2))
    time: float = 0.0
    hit: float = 0.0
    size: float = 0.0
    share: float = 1.0  # g
    kept: np.ndarray | float = 0.0  # by the network: what is mirrored as it is
    kept_across: np.ndarray | float = 0.0  # and what changes sign


def block(names, x, P, letter):
    at = [names.index(letter + axis) for axis in "xy"]
    return x[at], P[np.ix_(at, at)]


def size(M):
    """The root of the mean variance."""
    return sqrt(np.trace(M) / 2)


def corrected(names, c, scans):
    """x and P (lists) of every scan with the correction of c on them."""
    out, m = [], Memory()
    for scan in scans:
        x, P = scan["x"].copy(), scan["P"].copy()
        if scan["began"]:
            m = Memory(time=scan["time"])
        factor = one(names, c, scan, m) if scan["taken"] else 1.0
        if not scan["began"]:
            for k, axis in enumerate("xy"):
                x[names.index("p" + axis)] += m.share * (m.position + (scan["time"] - m.time) * m.velocity)[k]
                x[names.index("v" + axis)] += m.share * m.velocity[k]
            w = np.array([factor if name in ("px", "py", "vx", "vy") else 1.0 for name in names])
            P = w[:, None] * P * w
        out.append((x, P))
    return [x for x, _ in out], [P for _, P in out]


def one(names, c, scan, m):
    """The factor of the sds; the memory goes on, and has what is added to position and velocity."""
    before, P_before = block(names, scan["x_before"], scan["P_before"], "p")
    _, Pp = block(names, scan["x"], scan["P"], "p")
    v, Pv = block(names, scan["x"], scan["P"], "v")
    a, _ = block(names, scan["x"], scan["P"], "a")
    turn = scan["x"][names.index("turn_rate")] if "turn_rate" in names else 0.0
    R, S, nu = scan["R"], P_before + scan["R"], scan["z"] - before
    speed = hypot(*v)
    e = v / speed if speed > 0 else np.array([1.0, 0.0])
    n = np.array([-e[1], e[0]])
    dt = scan["time"] - m.time

    # memory
    y, d = nu / size(S), (m.position + dt * m.velocity) / size(S)
    m.fast, m.slow = FAST * m.fast + y, SLOW * m.slow + y
    m.square += AVERAGE * (min(y @ y / 2, MOST) - m.square)
    m.quiet += AVERAGE * (scan["mu"][0] - m.quiet)
    m.hit, m.size = c.memory * m.hit + y @ d, c.memory * m.size + d @ d
    m.time = scan["time"]

    # inputs
    p_sd, v_sd, z_sd = size(Pp), size(Pv), size(R)
    pull, tau = p_sd / v_sd**2, p_sd / v_sd
    fast, slow = sqrt(1 - FAST**2) * m.fast, sqrt(1 - SLOW**2) * m.slow

    def ln(value):
        return log(max(value, 1e-12))

    u = [
        e @ nu / sqrt(e @ S @ e),
        e @ a * pull,
        *scan["mu"][:-1],
        ln(p_sd / z_sd),
        ln(dt / tau),
        min(ln(speed / v_sd), FASTEST),
        (e @ Pv @ e - n @ Pv @ n) / (2 * v_sd**2),
        e @ fast,
        e @ slow,
        *scan["mu_before"][:-1],
        ln(z_sd),
        ln(dt),
        m.square,
        m.quiet,
    ]
    w = [n @ nu / sqrt(n @ S @ n), n @ a * pull, e @ Pv @ n / v_sd**2, turn * tau, n @ fast, n @ slow]
    raw = np.array([*u, *w])
    low, high = np.array(c.low), np.array(c.high)
    outside = max(0.0, np.max(np.maximum(low - raw, raw - high) / (high - low)))
    f = max(0.0, 1 - outside / c.fade)
    scaled = (np.clip(raw, low, high) - c.centre) / np.array(c.scale)
    u, w = scaled[: len(u)], scaled[len(u) :]

    # answers
    keep = np.array(c.keep)
    u, w = np.r_[u, m.kept + 0 * keep], np.r_[w, m.kept_across + 0 * keep]
    A, B, b = np.array(c.even), np.array(c.odd), np.array(c.bias)
    plus, minus = np.maximum(0, A @ u + b + B @ w), np.maximum(0, A @ u + b - B @ w)
    recall, across = (np.reshape(k, (len(keep), len(b))) for k in (c.recall, c.recall_across))
    recalled = recall @ ((plus + minus) / 2) + np.array(c.recall_bias)
    m.kept = keep * m.kept + (1 - keep) * np.clip(recalled, -BOUND, BOUND)
    m.kept_across = keep * m.kept_across + (1 - keep) * np.clip(across @ ((plus - minus) / 2), -BOUND, BOUND)
    even = np.array(c.along) @ ((plus + minus) / 2) + np.array(c.along_bias)
    odd = np.array(c.across) @ ((plus - minus) / 2)
    g = m.share = min(1.0, max(0.0, (c.trust + m.hit) / (c.trust + m.size)))
    m.position = f * (even[0] * sqrt(e @ Pp @ e) * e + odd[0] * sqrt(n @ Pp @ n) * n)
    m.velocity = f * (even[1] * sqrt(e @ Pv @ e) * e + odd[1] * sqrt(n @ Pv @ n) * n)
    return exp(f * g * min(LARGEST, max(-LARGEST, even[2])))
