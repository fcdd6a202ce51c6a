"""The filter that is told every manoeuvre: what no filter can beat where the motion is linear."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, by_hints
from ..estimate import Estimate
from ..filters.kalman import Kalman
from ..models.motion import ConstantVelocity
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import TwoPoint


@by_hints
def clairvoyant(
    time: ArrayLike,
    z: ArrayLike,
    *,
    sensor: Sensor,
    acceleration_sd: float,
    input: ArrayLike | None = None,
    displacement: ArrayLike | None = None,
    velocity_sd: float = 1e5,
    outliers: Outliers | None = None,
) -> Estimate:
    """The Kalman filter that is told the manoeuvre: x⁻ = F x + G u, constant velocity.

    time (runs, scans), z (runs, scans, m), acceleration_sd (m/s²) of the process noise, above 0. What is known is
    input u (runs, scans, axes): acceleration (m/s²) since the scan before, constant meanwhile; or displacement
    (runs, scans, axes, 2): what the manoeuvre added since then to position (m) and velocity (m/s), exact for any
    motion, for Position sensors. outliers as for any filter. Returns x (runs · scans, 2 axes) and the rest of an
    estimate. Errors: ValueError for a displacement beside an input or with another sensor.
    Source: the Kalman filter with known input, Bar-Shalom, Li & Kirubarajan 2001, §5.2.
    """
    z = np.asarray(z, dtype=float)
    runs, scans, columns = z.shape
    times = np.broadcast_to(np.asarray(time, dtype=float), (runs, scans))
    kalman = Kalman(
        ConstantVelocity(acceleration_sd=acceleration_sd),
        sensor,
        initial=TwoPoint(velocity_sd=velocity_sd),
        outliers=outliers,
    )
    known = None if displacement is None else _known_path(np.asarray(displacement, dtype=float), times)
    if known is not None and not (sensor.position_only and input is None):
        raise ValueError("displacement: expected a Position sensor and no input together with it")
    seen = z if known is None else z - known[..., 0]
    estimate = kalman.filter(
        times.reshape(-1),
        seen.reshape(-1, columns),
        offsets=np.arange(runs + 1) * scans,
        input=None if input is None else np.asarray(input, dtype=float).reshape(runs * scans, -1),
    )
    if known is not None:
        estimate.results["x"] = estimate.x + known.reshape(runs * scans, -1)
    return estimate


def _known_path(displacement: Array, time: Array) -> Array:
    """Position and velocity (runs, scans, axes, 2) from the known displacements alone, from rest at zero."""
    path = np.zeros_like(displacement)
    for k in range(1, path.shape[1]):
        T = (time[:, k] - time[:, k - 1])[:, None]
        path[:, k, :, 0] = path[:, k - 1, :, 0] + T * path[:, k - 1, :, 1] + displacement[:, k, :, 0]
        path[:, k, :, 1] = path[:, k - 1, :, 1] + displacement[:, k, :, 1]
    return path
