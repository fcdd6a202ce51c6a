"""A file that `jink simulate` wrote as the source of a race: its measurements, scored against its truth.

Some runs of the file are set aside for fitting. The file does not say what its sensor's noise is: it is what the
measurements and the truth of the runs set aside show.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from ..checks import Array
from ..io.errors import InputError
from ..io.files import open_table
from ..models.sensor import Polar, Position, PositionVelocity
from ..scenarios import Observation, Scenario, Schedule, Simulation
from ..scenarios.observation import in_words
from ..scenarios.table import COLUMNS, QUANTITIES, above_plane
from ..scenarios.truth import Kinematics
from .source import TRAINING_RUNS, Source

KEYS = ("run", "scan", "time")
NEEDED = (*KEYS, "true_x", "true_velocity_x", "true_acceleration_x")
GROSS = 6.0  # sds from which an error is no noise


def has_truth(path: str) -> bool:
    """Was this file written by `jink simulate`? Errors: InputError where it cannot be read."""
    return set(NEEDED) <= set(open_table(Path(path)).names)


def recorded_truth(path: str, kind: str, runs: int, seed: int) -> Source:
    """The runs of a file, half of them (200 at most) to be fitted on; one alone is not fitted on.

    Errors: InputError for scans or truth that are missing, or measurements that are none.
    """
    columns = _read(path)
    measured = [name for name, (label, _) in COLUMNS.items() if label in columns]
    components = _components(path, measured)
    every = _simulation(path, columns, components, kind)
    numbers = np.random.default_rng(seed).permutation(len(every.runs))
    half = min(len(numbers) // 2, TRAINING_RUNS)
    training = _some(every, np.sort(numbers[:half] if half else numbers))
    scenario = replace(every.scenario, observation=_observation(path, training))
    every, training = replace(every, scenario=scenario), replace(training, scenario=scenario)
    scored = np.sort(numbers[half:])[:runs]

    def chunks(size: int) -> Iterator[Simulation]:
        for first in range(0, len(scored), size):
            yield _some(every, scored[first : first + size])

    return Source(
        scenario=scenario,
        seen=f"{in_words(scenario)}; noise as found in the file",
        runs=len(scored),
        training=training,
        fitted=f"{half} other runs of this file" if half else "",
        chunks=chunks,
    )


def _read(path: str) -> dict[str, Array]:
    """The columns that are needed, in the order of runs and scans."""
    table = open_table(Path(path))
    known = [label for label, _ in COLUMNS.values()]
    known += [f"{quantity}_{axis}" for quantity in (*QUANTITIES, "input") for axis in "xyz"]
    known += ["site_x", "site_y", "site_z", "input_turn_rate"]
    wanted = [name for name in (*KEYS, *known) if name in table.names]
    frame, broken = table.read(wanted)
    if broken.height:
        raise InputError(f"{path}: {broken.height} rows cannot be read; expected a file that jink simulate wrote")
    frame = frame.select(pl.col(wanted).cast(pl.Float64, strict=False)).sort("run", "scan")
    if not frame.height:
        raise InputError(f"{path}: the file has no rows; expected simulated runs")
    truth = [name for name in wanted if name.startswith("true_")]
    for name in (*KEYS, *truth):
        if frame[name].is_null().any():
            raise InputError(f"{path}: column {name} has a missing value or text; expected a number in every row")
    return {name: frame[name].to_numpy() for name in wanted}


def _components(path: str, measured: list[str]) -> list[str]:
    """Names of the measured components, in a sensor's order."""
    if "range" in measured and "azimuth" in measured:
        known = ("range", "azimuth", "elevation", "height", "range_rate")
        return [name for name in known if name in measured]
    places = [name for name in ("x", "y", "z") if name in measured]
    if not places:
        raise InputError(f"{path}: no column holds a measurement; expected x, y, z or range, azimuth_deg")
    speeds = [f"v{name}" for name in places if f"v{name}" in measured]
    return places + (speeds if len(speeds) == len(places) else [])


def _simulation(path: str, columns: dict[str, Array], components: list[str], kind: str) -> Simulation:
    run = columns["run"]
    numbers, counts = np.unique(run, return_counts=True)
    B, S = len(numbers), int(counts[0])
    if (counts != S).any():
        raise InputError(f"{path}: runs have {counts.min()} to {counts.max()} scans; expected the same in all")
    axes = sum(f"true_{axis}" in columns for axis in "xyz")

    def stacked(labels: list[str]) -> Array:
        missing = [label for label in labels if label not in columns]
        if missing:
            raise InputError(f"{path}: expected the columns that jink simulate writes; {', '.join(missing)} missing")
        return np.stack([columns[label].reshape(B, S) for label in labels], axis=-1)

    time = columns["time"].reshape(B, S)
    if S > 1 and not (np.diff(time, axis=1) > 0).all():
        raise InputError(f"{path}: expected times that rise with the scans of a run; in one run they do not")
    z = stacked([COLUMNS[name][0] for name in components]) / [COLUMNS[name][1] for name in components]
    truth = Kinematics(*(stacked([f"{quantity}_{a}" for a in "xyz"[:axes]]) for quantity in QUANTITIES))
    if "height" in components:
        height = components.index("height")
        z[..., height] = above_plane(z[..., height], truth.position, _site(columns))
    known = "input_x" in columns
    turning = columns["input_turn_rate"].reshape(B, S) if "input_turn_rate" in columns else np.zeros((B, S))
    interval = float(np.median(np.diff(time, axis=1))) if S > 1 else 1.0
    return Simulation(
        scenario=Scenario(
            name=path,
            summary=f"{B:,} simulated runs of a file, with their truth",
            truth=_no_more,
            observation=Observation(sensor=_sensor(components, np.ones(len(components)), _site(columns))),
            schedule=Schedule(start=float(time[:, 0].mean()), interval=interval, count=S),
            axes=axes,
            kind=kind,
        ),
        seed=0,
        runs=np.arange(B),
        time=time,
        z=z,
        truth=truth,
        input=stacked([f"input_{a}" for a in "xyz"[:axes]]) if known else None,
        turn_rate=turning if known else None,
    )


def _no_more(draws: Any) -> Any:
    raise InputError("more runs cannot be simulated from a file; expected at most the runs that it holds")


def _some(every: Simulation, rows: np.ndarray) -> Simulation:
    """These runs, numbered by their place."""
    return replace(
        every,
        runs=rows,
        time=every.time[rows],
        z=every.z[rows],
        truth=Kinematics(*(values[rows] for values in every.truth)),
        input=None if every.input is None else every.input[rows],
        turn_rate=None if every.turn_rate is None else every.turn_rate[rows],
    )


def _observation(path: str, training: Simulation) -> Observation:
    """The sensor with the noise that measurements and truth show: sd, misses, and the share of gross errors."""
    observation = training.scenario.observation
    error = training.z - observation.sensor.observe(training.truth)
    for column, name in enumerate(observation.components):
        if name == "azimuth":
            error[..., column] = np.remainder(error[..., column] + np.pi, 2 * np.pi) - np.pi
    error = error.reshape(-1, error.shape[-1])
    error = error[np.isfinite(error).all(axis=1)]
    sd = np.median(np.abs(error), axis=0) / 0.6745 if len(error) else np.zeros(1)
    if not (sd > 0).all():
        raise InputError(f"{path}: the measurements are missing or equal the truth; expected measurements with noise")
    gross = float((np.abs(error) > GROSS * sd).any(axis=1).mean())
    usual = error[(np.abs(error) <= GROSS * sd).all(axis=1)]
    sd = np.sqrt((usual**2).mean(axis=0))
    detection = float(np.isfinite(training.z).all(axis=2).mean())
    return replace(
        observation,
        sensor=_sensor(observation.components, sd, getattr(observation.sensor, "site", ())),
        detection=max(detection, 1e-3),
        outlier_share=gross,
    )


def _site(columns: dict[str, Array]) -> tuple[float, ...]:
    """Where the radar stands: at the origin, unless the file says otherwise."""
    return tuple(float(columns[f"site_{axis}"][0]) if f"site_{axis}" in columns else 0.0 for axis in "xyz")


def _sensor(components: Any, sd: Array, site: Any) -> Any:
    """The sensor of these components with this noise, rounded to four digits."""
    rounded = [float(f"{value:.4g}") for value in sd]
    noise: dict[str, Any] = dict(zip(components, rounded, strict=True))
    if "range" in noise:
        return Polar(site=site, **{f"{name}_sd": value for name, value in noise.items()})
    places = [name for name in noise if len(name) == 1]
    position = [noise[name] for name in places]
    alike = float(f"{np.sqrt(np.mean(np.square(position))):.4g}")
    common: Any = alike if max(position) < 1.1 * min(position) else position
    if len(places) == len(noise):
        return Position(sd=common, axes=len(places))
    velocity = [noise[name] for name in noise if len(name) == 2]
    return PositionVelocity(sd=common, velocity_sd=velocity, axes=len(places))
