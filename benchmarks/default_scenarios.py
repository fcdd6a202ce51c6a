"""The default filter on every scenario: against no filter, and against the better single filter fitted there.

    python -m benchmarks.default_scenarios [--runs 2000] [--seed 0]

RMS of the position error in metres, as `jink compare` counts it. Differences are paired over runs, with 95% intervals;
"worse" stands where an interval lies above zero.
"""

from __future__ import annotations

import argparse

from jink.compare import compare
from jink.scenarios import SCENARIOS

SINGLE = ("kalman-cv", "kalman-ca")
METRIC = "position_rmse"


def line(name: str, runs: int, seed: int) -> str:
    """One scenario: the three errors, and the default's difference to the other two."""
    race = compare(name, ["imm", *SINGLE], runs=runs, seed=seed)
    best = min(SINGLE, key=lambda single: race.figure(single, METRIC).value)
    cells = [f"{race.figure(who, METRIC).value:9.2f}" for who in ("imm", "raw", best)]
    for other in ("raw", best):
        gap = race.compare("imm", other, METRIC)
        cells.append(f"{gap.difference:+9.3f} ({gap.low:+.3f} … {gap.high:+.3f}) {gap.verdict:9}")
    return f"{name:28}" + " ".join([*cells[:3], best, *cells[3:]])


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser()
    options.add_argument("--runs", type=int, default=2000)
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args()
    print(f"{given.runs} runs, seed {given.seed}; metres")
    print(f"{'':28}{'default':>9} {'raw':>9} {'single':>9}{'':11}{'default − raw':47} default − single")
    for name in SCENARIOS:
        print(line(name, given.runs, given.seed), flush=True)


if __name__ == "__main__":
    main()
