"""Does the filter that was asked for suit these targets? It foretells the next position better than a straight line
through the last two, and its estimates lie within the noise of what was measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from .finding import NAMED, Finding

ROWS = 100  # foretold positions; of fewer nothing is said
WORSE = 1.1  # times the root mean square error of the straight line
FAR = 1.3  # times the noise of a position
DISTANCES = {0.5: 1.1774, 0.9: 2.1460}  # quantiles of the distance of two normal errors of sd 1
NEEDED = ("x", "y", "velocity_x", "velocity_y", "measured_x", "measured_y")


def foretells_badly(tracks: pl.DataFrame) -> list[Finding]:
    """A finding where filtered tracks are worse than what was measured.

    Both lines go on without a turn: z(k−1) + (z(k−1) − z(k−2)) Δt/Δt′ of the measurements, x(k−1) + v(k−1) Δt of the
    estimates; errors are distances to z(k).
    """
    if any(name not in tracks.columns for name in NEEDED):
        return []
    seen = tracks.filter(pl.col("measured_x").is_not_nan() & (pl.col("status") != "predicted"))
    seconds = pl.col("time").dt.epoch("us") * 1e-6 if tracks["time"].dtype.is_temporal() else pl.col("time")
    same = pl.col("target", "part").eq_missing(pl.col("target", "part").shift(2))
    rows = seen.with_columns(seconds.alias("s")).with_columns(
        step=pl.col("s") - pl.col("s").shift(1), before=pl.col("s").shift(1) - pl.col("s").shift(2)
    )
    rows = rows.select(
        "target",
        inside=pl.all_horizontal(same) & (pl.col("step") > 0) & (pl.col("before") > 0),
        line=_distance("measured", pl.col("step") / pl.col("before")),
        filter=_distance("", pl.col("step")),
    ).filter("inside", pl.col("line").is_finite(), pl.col("filter").is_finite())
    if rows.height < ROWS:
        return []
    line, own = ((rows[name] ** 2).mean() ** 0.5 for name in ("line", "filter"))  # pyright: ignore[reportOptionalOperand, reportOperatorIssue]
    if own <= WORSE * line:
        return []
    names = rows["target"].unique(maintain_order=True)
    return [
        Finding(
            code="foretells_badly",
            what=f"the next position is foretold to {own:.3g} m, to {line:.3g} m by a straight line through the last "
            "two measurements (root mean square)",
            targets=names.head(NAMED).to_list(),
            count=len(names),
            rows=rows.height,
            likely="a filter for other targets or another noise",
            mend="leave out --filter, or fit one to these targets with jink fit",
        )
    ]


def strays(tracks: pl.DataFrame, filter: Any, noise: Sequence[Mapping[str, Any]]) -> list[Finding]:
    """A finding where filtered tracks lie farther from the positions that they have just taken than these err.

    An estimate is a mean of prediction and measurement, so x(k) − z(k) is below the noise. What a learned aid adds is
    not: it may be far too large at another interval or noise than it was trained on. noise: lines of the summary.
    """
    sds = [value for line in noise for value in (line.get("position_sd"), *line.get("position_sd_range", ())) if value]
    if not sds or any(name not in tracks.columns for name in NEEDED):
        return []
    # a name stands for a filter that is made for this noise; an aid holds for no other
    from ..filters.aided import Aided

    sensors = () if isinstance(filter, Aided) else getattr(filter, "sensors", ())
    own = getattr(next(iter(sensors), None), "sd", None)
    sd = max(*sds, float(own) if isinstance(own, int | float) else 0.0)
    # errors of time stamps are errors along the track
    stamps = max(value for line in noise for value in (line.get("time_sd") or 0.0, *line.get("time_sd_range", ())))
    seen = tracks.filter(pl.col("status") == "updated", pl.col("measured_x").is_finite(), pl.col("x").is_finite())
    if seen.height < ROWS:
        return []
    off = np.hypot(*(seen[axis].to_numpy() - seen[f"measured_{axis}"].to_numpy() for axis in "xy"))
    speed = np.hypot(seen["velocity_x"].to_numpy(), seen["velocity_y"].to_numpy())
    far = max(float(np.quantile(off, share)) / distance for share, distance in DISTANCES.items())
    expected = float(np.hypot(sd, stamps * np.median(speed)))
    if far <= FAR * expected:
        return []
    names = seen["target"].unique(maintain_order=True)
    return [
        Finding(
            code="strays",
            what=f"estimates lie {far:.3g} m from the positions that they have just taken, whose noise is "
            f"{expected:.3g} m",
            targets=names.head(NAMED).to_list(),
            count=len(names),
            rows=seen.height,
            likely="a learned aid at another interval or noise than it was trained on, or a filter for other targets",
            mend="leave out --filter, or learn the aid on data like these",
        )
    ]


def _distance(of: str, ahead: pl.Expr) -> pl.Expr:
    """Of the measured position from the line on from the row before; ``ahead``: how many steps, or seconds."""
    total = pl.lit(0.0)
    for axis in "xy":
        last = pl.col(f"{of}_{axis}" if of else axis).shift(1)
        slope = last - pl.col(f"{of}_{axis}").shift(2) if of else pl.col(f"velocity_{axis}").shift(1)
        total = total + (last + slope * ahead - pl.col(f"measured_{axis}")) ** 2
    return total.sqrt()
