"""What hold on any machine: ratios of jink's own costs, from interleaved rounds in one process on one core.

python -m benchmarks.ratios [--rounds N] [--only WORD]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import jink

from . import engine, race, table
from .cases import regular
from .race import Job, compare
from .targets import Row, times

TRACKS, SCANS = 2000, 200
DEFAULT = ("x", "P", "mode_probability", "log_likelihood", "log_likelihood_scan", "nis", "nis_dof", "status")
STATES = ("x",)


@dataclass(frozen=True)
class Pair:
    """Two jobs and how many times dearer the first may be."""

    what: str
    dear: Job
    cheap: Job
    most: float


def flights(tracks: int, scans: int) -> tuple[Any, np.ndarray, np.ndarray]:
    """Time, positions in three axes and offsets, as `jink track` would filter aircraft."""
    case = regular(tracks, scans)
    height = 1e4 + 25.0 * np.random.default_rng(5).standard_normal(case.updates)
    return case.time, np.column_stack([case.z, height]), case.offsets


def pairs(tracks: int = TRACKS, scans: int = SCANS) -> list[Pair]:
    """Every ratio that has a limit."""
    case, bank, aircraft = (
        regular(tracks, scans),
        engine._imm(),
        jink.default_filter("aircraft", jink.Position(sd=25.0, axes=3)),
    )
    flat, solid = (case.time, case.z, case.offsets), flights(tracks, scans)
    return [
        Pair(
            "smooth ÷ filter, IMM 3 × 4, states", _job(bank.smooth, flat, STATES), _job(bank.filter, flat, STATES), 4.0
        ),
        Pair(
            "smooth ÷ filter, IMM 3 × 4, default outputs",
            _job(bank.smooth, flat, DEFAULT),
            _job(bank.filter, flat, DEFAULT),
            4.0,
        ),
        Pair(
            "smooth ÷ filter, aircraft in 3 axes, states",
            _job(aircraft.smooth, solid, STATES),
            _job(aircraft.filter, solid, STATES),
            4.0,
        ),
        Pair(
            "smooth ÷ filter, aircraft in 3 axes, default outputs",
            _job(aircraft.smooth, solid, DEFAULT),
            _job(aircraft.filter, solid, DEFAULT),
            4.0,
        ),
        Pair(
            "default call ÷ reused arrays, IMM 3 × 4",
            _job(bank.filter, flat, None, reuse=False),
            _job(bank.filter, flat, None),
            1.3,
        ),
    ]


def _job(verb: Callable[..., Any], given: Sequence[Any], outputs: Sequence[str] | None, reuse: bool = True) -> Job:
    """One call on one thread, into the arrays of the call before if they are reused."""
    time, z, offsets = given
    out: list[Any] = [None]

    def run(_: None) -> Any:
        estimate = verb(time, z, offsets=offsets, threads=1, outputs=outputs, out=out[0])
        if reuse:
            out[0] = estimate
        return estimate

    return Job(run, len(time))


def measure(rounds: int, only: str = "", size: tuple[int, int] = (TRACKS, SCANS)) -> list[dict[str, Any]]:
    """Costs per row of both jobs of each pair, round by round."""
    found = []
    for pair in pairs(*size):
        if only not in pair.what:
            continue
        laps = race.run_race({"dear": pair.dear, "cheap": pair.cheap}, rounds)
        found.append({"what": pair.what, "most": pair.most, "dear": laps["dear"].costs, "cheap": laps["cheap"].costs})
    return found


def rows(found: Sequence[dict[str, Any]]) -> list[Row]:
    """A line each: the ratio, and the costs that it is of."""
    out = []
    for entry in found:
        dear, cheap = (race.Lap(tuple(entry[name])) for name in ("dear", "cheap"))
        ratio = compare(dear, cheap)
        costs = f"{1e9 * dear.median:.0f} and {1e9 * cheap.median:.0f} ns a row"
        out.append(
            Row(entry["what"], f"{times(ratio)}; {costs}", f"≤ {entry['most']:g}", ratio.median <= entry["most"])
        )
    return out


def main(arguments: list[str] | None = None) -> int:
    """Print the table of ratios."""
    parser = argparse.ArgumentParser(prog="benchmarks.ratios", description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", default="", help="part of what is measured")
    options = parser.parse_args(arguments)
    race.pin_to_one_core()
    print("\n".join(table.target_table(rows(measure(options.rounds, options.only)))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
