"""Whether the positions under one name are those of several targets."""

from __future__ import annotations

import numpy as np
import polars as pl

from ..catalogue.targets import Kind

MOST = 4  # targets that one name is divided into
EXPLAINED = 0.95  # share of the rows that these must hold
ROWS = 400  # rows of a name that are looked at
FACTOR = 1.5  # times the kind's speed: what a target can do
NOISE = 20.0  # times the usual distance to the nearest of the last few rows, which noise may add


def several_targets(tracks: pl.DataFrame, name: str, kind: Kind) -> int:
    """How many targets explain the positions under a name, 1 where one does or no few do.

    Each row goes to the nearest of the targets so far that can have reached it at the kind's speed, else to a new one.
    """
    rows = tracks.filter((pl.col("target") == name) & pl.col("measured_x").is_not_null()).head(ROWS)
    if "x" not in rows.columns or rows.height < 4:
        return 1
    time = rows["time"]
    seconds = time.dt.epoch("ms").to_numpy() / 1e3 if isinstance(time.dtype, pl.Datetime) else time.to_numpy()
    place = rows.select("measured_x", "measured_y").to_numpy()
    noise = NOISE * _usual_distance(place)
    heads: list[int] = []
    counts: list[int] = []
    for k in range(len(place)):
        far = [float(np.linalg.norm(place[k] - place[h])) for h in heads]
        reach = [noise + FACTOR * kind.speed * float(seconds[k] - seconds[h]) for h in heads]
        near = [i for i in range(len(heads)) if far[i] <= reach[i]]
        if near:
            best = min(near, key=lambda i: far[i])
            heads[best], counts[best] = k, counts[best] + 1
        elif len(heads) < MOST:
            heads.append(k)
            counts.append(1)
    large = [count for count in counts if count >= max(3, 0.1 * len(place))]
    return len(large) if len(large) > 1 and sum(large) >= EXPLAINED * len(place) else 1


def _usual_distance(place: np.ndarray) -> float:
    """The median distance of a row to the nearest of the `MOST` rows before it."""
    back = [np.linalg.norm(place[MOST:] - place[MOST - j : -j], axis=1) for j in range(1, MOST + 1)]
    return float(np.median(np.min(back, axis=0))) if len(place) > MOST else 0.0
