"""Many targets in clutter: every figure that must be reached on the registered skies, with its standard error.

python -m benchmarks.skies [--quick] [--seed S] [--only ROW ...] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import math

from jink.metrics.figure import Figure

from . import sky_flights, sky_radars
from .sky_measures import Numbers, figures, measure
from .sky_rows import MUST, Limits, rows

SHOWN = ("gospa", "ratio", "switches", "ids", "held", "false", "ms", "worst ms", "living", "growth")


def judged(label: str, found: dict[str, Figure], limits: Limits) -> tuple[str, int]:
    """The line of a row, with `MISS` and what it misses, and how many figures were missed."""
    names = [name for name in SHOWN if name in found] + [name for name in found if name not in SHOWN]
    text = "  ".join(f"{name} {found[name].value:.4g} ± {found[name].se:.2g}" for name in names)
    missed, reached = [], []
    for name, (low, high) in limits.items():
        value, se = found[name]
        wanted = f"≤ {high:g}" if low == -math.inf else f"≥ {low:g}" if high == math.inf else f"{low:g} to {high:g}"
        if low <= value <= high:
            reached.append(f"{name} {wanted}")
            continue
        off = max(low - value, value - high)
        missed.append(f"{name} {value:.4g}, wanted {wanted}" + (", within one standard error" if off < se else ""))
    verdict = [f"MISS {each}" for each in missed] + ([f"reached {', '.join(reached)}"] if reached else [])
    return "\n".join([f"{label}: {text}", *(f"    {line}" for line in verdict)]), len(missed)


def main() -> None:
    """Measure, print and judge every row, keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a tenth of the runs, no sky of 4000")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--only", nargs="*", default=[], help="rows whose label begins so")
    parser.add_argument("--json")
    given = parser.parse_args()
    results: dict[str, dict[str, Figure]] = {}
    kept: dict[str, Numbers] = {}
    limited = missed = 0

    def show(label: str, found: dict[str, Figure], limits: Limits) -> None:
        nonlocal limited, missed
        results[label] = found
        text, count = judged(label, found, limits)
        limited, missed = limited + len(limits), missed + count
        print(text, flush=True)

    for row in rows(given.only, given.quick):
        kept[row.label] = measure(row, given.seed)
        if row.against and row.against not in kept:
            true = next(each for each in MUST if each.label == row.against)
            kept[row.against] = measure(true, given.seed)
        show(row.label, figures(kept[row.label], kept.get(row.against)), row.limits)
    for label, work, limits in (*sky_radars.ROWS, *sky_flights.ROWS):
        if not given.only or any(label.startswith(o) for o in given.only):
            show(label, work(given.seed, given.quick), limits)
    print(f"{limited - missed} of {limited} aims are reached")
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            json.dump(
                {label: {n: list(f) for n, f in found.items()} for label, found in results.items()}, file, indent=1
            )


if __name__ == "__main__":
    main()
