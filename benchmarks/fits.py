"""The IMM of constant velocity and acceleration fitted on training runs of lee-2003, with truth and from measurements
alone.

    python -m benchmarks.fits [--runs 200] [--check-runs 2000] [--seed 0]

Prints the normalised errors (RMS error of the estimate over that of the measurement, position and velocity, averaged
over scans) on fresh runs, and how long the fit took.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from jink.fit import Fit, fit

REACH = {"normalised": (0.490, 0.0705), "likelihood": (0.51, 0.075)}  # with truth, from measurements alone
WORDS = {"normalised": "with truth", "likelihood": "from measurements alone"}
SECONDS = 30
FIGURES = ("normalised_position", "normalised_velocity")


def fitted(objective: str, runs: int, check_runs: int, seed: int) -> Fit:
    """The fit of one objective, checked on fresh runs."""
    return fit("lee-2003", "imm-cv-ca", objective=objective, runs=runs, check_runs=check_runs, seed=seed)


def line(objective: str, found: Fit) -> str:
    """Figures, what to reach, seconds."""
    cells = []
    for metric, reach in zip(FIGURES, REACH[objective], strict=True):
        figure = found.race.figure("fitted", metric)
        cells.append(f"{figure.value:.4f} ± {figure.se:.4f} (≤ {reach:g})")
    return f"{WORDS[objective]:<26}{'   '.join(cells)}   {found.seconds:.1f} s (≤ {SECONDS})"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both lines."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--check-runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    print(f"lee-2003, imm-cv-ca fitted on {given.runs} runs, {given.check_runs} fresh ones")
    for objective in REACH:
        print(line(objective, fitted(objective, given.runs, given.check_runs, given.seed)))


if __name__ == "__main__":
    main()
