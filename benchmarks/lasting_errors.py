"""Errors of positions that last, as those of satellite receivers: what share of estimates is inside two sds.

    python -m benchmarks.lasting_errors [--targets 12]

Walkers and cars are seen every second with errors of 3 m, which die away with the time constant in the second column
(first-order Markov); 5 % of the sd is white. They go straight for 20 minutes, or turn every 20 seconds for five. *With
a straight one*: one that goes straight is in the same file, and the one that turns is scored. `jink track` estimates
the noise from the positions alone. *found*: targets whose errors were found to last. Three treatments: what third
differences show as noise; all of the error as noise; and that with what no filter takes out, which is what `jink track`
does (`jink.tracking.lasting`).
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import polars as pl

import jink
from benchmarks.default_filters import targets
from jink.tracking import lasting, noise_level

SECONDS = (0.0, 3.0, 10.0, 30.0)
SETTLED = 60  # rows


def markov(shape: tuple[int, int], sd: float, seconds: float, rng: np.random.Generator) -> np.ndarray:
    """Errors (B, S, 2) that die away in so many seconds, one row a second."""
    kept = np.exp(-1.0 / seconds) if seconds else 0.0
    error = rng.normal(size=(*shape, 2))
    for k in range(1, shape[1]):
        error[:, k] = kept * error[:, k - 1] + np.sqrt(1.0 - kept**2) * error[:, k]
    return sd * (error + 0.05 * rng.normal(size=error.shape))


def shares(data: pl.DataFrame, truth: np.ndarray, kind: str, smooth: bool) -> tuple[float, float, bool]:
    """Share of target A's errors inside two sds, their RMS (m), and whether they were found to last."""
    tracked = jink.track(data, kind=kind, smooth=smooth, details=True)
    table = tracked.tracks.filter(pl.col("target") == "A")
    late = table["time"].to_numpy() >= SETTLED
    error = (table.select("x", "y").to_numpy() - truth[table["row"].to_numpy()])[late]
    inside = np.abs(error) <= 2.0 * table.select("x_sd", "y_sd").to_numpy()[late]
    found = any("lasting_sd" in line for line in tracked.summary["noise"])
    return float(inside.mean()), float(np.sqrt((error**2).mean())), found


def straight(speed: float, seconds: float, run: int) -> pl.DataFrame:
    """A target that goes straight for 20 minutes, far from the others, with errors of the same kind."""
    time = np.arange(1200.0)
    error = markov((1, time.size), 3.0, seconds, np.random.default_rng((2, run)))[0]
    z = np.stack([50_000.0 + speed * time, 0.3 * speed * time], axis=-1) + error
    return pl.DataFrame({"target": "B", "time": time, "x": z[:, 0], "y": z[:, 1]})


def no_errors(*given: Any) -> np.ndarray:
    """As if none lasted."""
    return np.full((2, given[-1].size), np.nan)


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--targets", type=int, default=12)
    count = options.parse_args().targets
    made = {title.split(",")[0]: scenario.simulate(range(count), 5) for title, scenario in targets()}
    time = np.arange(1200.0)
    paths: dict[str, tuple[str, np.ndarray, np.ndarray, float]] = {}
    for who, kind, speed in (("person", "person", 1.4), ("car", "vehicle", 12.0)):
        run = made[who]
        line = np.broadcast_to(np.stack([speed * time, 0.3 * speed * time], -1), (count, 1200, 2))
        paths[f"{who}, straight"] = (kind, line, time, 0.0)
        paths[f"{who}, turns"] = (kind, run.truth.position[..., :2], run.time[0], 0.0)
        paths["  with a straight one" + " " * (who == "car")] = (kind, *paths[f"{who}, turns"][1:3], speed)
    estimate, kept = noise_level.lasting_errors, lasting.KEPT
    print(" " * 33 + "third differences   all of the error    and what it keeps")
    print("target                   s found  filtered smoothed  filtered smoothed  filtered smoothed  RMS filtered, m")
    for name, (kind, truth, time, beside) in paths.items():
        for seconds in SECONDS:
            error = markov(truth.shape[:2], 3.0, seconds, np.random.default_rng(1))
            cells: list[list[Any]] = []
            for run in range(count):
                z = truth[run] + error[run]
                data = pl.DataFrame({"target": "A", "time": time, "x": z[:, 0], "y": z[:, 1]})
                if beside:
                    data = pl.concat([data, straight(beside, seconds, run)])
                row: list[Any] = []
                for finder, share in ((no_errors, 0.0), (estimate, 0.0), (estimate, kept)):
                    noise_level.lasting_errors, lasting.KEPT = finder, share
                    row += [shares(data, truth[run], kind, smooth) for smooth in (False, True)]
                cells.append(row)
            noise_level.lasting_errors, lasting.KEPT = estimate, kept
            figures = np.array(cells, float)  # targets, treatments, (inside, rms, found)
            inside, rms = figures[:, :, 0].mean(axis=0), np.sqrt((figures[:, :, 1] ** 2).mean(axis=0))
            words = "".join(f"  {100 * a:7.1f}% {100 * b:7.1f}%" for a, b in inside.reshape(3, 2))
            found, gain = 100 * figures[:, 4, 2].mean(), f"{rms[0]:.2f} → {rms[4]:.2f}"
            print(f"{name:22s} {seconds:3.0f} {found:4.0f}%{words}  {gain}", flush=True)


if __name__ == "__main__":
    main()
