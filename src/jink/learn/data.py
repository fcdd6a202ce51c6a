"""Training data: measured runs with their truth, from a scenario or a file, split by run."""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from typing import Any

import numpy as np

from ..checks import Array, positive
from ..frozen import frozen
from ..models.tracks import Tracks
from ..scenarios import Scenario, by_name

SPLIT = (0.6, 0.2)  # shares for training and validation; the rest is for the test


@frozen(kw_only=True, eq=False)
class Runs:
    """Measured positions with their truth: run b, scan k, axis a.

    time (B, S) s; z, position, velocity, acceleration (B, S, axes) in SI units, NaN where missed or unknown; sd (m) of
    the measurement; name says where they come from, numbers (B,) which runs of it they are; family (B,) from 0, which
    runs are of one kind, those of one scenario.
    """

    time: Array
    z: Array
    position: Array
    velocity: Array
    acceleration: Array
    sd: float
    name: str
    numbers: np.ndarray
    family: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    @property
    def axes(self) -> int:
        """Of the measurements."""
        return self.z.shape[2]

    def batch(self) -> dict[str, Any]:
        """time, z and offsets for ``filter(**runs.batch())``: all runs laid end to end."""
        B, S, m = self.z.shape
        return {"time": self.time.reshape(-1), "z": self.z.reshape(-1, m), "offsets": np.arange(B + 1) * S}

    def take(self, which: np.ndarray | slice | list[int]) -> Runs:
        """Some of the runs, by their places."""
        return replace(self, **{name: getattr(self, name)[which] for name in ("time", "z", *TRUTHS, *OF_RUNS)})

    def along(self, axes: list[int]) -> Runs:
        """Some of the axes."""
        return replace(self, **{name: getattr(self, name)[..., axes] for name in ("z", *TRUTHS)})

    def axes_apart(self) -> Runs:
        """Every axis as a run of its own, axis by axis: (axes · B, S, 1)."""
        wide = {name: getattr(self, name) for name in ("z", *TRUTHS)}
        apart = {name: np.concatenate([*np.moveaxis(v, 2, 0)])[..., None] for name, v in wide.items()}
        copied = {name: np.tile(getattr(self, name), self.axes) for name in OF_RUNS}
        return replace(self, time=np.tile(self.time, (self.axes, 1)), **copied, **apart)

    def split(self, seed: int = 0, shares: tuple[float, float] = SPLIT) -> tuple[Runs, Runs, Runs]:
        """Training, validation and test runs: whole runs, drawn at random.

        Errors: ValueError where there are fewer than three runs.
        """
        if len(self) < 3:
            raise ValueError(f"runs: expected at least 3 to split, got {len(self)}")
        order = np.random.default_rng(seed).permutation(len(self))
        first = min(max(1, round(shares[0] * len(self))), len(self) - 2)
        second = min(max(first + 1, round(sum(shares) * len(self))), len(self) - 1)
        train, validation, test = (np.sort(part) for part in np.split(order, [first, second]))
        return self.take(train), self.take(validation), self.take(test)

    def __str__(self) -> str:
        return f"{self.name}, {len(self)} runs of {self.time.shape[1]} scans"


TRUTHS = ("position", "velocity", "acceleration")
OF_RUNS = ("numbers", "family")


def from_scenario(
    scenario: str | Scenario,
    runs: int | list[int] | np.ndarray,
    seed: int,
    *,
    sensor: Any = None,
    interval: float | None = None,
) -> Runs:
    """Runs of a scenario seen by a position sensor (its own, or another noise in m).

    Errors: ValueError for an unknown scenario or one that is not seen by a position sensor of one sd.
    """
    found = by_name(scenario) if isinstance(scenario, str) else scenario
    if sensor is not None or interval is not None:
        found = found.seen_by(found.observation if sensor is None else sensor, interval=interval)
    sd = getattr(found.observation.sensor, "sd", None)
    if not isinstance(sd, int | float):
        raise ValueError(
            f"{found.name}: expected a position sensor of one sd, got {type(found.observation.sensor).__name__}; "
            "set sensor to a noise in metres"
        )
    s = found.simulate(runs, seed)
    return Runs(
        time=s.time,
        z=s.z,
        position=s.truth.position,
        velocity=s.truth.velocity,
        acceleration=s.truth.acceleration,
        sd=float(sd),
        name=f"{found.name}, {sd:g} m, seed {seed}",
        numbers=s.runs,
        family=np.zeros(len(s.runs), dtype=int),
    )


def from_tracks(tracks: Tracks, sd: float, name: str) -> Runs:
    """Tracks laid end to end, with their truth, as runs of equally many scans: the shorter stand still at their last
    time, unseen.

    sd (m) of the measured positions. Errors: ValueError without a truth of positions.
    """
    if tracks.truth is None or "px" not in tracks.components:
        raise ValueError("tracks: expected tracks with a true position; these have none")
    lengths = np.diff(tracks.offsets)
    axes = "xyz"[: tracks.z.shape[1]]
    rows = np.arange(int(lengths.max()))
    there = rows < lengths[:, None]
    at = tracks.offsets[:-1, None] + np.minimum(rows, lengths[:, None] - 1)

    def stood(letter: str) -> Array:
        out = np.full((*at.shape, len(axes)), np.nan)
        for a, axis in enumerate(axes):
            if letter + axis in tracks.components:
                out[..., a] = tracks.truth[:, tracks.components.index(letter + axis)][at]  # type: ignore[index]
        out[~there] = np.nan
        return out

    return Runs(
        time=tracks.time[at],
        z=np.where(there[..., None], tracks.z[at], np.nan),
        position=stood("p"),
        velocity=stood("v"),
        acceleration=stood("a"),
        sd=positive("sd", sd),
        name=name,
        numbers=np.arange(len(tracks)),
        family=np.zeros(len(tracks), dtype=int) if tracks.family is None else tracks.family,
    )


def from_file(path: str | os.PathLike[str], sd: float) -> Runs:
    """Runs of a table as ``jink simulate`` writes it: target, time, x (y, z), true_x, true_velocity_x, …

    sd (m) is that of the measured positions, which the file does not say; accelerations may be missing. Errors:
    ValueError naming the column that is.
    """
    import polars as pl

    text = os.fspath(path)
    table = pl.read_parquet(text) if text.endswith(".parquet") else pl.read_csv(text)
    axes = [axis for axis in "xyz" if axis in table.columns]
    needed = ["target", "time", *axes, *(f"true_{a}" for a in axes), *(f"true_velocity_{a}" for a in axes)]
    missing = [name for name in needed if name not in table.columns]
    if not axes or missing:
        raise ValueError(
            f"{text}: column {(missing or ['x'])[0]!r} is missing; expected measurements with their truth, "
            "as jink simulate writes them"
        )
    parts = table.partition_by("target", maintain_order=True)
    rows = pl.concat(parts)

    def numbers(names: list[str]) -> Array:
        return np.column_stack([rows[n].cast(pl.Float64).fill_null(np.nan).to_numpy() for n in names])

    truth = {q[0] + a: f"true{'' if q == 'position' else f'_{q}'}_{a}" for q in TRUTHS for a in axes}
    truth = {component: name for component, name in truth.items() if name in rows.columns}
    tracks = Tracks(
        numbers(["time"])[:, 0],
        numbers(axes),
        np.r_[0, np.cumsum([part.height for part in parts])],
        truth=numbers([*truth.values()]),
        components=tuple(truth),
    )
    return from_tracks(tracks, sd, text)


def fingerprint(runs: Runs) -> str:
    """A few letters that differ where times, measurements or truth do."""
    digest = hashlib.sha256()
    for name in ("time", "z", *TRUTHS):
        digest.update(np.ascontiguousarray(getattr(runs, name)).tobytes())
    return f"data {digest.hexdigest()[:12]}"


def joined(parts: list[Runs]) -> Runs:
    """Runs of several sources as one; the shorter are filled up with scans without measurement or truth.

    Errors: ValueError for other axes or another sd.
    """
    if len({(part.axes, part.sd) for part in parts}) != 1:
        raise ValueError("parts: expected the same axes and the same sd in all parts; they differ")
    scans = max(part.time.shape[1] for part in parts)

    def filled(part: Runs, name: str) -> Array:
        array = getattr(part, name)
        more = [(0, 0), (0, scans - array.shape[1])] + [(0, 0)] * (array.ndim - 2)
        return np.pad(array, more, mode="edge") if name == "time" else np.pad(array, more, constant_values=np.nan)

    arrays = {name: np.concatenate([filled(p, name) for p in parts]) for name in ("time", "z", *TRUTHS)}
    numbers = np.concatenate([part.numbers for part in parts])
    before = np.cumsum([0, *(part.family.max(initial=-1) + 1 for part in parts)])
    family = np.concatenate([part.family + k for part, k in zip(parts, before, strict=False)])
    return Runs(sd=parts[0].sd, name="; ".join(p.name for p in parts), numbers=numbers, family=family, **arrays)
