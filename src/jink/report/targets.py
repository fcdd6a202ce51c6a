"""One line per target: how long, how lively, how consistent. Computed from every row, not from the drawn."""

import numpy as np

from ..estimate import Status
from .consistency import Consistency
from .curves import horizontal_acceleration
from .rows import TrackRows
from .settled import settled


def target_table(rows: TrackRows, check: Consistency) -> dict[str, np.ndarray]:
    """Columns (T,) of the table of targets; NaN where there is nothing to tell.

    duration (s), rows, manoeuvring, gated and nis_inside (shares), compared (rows behind nis_inside), existence (mean),
    max_speed (m/s), max_turn_rate (deg/s), max_acceleration (m/s^2).
    """
    first = rows.first
    size = np.diff(first)
    start, end = _extreme(rows.time, rows, np.minimum), _extreme(rows.time, rows, np.maximum)
    probability = rows.column("manoeuvring")
    known = np.isfinite(probability)
    acceleration, acceleration_sd = horizontal_acceleration(rows)
    with np.errstate(invalid="ignore", divide="ignore"):
        return {
            "start": start,
            "duration": end - start,
            "rows": size,
            "manoeuvring": _count(known & (probability > 0.5), rows) / _count(known, rows),
            "gated": _count(rows.status == Status.gated, rows) / size,
            "nis_inside": check.inside / check.compared,
            "compared": check.compared,
            "existence": _mean(rows.column("existence"), rows),
            "max_speed": _settled_maximum(rows.column("speed"), rows.column("speed_sd"), rows),
            "max_turn_rate": np.degrees(_settled_maximum(rows.column("turn_rate"), rows.column("turn_rate_sd"), rows)),
            "max_acceleration": _settled_maximum(acceleration, acceleration_sd, rows),
        }


def _count(flags: np.ndarray, rows: TrackRows) -> np.ndarray:
    return np.bincount(rows.target[flags], minlength=len(rows.names))


def _mean(values: np.ndarray, rows: TrackRows) -> np.ndarray:
    known = np.isfinite(values)
    total = np.bincount(rows.target[known], weights=values[known], minlength=len(rows.names))
    return total / _count(known, rows)


def _extreme(values: np.ndarray, rows: TrackRows, ufunc: np.ufunc) -> np.ndarray:
    if len(rows) == 0:
        return np.zeros(0)
    return ufunc.reduceat(values, rows.first[:-1])


def _settled_maximum(values: np.ndarray, sd: np.ndarray, rows: TrackRows) -> np.ndarray:
    """Largest |value| (T,) among rows whose sd has settled (the first ones are mostly guesses)."""
    if len(rows) == 0:
        return np.zeros(0)
    largest = _extreme(np.where(settled(values, sd, rows), np.abs(values), -np.inf), rows, np.maximum)
    return np.where(np.isfinite(largest), largest, np.nan)
