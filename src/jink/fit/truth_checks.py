"""Is the truth in a file's further columns that of its targets, in the same coordinates and units?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..checks import Array
from ..compare.recorded import Recording
from ..io.errors import InputError

MISPLACED = 10.0  # times the measurement's sd that the truth may lie off, in the median
MOVES = 10.0  # times that sd; on shorter ways nothing is said of velocities
ASTRAY = 0.3  # of the way that the true positions go: so far off may the true velocities lead


def check_truth(truth: Array, components: Sequence[str], recording: Recording) -> None:
    """Errors: InputError where the truth lies nowhere near the measurements, or its velocities lead elsewhere."""
    sensor, z = recording.sensor, recording.tracks.z
    try:
        there = sensor.positions(z)
    except ValueError:
        raise InputError(
            "--truth: expected measured positions to check the truth against; this file has none"
        ) from None
    sd = _position_sds(sensor, z, there)
    for k, name in enumerate(components):
        axis = "xyz".index(name[1])
        if name[0] != "p" or axis >= there.shape[1]:
            continue
        off = np.nanmedian(np.abs(truth[:, k] - there[:, axis]))
        if not off <= MISPLACED * sd[axis]:
            raise InputError(
                f"--truth: the median distance of {name} from the measured position is {off:.3g} m; "
                f"the measurements' sd is {sd[axis]:.3g} m. "
                "Check that the truth is of these targets and in the same coordinates"
            )
    _check_velocities(truth, list(components), recording, sd)


def _check_velocities(truth: Array, names: list[str], recording: Recording, sd: Array) -> None:
    """Errors: InputError where the sum of a true velocity over time is not the way that the true position goes."""
    tracks = recording.tracks
    for axis in "xyz"[: len(sd)]:
        if f"p{axis}" not in names or f"v{axis}" not in names:
            continue
        way, off, rows = 0.0, 0.0, 0
        for first, end in zip(tracks.offsets[:-1], tracks.offsets[1:], strict=True):
            p, v = (truth[first:end, names.index(letter + axis)] for letter in "pv")
            known = np.isfinite(p) & np.isfinite(v)
            if known.sum() < 2:
                continue
            t, p, v = tracks.time[first:end][known], p[known], v[known]
            led = np.r_[0.0, np.cumsum(np.diff(t) * (v[1:] + v[:-1]) / 2)]
            way, off, rows = way + p.size * p.var(), off + p.size * (p - led).var(), rows + p.size
        if rows and way > rows * (MOVES * sd["xyz".index(axis)]) ** 2 and off > ASTRAY**2 * way:
            raise InputError(
                f"--truth: v{axis} leads elsewhere than p{axis}: summed over time it is off by "
                f"{100 * (off / way) ** 0.5:.0f} % of the way. Expected m/s along the same axis; check the unit of "
                "time as well"
            )


def _position_sds(sensor: Any, z: Array, there: Array) -> Array:
    """The usual sd (m) of a measured position along each axis; of a radar by its range and angles."""
    own = np.sqrt(np.diag(sensor.noise))
    if sensor.cartesian:
        return own[: there.shape[1]]
    sds = dict(zip(sensor.components, own, strict=True))
    angle = float(np.hypot(sds["azimuth"], sds.get("elevation", 0.0)))
    far = float(np.nanmedian(np.abs(z[:, sensor.components.index("range")])))
    return np.full(there.shape[1], max(sds["range"], far * angle, sds.get("height", 0.0)))
