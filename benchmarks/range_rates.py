"""What a radar's range rate buys in files: errors of `jink.track` with it and without, run by run.

    python -m benchmarks.range_rates [RUNS]     (without RUNS twelve of each scenario)

Errors of one run last for many scans, so one run alone says little: the ratio has a standard error over runs.
"""

from __future__ import annotations

import sys
import warnings

import numpy as np
import polars as pl

import jink
from jink.scenarios import by_name
from jink.scenarios.observation import Seeing
from jink.scenarios.table import simulation_table

SCENARIOS = ("terminal-area", "random-turns", "weave")
WARM = 10.0  # s: not scored
TOGETHER = 3  # runs that are one file


def errors(tracks: pl.DataFrame, table: pl.DataFrame) -> np.ndarray:
    """RMSE of position (m) and velocity (m/s) of each run."""
    told = table.with_row_index("row").select("row", "run", "true_x", "true_y", "true_velocity_x", "true_velocity_y")
    both = tracks.join(told, on="row").filter(pl.col("time") > WARM)

    def rms(x: str, y: str) -> pl.Expr:
        return ((pl.col(x) - pl.col(f"true_{x}")) ** 2 + (pl.col(y) - pl.col(f"true_{y}")) ** 2).mean().sqrt()

    scored = both.group_by("run", maintain_order=True).agg(
        rms("x", "y").alias("place"), rms("velocity_x", "velocity_y").alias("velocity")
    )
    return scored.select("place", "velocity").to_numpy()


def main() -> None:
    """Print a line per scenario."""
    warnings.simplefilter("ignore")
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    for name in SCENARIOS:
        seen = Seeing(sensor="radar-20hz").of(by_name(name))
        found: dict[bool, list[np.ndarray]] = {True: [], False: []}
        for seed in range(runs // TOGETHER):
            table = simulation_table(seen.simulate(TOGETHER, seed=seed))
            for velocity, errors_of in found.items():
                errors_of.append(errors(jink.track(table, velocity=velocity), table))
        rate, plain = (np.concatenate(found[velocity]) for velocity in (True, False))
        log = np.log(rate / plain)
        ratio, spread = np.exp(log.mean(axis=0)), log.std(axis=0) / np.sqrt(len(log))
        worse = (rate > plain).mean(axis=0)
        for column, words in enumerate(("position m", "velocity m/s")):
            both = (float(np.sqrt((each[:, column] ** 2).mean())) for each in (plain, rate))
            print(
                f"{name:14s} {words:13s} RMSE {next(both):6.2f} -> {next(both):6.2f}, "
                f"ratio of a run {ratio[column]:.3f} ± {spread[column]:.3f}, larger in {100 * worse[column]:.0f} %",
                flush=True,
            )


if __name__ == "__main__":
    main()
