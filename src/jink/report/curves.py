"""The curves that the page draws against time, each with its standard deviation, in SI units and degrees."""

import numpy as np

from ..frozen import frozen
from .plan import unwrap
from .rows import TrackRows


@frozen
class Curve:
    """One line of a panel: value (N,) and its standard deviation (N,), NaN where unknown."""

    label: str
    value: np.ndarray
    sd: np.ndarray


@frozen
class Panel:
    """One chart: key, title, quantity (chooses the unit in the page) and its curves."""

    key: str
    title: str
    quantity: str
    curves: list[Curve]


def panels(rows: TrackRows) -> list[Panel]:
    """The panels for which the tracks hold at least one number."""
    height = "altitude" if rows.has("altitude") and np.isfinite(rows.column("altitude")).any() else "z"
    found = [
        _panel(rows, "existence", "Existence", "probability"),
        _panel(rows, "speed", "Speed", "speed"),
        _course(rows),
        _panel(rows, height, "Altitude" if height == "altitude" else "Height z", "height", sd="z_sd"),
        _panel(rows, "climb_rate", "Climb rate", "climb"),
        _acceleration(rows),
        _panel(rows, "turn_rate", "Turn rate, left positive", "turn_rate", scale=180.0 / np.pi),
    ]
    return [p for p in found if any(np.isfinite(c.value).any() for c in p.curves)]


def _panel(
    rows: TrackRows, column: str, title: str, quantity: str, *, sd: str | None = None, scale: float = 1.0
) -> Panel:
    curve = Curve("", rows.column(column) * scale, rows.column(sd or f"{column}_sd") * scale)
    return Panel("height" if quantity == "height" else column, title, quantity, [curve])


def _course(rows: TrackRows) -> Panel:
    """Course unwrapped along each part: the page draws it modulo 360 degrees."""
    run = np.zeros(len(rows), dtype=np.int64)
    if len(rows) > 1:
        run[1:] = np.cumsum((np.diff(rows.target) != 0) | (np.diff(rows.part) != 0))
    degrees = unwrap(np.degrees(rows.column("course")), run, 360.0)
    return Panel("course", "Course", "course", [Curve("", degrees, np.degrees(rows.column("course_sd")))])


def _acceleration(rows: TrackRows) -> Panel:
    """Acceleration along the velocity, a.v / |v|, and across it to the left, v x a / |v|.

    The sds are those of ax and ay turned into these directions, their correlation (not in the table) left
    out.
    """
    vx, vy = rows.column("velocity_x"), rows.column("velocity_y")
    ax, ay = rows.column("acceleration_x"), rows.column("acceleration_y")
    sx, sy = rows.column("acceleration_x_sd"), rows.column("acceleration_y_sd")
    speed = np.hypot(vx, vy)
    with np.errstate(invalid="ignore", divide="ignore"):
        c, s = np.where(speed > 0, vx / speed, np.nan), np.where(speed > 0, vy / speed, np.nan)
    along = Curve("along", ax * c + ay * s, np.hypot(c * sx, s * sy))
    across = Curve("to the left", ay * c - ax * s, np.hypot(s * sx, c * sy))
    return Panel("acceleration", "Acceleration", "acceleration", [along, across])


def horizontal_acceleration(rows: TrackRows) -> tuple[np.ndarray, np.ndarray]:
    """Magnitude |a| (N,) in the plane and an sd for it (N,) (the larger of the two axes)."""
    ax, ay = rows.column("acceleration_x"), rows.column("acceleration_y")
    return np.hypot(ax, ay), np.fmax(rows.column("acceleration_x_sd"), rows.column("acceleration_y_sd"))
