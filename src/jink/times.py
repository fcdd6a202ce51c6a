"""Times: float seconds inside, dates at the boundary."""

from collections.abc import Mapping
from datetime import UTC, datetime

import numpy as np
from numpy.typing import ArrayLike, NDArray

Time = float | str | datetime | np.datetime64  # of one row


def seconds(time: ArrayLike | datetime) -> NDArray[np.float64] | float:
    """Seconds of a time or an array of times; dates count from 1970-01-01 UTC.

    Errors: TypeError for what is neither a number nor a date.
    """
    if isinstance(time, datetime):
        return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()
    try:
        array = np.asarray(time)
    except ValueError:
        raise TypeError("time: expected seconds or dates, got rows of different lengths") from None
    if array.dtype == object and array.size and isinstance(array.flat[0], datetime):
        return np.array([seconds(t) for t in array.ravel()], dtype=float).reshape(array.shape)
    if array.dtype.kind == "M":
        ns = array.astype("datetime64[ns]")
        value = np.where(np.isnat(ns), np.nan, ns.astype(np.int64) * 1e-9)
        return value if array.ndim else float(value)
    try:
        value = np.asarray(array, dtype=float)
    except (TypeError, ValueError, OverflowError):
        such = f" such as {array.flat[0]!r}" if array.size else ""
        raise TypeError(f"time: expected seconds or dates, got {array.dtype}{such[:60]}") from None
    return value if array.ndim else float(value)


def moment(time: ArrayLike | datetime) -> float:
    """Seconds of one time. Errors: TypeError for several, ValueError for one that is not finite."""
    value = seconds(time)
    if np.ndim(value):
        raise TypeError(f"time: expected one time, got an array of shape {np.shape(value)}")
    if not np.isfinite(value):
        raise ValueError(f"time: expected a time, got {time!r}")
    return float(value)


def duration(given: object, units: Mapping[str, float]) -> float:
    """Seconds of a number or of text such as "500ms", by unit; NaN for what is no time above 0."""
    text = str(given)
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    try:
        value = float(digits) * units[text[len(digits) :] or "s"]
    except (ValueError, KeyError):
        return np.nan
    return value if 0.0 < value < np.inf else np.nan
