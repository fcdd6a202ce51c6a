"""Simulated measurements and truth as one table: what `jink simulate` writes and `jink track` reads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..catalogue.choose import EARTH_RADIUS

if TYPE_CHECKING:
    from . import Simulation
    from .skies import Sky

# how components of z are called in the table, with the factor from SI units
COLUMNS = {
    "x": ("x", 1.0),
    "y": ("y", 1.0),
    "z": ("z", 1.0),
    "vx": ("velocity_x", 1.0),
    "vy": ("velocity_y", 1.0),
    "vz": ("velocity_z", 1.0),
    "range": ("range", 1.0),
    "azimuth": ("azimuth_deg", 180.0 / np.pi),
    "elevation": ("elevation_deg", 180.0 / np.pi),
    "height": ("altitude_m", 1.0),
    "range_rate": ("range_rate", 1.0),
}
QUANTITIES = ("true", "true_velocity", "true_acceleration")


def simulation_table(simulation: Simulation) -> Any:
    """A polars DataFrame with one row per scan.

    target ("run 0"), run, scan (from 1), time (s); the measurement's components (m, degrees, m/s), null where
    missed; site_x, … of a radar that is not at the origin; heights beside a range are altitudes above a curved earth;
    true_x, true_velocity_x, true_acceleration_x, … per axis; input_x, … and input_turn_rate where
    something is commanded.
    """
    import polars as pl

    B, S, _ = simulation.z.shape
    runs = np.repeat(simulation.runs, S)
    columns: dict[str, Any] = {
        "target": pl.Series(simulation.runs, dtype=pl.Int64).cast(pl.String).gather(np.repeat(np.arange(B), S)),
        "run": runs,
        "scan": np.tile(np.arange(1, S + 1, dtype=np.int32), B),
        "time": simulation.time.reshape(-1),
    }
    site = getattr(simulation.scenario.observation.sensor, "site", ())
    for column, name in enumerate(simulation.scenario.observation.components):
        label, factor = COLUMNS[name]
        values = simulation.z[..., column] * factor
        if name == "height":
            values = _above_earth(values, simulation.truth[0], site)
        columns[label] = pl.Series(values.reshape(-1)).fill_nan(None)
    if any(site):
        columns |= {f"site_{axis}": np.full(B * S, float(p)) for p, axis in zip(site, "xyz", strict=False)}
    for quantity, values in zip(QUANTITIES, simulation.truth, strict=True):
        columns |= {f"{quantity}_{axis}": values[..., a].reshape(-1) for a, axis in _axes(values)}
    if simulation.input is not None and simulation.turn_rate is not None:
        columns |= {f"input_{axis}": simulation.input[..., a].reshape(-1) for a, axis in _axes(simulation.input)}
        if np.any(simulation.turn_rate):
            columns["input_turn_rate"] = simulation.turn_rate.reshape(-1)
    return pl.DataFrame(columns)


def sky_tables(sky: Sky, runs: int, seed: int) -> tuple[Any, Any]:
    """Plots: run, time (s), x, y (m), by scan. Truth: run, time, target, x, y, velocity_x, velocity_y.

    Several runs follow each other in time, far enough apart that no track lives on; the column `run` says which.
    """
    import polars as pl

    plots, truth, begin = [], [], 0.0
    for number, run in enumerate(sky.runs(runs, seed)):
        for scan, there, velocity in zip(run.scans, run.truth, run.velocity, strict=True):
            time = begin + scan.time
            plots.append(pl.DataFrame({"run": number, "time": time, "x": scan.z[:, 0], "y": scan.z[:, 1]}))
            x, v = there.points, velocity
            columns = {"x": x[:, 0], "y": x[:, 1], "velocity_x": v[:, 0], "velocity_y": v[:, 1]}
            truth.append(pl.DataFrame({"run": number, "time": time, "target": there.ids, **columns}))
        begin = time + 1000.0 * sky.interval
    return pl.concat(plots), pl.concat(truth)


def _above_earth(height: np.ndarray, position: np.ndarray, site: Sequence[float]) -> np.ndarray:
    """Altitudes of heights over the radar's plane: √((R + h)² + d²) - R at a distance d along the plane, as altimeters
    give them and as `jink track` reads them.
    """
    return np.sqrt((EARTH_RADIUS + height) ** 2 + _squared_distance(position, site)) - EARTH_RADIUS


def above_plane(altitude: np.ndarray, position: np.ndarray, site: Sequence[float]) -> np.ndarray:
    """Heights over the radar's plane of such altitudes: √((R + a)² - d²) - R."""
    return np.sqrt((EARTH_RADIUS + altitude) ** 2 - _squared_distance(position, site)) - EARTH_RADIUS


def _squared_distance(position: np.ndarray, site: Sequence[float]) -> np.ndarray:
    place = np.asarray(site[:2] if any(site) else (0.0, 0.0))
    return ((position[..., :2] - place) ** 2).sum(axis=-1)


def _axes(values: np.ndarray) -> list[tuple[int, str]]:
    return list(enumerate("xyz"[: values.shape[-1]]))
