"""Heights that are not measured for a while: what share of estimates is inside two sds, and how large the errors are.

    python -m benchmarks.unseen_heights [flights.parquet]

Of recorded flights the heights (and with `without`, their reported climb rates too) are taken out for so many seconds
in every ten minutes, while positions go on. What stands there afterwards is compared with the smoothed estimate of all
heights. `before`: sds as the filter says them, without what climb rates may do meanwhile
(`jink.tracking.unseen_heights`).
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import polars as pl

import jink
from jink.tracking import batch

FLIGHTS = Path(__file__).parents[1] / "examples" / "flights.parquet"
SECONDS = (10, 30, 60, 120, 240)
EVERY = 600  # s
HEIGHT, RATE = "altitude_ft", "vertical_rate_ft_min"


def errors(data: pl.DataFrame, truth: pl.DataFrame, seconds: int, smooth: bool) -> pl.DataFrame:
    """Errors and sds (m) of the heights that were taken out for so many seconds, at two phases."""
    found = []
    for phase in (0, EVERY // 2):
        out = (pl.col("time").dt.epoch("s") + phase) % EVERY < seconds
        some = data.with_columns(pl.when(~out).then(HEIGHT).alias(HEIGHT))
        rows = data.select(out=out).with_row_index("row").filter("out").select(pl.col("row").cast(pl.UInt32))
        tracks = jink.track(some, smooth=smooth).join(rows, on="row")
        both = tracks.filter(pl.col("altitude_status") == "predicted").join(truth, on="row")
        found.append(both.select(error=(pl.col("z") - pl.col("true_z")).abs(), sd="z_sd"))
    return pl.concat(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", nargs="?", default=FLIGHTS)
    warnings.simplefilter("ignore")
    data = pl.read_parquet(parser.parse_args().flights)
    known = jink.track(data, smooth=True).filter(pl.col("altitude_status") == "updated")
    truth = known.select("row", true_z="z")
    doubt = batch.with_doubt
    print("climb rates  seconds  estimates  rows   error 50/95 %   inside 2 sd: before   now")
    for rates in ("without", "with"):
        for seconds in SECONDS:
            for smooth in (False, True):
                given = data if rates == "with" else data.drop(RATE)
                batch.with_doubt = lambda placed, *_: placed
                before = errors(given, truth, seconds, smooth)
                batch.with_doubt = doubt
                now = errors(given, truth, seconds, smooth)
                half, most = (now["error"].quantile(q) for q in (0.5, 0.95))
                inside = [100.0 * float((each["error"] <= 2.0 * each["sd"]).mean()) for each in (before, now)]
                kind = "smoothed" if smooth else "filtered"
                print(
                    f"{rates:11} {seconds:8} {kind:>10} {now.height:6} {half:7.0f} {most:7.0f} m "
                    f"{inside[0]:16.1f} % {inside[1]:5.1f} %",
                    flush=True,
                )


if __name__ == "__main__":
    main()
