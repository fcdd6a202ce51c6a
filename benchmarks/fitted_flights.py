"""`jink fit` on real flights: is the fitted filter better on flights it has not seen, and does it believe what it
should?

    python -m benchmarks.fitted_flights                          # fetches the collection quickstart of the package
    traffic, 28 MB, once python -m benchmarks.fitted_flights traffic-2.13-py3-none-any.whl --seeds 0 1 2

213 flights, half of them to fit on, half to check on, split by flight (by the seed). Without truth: what counts is the
log-likelihood of every next plot. To be reached: a gain over the default filter whose paired 95% interval lies above
zero, and 90 to 98% of the NIS inside their 95% band where flights go straight, turn and climb. The default was itself
fitted on half of these flights, some of which are checked on here: that is to its advantage.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from benchmarks.commands import fetch_collection
from jink.fit import fit
from jink.fit.result import BAND, FITTED, START, Fit
from scripts.extract_flights import read

FLYING = ("straight", "turning", "climbing")


def main() -> None:
    """Fit for every seed and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "source", type=Path, nargs="?", help="the wheel of traffic 2.13, its quickstart.json.gz, or a table"
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--filter", default="imm")
    given = parser.parse_args()
    source = given.source or fetch_collection()
    with tempfile.TemporaryDirectory() as folder:
        if source.suffix == ".whl":
            table = Path(folder) / "quickstart.parquet"
            read(source).write_parquet(table)
            source = table
        for seed in given.seeds:
            print(said(fit(str(source), given.filter, seed=seed, starts=1), seed), flush=True)


def said(found: Fit, seed: int) -> str:
    """The figures of one fit."""
    gain = found.race.compare(FITTED, START, "prediction_score")
    prediction = found.race.compare(FITTED, START, "prediction_rmse")
    scenario = found.record["scenario"]
    words = found.training.replace(scenario, Path(scenario).name)
    out = [
        f"seed {seed}: {found.name}, fitted on {words}; checked on {found.race.runs} other targets",
        f"  log-likelihood per plot, fitted − default: {gain.difference:+.4f} ({gain.low:+.4f} … {gain.high:+.4f})"
        f"  {'reached' if gain.low > 0 else 'MISSED'}",
        f"  error of the predicted position, m: {prediction.difference:+.3f} ({prediction.low:+.3f} … "
        f"{prediction.high:+.3f})",
        "  NIS inside its 95% band     rows      default       fitted     below   above",
    ]
    before = {s.part: s for s in found.parts[START]}
    for s in found.parts[FITTED]:
        was = before[s.part].inside
        word = "" if s.part not in FLYING else "reached" if BAND[0] <= s.inside.value <= BAND[1] else "MISSED"
        out.append(
            f"    {s.part:20s} {s.rows:10,d}   {100 * was.value:4.1f} ± {100 * was.se:.1f}   "
            f"{100 * s.inside.value:4.1f} ± "
            f"{100 * s.inside.se:.1f}   {100 * s.below:6.1f}  {100 * s.above:6.1f}  {word}"
        )
    return "\n".join(out)


if __name__ == "__main__":
    main()
