"""From a filter's state to what people ask for: speed, course, climb, acceleration, turn rate, and sds.

Standard deviations are first-order: var f(x) = ∇f P ∇fᵀ. Where the state has no acceleration or no turn rate,
they follow from kinematics: a = ω × v, and ω = (v × a) / |v|².
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from ..estimate import STATUS, Status
from ..io.geodesy import DevelopedFrame, SiteFrame
from ..io.kept import unmarked
from ..io.stages import stage
from .ground import lift
from .manoeuvring import Told
from .placing import Placed
from .state import State
from .unknown_height import VARIANCE, along_the_line
from .unseen_heights import CLIMB, HEIGHT

STATUSES = pl.Series(STATUS, dtype=pl.Enum(STATUS))
SLOW = 1e-6  # m/s: below this speed a course means nothing
NIS_BAND = {
    1: (0.000982, 5.0239),
    2: (0.0506, 7.3778),
    3: (0.2158, 9.3484),
    4: (0.4844, 11.1433),
    5: (0.8312, 12.8325),
    6: (1.2373, 14.4494),
}  # central 95 % of χ²


@stage("table")
def tracks_table(
    placed: Placed,
    estimate: Any,
    absolute: bool,
    manoeuvres: Told,
    ground: float | np.ndarray = math.nan,
    state: State | None = None,
) -> pl.DataFrame:
    """One row per row of `placed`: the columns that `jink.track` documents, nulls where nothing is known.

    manoeuvres: what is said of them (:mod:`.manoeuvring`). ground (m): no height is below it; NaN: it is not known.
    state: that of the estimate, which is changed; None: it is read from it.
    """
    state = state or State(estimate)
    lift(placed, ground, state)
    _widen(placed, state)
    columns, sds = _kinematics(state)
    _unknown_velocity(state, np.asarray(estimate.status), columns, sds)
    place, convergence = _position(placed, state)
    columns["course"] = np.mod(columns["course"] + convergence, 2.0 * np.pi)
    head: dict[str, Any] = {
        "target": placed.rows["target"],
        "part": placed.rows["part"],
        "time": placed.rows["time"],
    }
    numbers = {**place, **columns, **sds}
    numbers |= {f"probability_{name}": estimate.mode_probability[:, i] for i, name in enumerate(estimate.modes)}
    numbers["manoeuvring"] = manoeuvres.horizontal
    if manoeuvres.vertical is not None:
        numbers["manoeuvring_vertical"] = manoeuvres.vertical
    numbers |= {"measured_x": placed.plane[:, 0], "measured_y": placed.plane[:, 1], "nis": estimate.nis}
    status = {"status": np.asarray(estimate.status)}
    if placed.axes == 3:
        numbers["measured_z"] = placed.height
        # what was not measured is predicted, whatever else was
        status["altitude_status"] = np.where(np.isnan(placed.height), Status.predicted, status["status"])
    table = pl.DataFrame(
        {
            **head,
            **numbers,
            **{name: STATUSES.gather(each) for name, each in status.items()},
            "nis_dof": np.asarray(estimate.nis_dof).astype(np.uint8),
            "segment": _segments(manoeuvres.segment, placed.rows.height),
            "file": placed.rows["file"],
            "row": placed.rows["row"],
        }
    )
    # few columns have a NaN, which is their least value then
    unknown = [name for name, values in numbers.items() if np.isnan(values.min(initial=0.0))]
    table = table.with_columns(pl.col(unknown).fill_nan(None))
    if absolute:
        table = table.with_columns((pl.col("time") * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us", "UTC")))
    if "on_ground" in placed.rows.columns:
        table = table.with_columns(on_ground=placed.rows["on_ground"])
    return table.select(_ordered(table.columns)).with_columns(**unmarked(placed.rows, table.columns))


def _segments(numbers: np.ndarray | None, rows: int) -> pl.Series:
    return pl.repeat(None, rows, dtype=pl.Int32, eager=True) if numbers is None else pl.Series(numbers, dtype=pl.Int32)


def _widen(placed: Placed, state: State) -> None:
    """Give positions what they keep of errors that last, and what unknown heights do to them."""
    rows = placed.rows
    if "lasting" in rows.columns:
        for name in ("px", "py"):
            state.widen(name, name, rows["lasting"].to_numpy())
    if HEIGHT in rows.columns:
        state.widen("pz", "pz", rows[HEIGHT].to_numpy())
        state.widen("vz", "vz", rows[CLIMB].to_numpy())
    if VARIANCE in rows.columns:
        xx, yy, xy = along_the_line(placed, state["px"], state["py"])
        for first, second, more in (("px", "px", xx), ("py", "py", yy), ("px", "py", xy)):
            state.widen(first, second, more)


def _ordered(names: list[str]) -> list[str]:
    """Columns in the documented order: quantities, modes, manoeuvre, and where a row came from at the end."""
    late = [
        "altitude_status",
        "manoeuvring",
        "manoeuvring_vertical",
        "segment",
        "status",
        "on_ground",
        "measured_x",
        "measured_y",
        "measured_z",
        "nis",
        "nis_dof",
        "file",
        "row",
    ]
    return [name for name in names if name not in late] + [name for name in late if name in names]


def _kinematics(state: State) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Every quantity and its sd; the course still counts from the frame's north."""
    columns: dict[str, np.ndarray] = {}
    sds: dict[str, np.ndarray] = {}
    for letter, name in (("p", ""), ("v", "velocity_"), ("a", "acceleration_")):
        for axis in "xyz":
            if letter + axis in state:
                columns[name + axis], sds[f"{name}{axis}_sd"] = state[letter + axis], state.sd(letter + axis)
    vx, vy = state["vx"], state["vy"]
    speed = np.hypot(vx, vy)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(speed > SLOW, 1.0 / speed, np.nan)
    columns["speed"], columns["course"] = speed, np.where(speed > SLOW, np.arctan2(vx, vy), np.nan)
    sds["speed_sd"] = state.sd_of({"vx": vx * inverse, "vy": vy * inverse})
    sds["course_sd"] = np.minimum(state.sd_of({"vx": vy * inverse**2, "vy": -vx * inverse**2}), np.pi)
    if "vz" in state:
        columns["climb_rate"], sds["climb_rate_sd"] = state["vz"], state.sd("vz")
    if "turn_rate" in state:
        rate = columns["turn_rate"] = state["turn_rate"]
        sds["turn_rate_sd"] = state.sd("turn_rate")
        if "ax" not in state:
            columns["acceleration_x"], columns["acceleration_y"] = -rate * vy, rate * vx
            sds["acceleration_x_sd"] = state.sd_of({"turn_rate": -vy, "vy": -rate})
            sds["acceleration_y_sd"] = state.sd_of({"turn_rate": vx, "vx": rate})
    elif "ax" in state:
        ax, ay, square = state["ax"], state["ay"], inverse**2
        rate = columns["turn_rate"] = (vx * ay - vy * ax) * square
        gradient = {
            "vx": (ay - 2.0 * rate * vx) * square,
            "vy": (-ax - 2.0 * rate * vy) * square,
            "ax": -vy * square,
            "ay": vx * square,
        }
        sds["turn_rate_sd"] = state.sd_of(gradient)
    if "turn_rate" in columns:  # what hardly moves has no direction, and none that turns
        still = ~(speed > 2.0 * sds["speed_sd"])
        columns["turn_rate"] = np.where(still, np.nan, columns["turn_rate"])
        sds["turn_rate_sd"] = np.where(still, np.nan, sds["turn_rate_sd"])
    return columns, sds


def _unknown_velocity(
    state: State, status: np.ndarray, columns: dict[str, np.ndarray], sds: dict[str, np.ndarray]
) -> None:
    """A track that has begun from one position says nothing of its velocity: it is null, not zero."""
    unknown = (state["vx"] == 0.0) & (state["vy"] == 0.0) & (status != Status.updated)
    if unknown.any():
        for name in ("velocity_x", "velocity_y", "velocity_z", "speed", "climb_rate"):
            if name in columns:
                columns[name] = np.where(unknown, np.nan, columns[name])
        sds["course_sd"] = np.where(unknown, np.nan, sds["course_sd"])


def _position(placed: Placed, state: State) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Latitude, longitude, altitude as far as there is a map, and the convergence of its meridians."""
    x, y = state["px"], state["py"]
    z = state["pz"] if "pz" in state.index else None
    frame = placed.frame
    if isinstance(frame, DevelopedFrame):
        latitude, longitude, convergence = frame.to_geographic(x, y)
        place = {"latitude": latitude, "longitude": longitude}
        return (place | {"altitude": z} if z is not None else place), convergence
    if isinstance(frame, SiteFrame):
        latitude, longitude, convergence, altitude = frame.to_geographic(x, y, z)
        place = {"latitude": latitude, "longitude": longitude}
        return (place | {"altitude": altitude} if altitude is not None else place), convergence
    return {}, np.zeros(x.size)


@dataclass
class NisCounts:
    """How many rows were updated, how many of them have a NIS inside the central 95 % of χ², and the sum of NIS per
    dimension.
    """

    rows: int = 0
    inside: int = 0
    total: float = 0.0

    def add(self, table: pl.DataFrame) -> None:
        """The updated rows of one more table of tracks."""
        known = (table["status"] == "updated") & table["nis"].is_not_null() & (table["nis_dof"] > 0)
        if not known.any():
            return
        nis, dof = table["nis"].filter(known).to_numpy(), table["nis_dof"].filter(known).to_numpy()
        low = np.array([NIS_BAND.get(k, (0.0, np.inf))[0] for k in range(int(dof.max()) + 1)])[dof]
        high = np.array([NIS_BAND.get(k, (0.0, np.inf))[1] for k in range(int(dof.max()) + 1)])[dof]
        self.rows += nis.size
        self.inside += int(((nis >= low) & (nis <= high)).sum())
        self.total += float((nis / dof).sum())

    def shares(self) -> dict[str, float]:
        """Share inside, and mean per dimension; nothing where no row was updated."""
        if not self.rows:
            return {}
        return {"inside_95": self.inside / self.rows, "mean_per_dimension": self.total / self.rows}


def nis_share(table: pl.DataFrame) -> dict[str, float]:
    """Share of the NIS of updated rows inside the central 95 % of χ², and their mean per dimension."""
    counts = NisCounts()
    counts.add(table)
    return counts.shares()
