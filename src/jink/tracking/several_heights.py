"""How high targets are where a plot of one radar does not say it: what plots before and after say, of any radar."""

from __future__ import annotations

import numpy as np
import polars as pl

TOLD = ("target", "time", "altitude", "variance")  # m, m²


def told_by(tables: list[pl.DataFrame]) -> pl.DataFrame:
    """Altitudes of plots on the map, and their variances, by target and time."""
    some = [table.filter(pl.col("altitude").is_finite()) for table in tables if "altitude" in table.columns]
    if not some:
        return pl.DataFrame(schema=dict(zip(TOLD, (pl.String, pl.Float64, pl.Float64, pl.Float64), strict=True)))
    return pl.concat(table.select(*TOLD[:3], variance=pl.col("altitude_sd") ** 2) for table in some)


def between(rows: pl.DataFrame, told: pl.DataFrame, rate: float, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Altitude of each row's target at its time, and its variance (N,); NaN where no plot of the target tells one.

    It lies on the line from the one before to the one after. Its variance is theirs, and (rate · seconds to the nearer
    one)², an sd of `most` metres at most.
    """
    asked = rows.select("target", "time", number=pl.int_range(rows.height))
    table = pl.concat([told, asked.cast({"target": told.schema["target"]})], how="diagonal").sort("target", "time")
    table = table.with_columns(at=pl.when(pl.col("altitude").is_not_null()).then("time"))
    ends = pl.col("at", "altitude", "variance")
    table = table.select(
        "number",
        "time",
        ends.forward_fill().over("target").name.suffix("_before"),
        ends.backward_fill().over("target").name.suffix("_after"),
    )
    table = table.drop_nulls("number").sort("number")
    time, (t0, h0, v0), (t1, h1, v1) = table["time"].to_numpy(), _end(table, "before"), _end(table, "after")
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(t1 > t0, (time - t0) / (t1 - t0), 0.0)
    altitude = np.where(np.isnan(h0), h1, np.where(np.isnan(h1), h0, h0 + share * (h1 - h0)))
    apart = np.fmin(time - t0, t1 - time)
    return altitude, np.fmax(v0, v1) + np.fmin(rate * apart, most) ** 2


def _end(table: pl.DataFrame, name: str) -> list[np.ndarray]:
    """Time, altitude and variance of the plot before or after, NaN where there is none."""
    return [table[f"{column}_{name}"].cast(pl.Float64).to_numpy() for column in ("at", "altitude", "variance")]
