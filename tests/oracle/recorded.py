"""Smoothing of what a filter of many tracks left behind: each mode's estimates, and the noise and known input of its
steps.

A smoother takes both as they were in the filter: given these the modes are linear, however the numbers were found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oracle import sensor as osn
from oracle.chain import PerScan
from oracle.many import Estimates
from oracle.mixture import Mode
from oracle.motion import Motion
from oracle.smoother import smooth
from oracle.start import OnePoint
from oracle.tracker import PREDICTED, Filter, Row, Scan, estimate

Array = NDArray[np.float64]


def smoothed(motions: list[Motion], time: Array, z: Array, R: Array, Pi: Array, filtered: Estimates) -> Estimates:
    """The smoother of one mode or several (oracle.smoother), track by track; R (axes, axes), Pi (M, M) per scan."""
    sensor = osn.Position(z.shape[2], sd=1.0)
    f = Filter(motions, [sensor], PerScan(Pi, len(motions)), OnePoint(1.0))
    out = Estimates(*(np.full_like(a, np.nan) for a in (filtered.x, filtered.P, filtered.mu)))
    for b in range(len(z)):
        scans = [scan_of(f, filtered, k, b, time, Row(float(time[k]), z[b, k], R, sensor)) for k in range(len(time))]
        got = smooth(f, estimate(f, scans))
        out.x[b], out.P[b], out.mu[b] = got.x, got.P, got.mode_probability
    return out


def scan_of(f: Filter, filtered: Estimates, k: int, b: int, time: Array, row: Row) -> Scan:
    """Row k of track b; the first has no track yet."""
    dt = float(time[k] - time[k - 1]) if k else 0.0
    modes = filtered.modes[k]
    scan = Scan(dt, None, f.chain.over(dt), PREDICTED, linked=k > 1, used=row if row.present.any() else None)
    scan.modes = [Mode(m.x[b], m.P[b]) for m in modes]
    scan.mu = filtered.mu[b, k]
    if k > 1 and all(hasattr(m, "Q") for m in modes):
        scan.steps = [(m.Q[b], None if m.u is None else m.u[b]) for m in modes]
    return scan
