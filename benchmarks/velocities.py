"""What reported speeds and vertical rates buy on real flights, held out.

    python -m benchmarks.velocities [FLIGHTS]     (without FLIGHTS the example flights)

Noise and use of the reports are decided on half of the flights and scored on the other half. Scored are positions that
the filter has not seen: the next one, and those of 10 s without any. `no velocity` sees positions alone.
"""

from __future__ import annotations

import sys
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl

from jink.io.loading import Loaded, Reading, load_files
from jink.tracking.held_out import Used, gain, measured_places, position_scores
from jink.tracking.prepare import Group, Pace, Settings, choose, prepare
from jink.tracking.velocity_use import as_decided

FLIGHTS = Path(__file__).parents[1] / "examples" / "flights.parquet"
EVERY, LONG, SETTLED = 40, 10, 60  # rows between two silences, their length, rows before the first


def half(path: Path, which: int) -> Loaded:
    """The flights whose address falls into one half."""
    loaded = load_files([path], Reading())
    mine = [name for name in loaded.measurements.rows["target"].unique() if zlib.crc32(name.encode()) % 2 == which]
    loaded.measurements.rows = loaded.measurements.rows.filter(pl.col("target").is_in(mine))
    return loaded


def group_of(path: Path, which: int, settings: Settings) -> Group:
    """Flights with a height, ready to be filtered."""
    groups = prepare(half(path, which).measurements, settings).groups
    return max(groups, key=lambda group: group.placed.rows.height)


def with_rates(group: Group, used: Used) -> Group:
    """The same flights with the reports that others have shown to help."""
    placed, level = as_decided(group.placed, group.level, used)
    pace = Pace.of(1.0, Settings())
    return replace(
        group, placed=placed, level=level, filter=choose(placed.components, level.typical, pace, Settings())[1]
    )


def after_silence(group: Group) -> tuple[np.ndarray, np.ndarray]:
    """Errors of predicted positions at the end of 10 s without reports (m): horizontal, vertical."""
    placed = group.placed
    since = np.arange(placed.rows.height) - np.repeat(placed.offsets[:-1], np.diff(placed.offsets))
    silent = (since >= SETTLED) & (since % EVERY < LONG)
    z = np.where(silent[:, None], np.nan, placed.z)
    found = group.filter.filter(
        placed.time, z, offsets=placed.offsets, covariance=group.level.covariance, outputs=("x",)
    )
    last = silent & (since % EVERY == LONG - 1) & np.isfinite(placed.z[:, :3]).all(axis=1)
    error = found.x[last][:, [found.components.index(f"p{axis}") for axis in "xyz"]] - placed.z[last, :3]
    return np.hypot(error[:, 0], error[:, 1]), np.abs(error[:, 2])


def main(path: Path) -> None:
    """Print the table."""
    print(f"{path.name}: noise and use decided on half of the flights, scored on the other half")
    decided = group_of(path, 0, Settings()).rates
    for note in decided.notes:
        print(f"  {note}")
    plain = group_of(path, 1, Settings(velocity=False))
    moving = with_rates(plain, decided)
    scores = {}
    for name, group in (("no velocity", plain), ("velocity", moving)):
        places = measured_places(plain.placed, plain.level.covariance)
        scores[name] = position_scores(group.filter, group.placed, group.level.covariance, places)
        level, up = after_silence(group)
        figures = [f"{np.nanmean(scores[name][:, column]):8.3f}" for column in (0, 1)]
        figures += [f"{np.percentile(each, q):8.1f}" for each in (level, up) for q in (50, 90)]
        print(f"{name:>12}  log density x,y and z {' '.join(figures[:2])}", end="")
        print(f"   after 10 s (m): horizontal median, 90 % {' '.join(figures[2:4])}", end="")
        print(f"   vertical {' '.join(figures[4:])}")
    for column, words in enumerate(("horizontal", "vertical")):
        mean, error = gain(scores["no velocity"][:, column], scores["velocity"][:, column], np.cumsum(plain.placed.new))
        print(f"gain of a held-out position, {words}: {mean:+.3f} ± {error:.3f} nats")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FLIGHTS)
