"""Every registered filter on every sensor, with hostile but legal parameters and data: counts of what must be 0.

    python -m benchmarks.torture [--updates 1e8] [--filter NAME] [--sensor NAME] [--seed 1] [--workers 2] [--quick]

Noises from 1e-6 to 1e6, steps from 1e-4 to 1e4 s, 10 % of the rows missing, outliers up to 1e300, targets over the
site, repeated times, tracks of 10⁵ scans. Each case is filtered, smoothed, and tracked live, saved midway and restored.
Counted are rows that are not finite after their track's start, covariances that are not positive semidefinite, mode
probabilities that do not sum to one, rows without an estimate after the start, and live rows that a restored state
gives otherwise. A filter that a purpose cannot have says so (``refused``). The exit status is 1
unless every count is 0.
"""

from __future__ import annotations

import argparse
import sys
import time as clock
import zlib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.catalogue.targets import KINDS
from jink.models.outliers import Outliers
from jink.models.start import Prior

from .torture_checks import MUST_BE_NONE, checked, lost
from .torture_data import SENSORS, Rows, hostile

SDS = (1e-6, 1e-3, 1.0, 25.0, 1e3, 1e6)
STEPS = (1e-4, 1e-2, 1.0, 10.0, 1e3, 1e4)
TRACKS, LIVE_SCANS, LONG = 64, 24, 100_000
OUTPUTS = ("x", "P", "mode_probability", "log_likelihood_scan", "status")


class Case(NamedTuple):
    """One filter on one sensor. scans: of each track; long: of the one long track, 0 for none."""

    filter: str
    sensor: str
    sds: tuple[float, ...]
    steps: tuple[float, ...]
    scans: int
    long: int
    seed: int


class Found(NamedTuple):
    """Counts, and the first offenders in words."""

    counts: Counter[str]
    offenders: list[str]


def made(case: Case, sd: float, step: float, rng: np.random.Generator) -> Any:
    """The filter for a purpose drawn at random. Errors: ValueError where it cannot be made for it."""
    kind, outliers = str(rng.choice(list(KINDS))), Outliers() if rng.random() < 0.5 else None
    purpose = Purpose(sensor=SENSORS[case.sensor](sd), kind=kind, sd=sd, interval=step, outliers=outliers)
    make = FILTERS[case.filter]
    if outliers is not None and rng.random() < 0.5:
        with suppress(ValueError):  # not every filter can decide with hindsight
            return make(replace(purpose, outliers=Outliers(hindsight=True))).filter
    return make(purpose).filter


def run(case: Case) -> Found:
    """All noises and steps of one case."""
    total, offenders = Counter[str](), []
    plans = [(sd, step, TRACKS, case.scans) for sd, step in product(case.sds, case.steps)]
    plans += [(25.0, 1.0, 1, case.long)] if case.long else []
    for number, plan in enumerate(plans):
        found = once(case, number, *plan)
        total.update(found.counts)
        offenders += found.offenders
    return Found(total, offenders)


def once(case: Case, number: int, sd: float, step: float, tracks: int, scans: int) -> Found:
    """One noise and one step: the run that offenders are named after, by filter, sensor, number and seed."""
    total, offenders = Counter[str](), []
    name = f"{case.filter}/{case.sensor}/{number}/{case.seed}"
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    try:
        filter = made(case, sd, step, rng)
    except ValueError:
        return Found(Counter(refused=1), [])
    rows = hostile(filter.sensors[0], sd, step, tracks, scans, rng)
    more = {"initial": _prior(filter)} if case.sensor == "bearing" else {}
    verbs = {"filter": filter.filter} | ({} if filter.not_smoothed else {"smooth": filter.smooth})
    for verb, call in verbs.items():
        estimate = call(**rows.batch(), **more, threads=1, outputs=OUTPUTS)
        found = checked(estimate, len(rows.z))
        found["lost"] += _lost(filter, estimate.status, rows.time, tracks)
        _note(found, f"{name} {verb} sd {sd:g} step {step:g}", total, offenders)
    if tracks > 1:
        found = live(filter, rows, tracks, more.get("initial"))
        _note(found, f"{name} live sd {sd:g} step {step:g}", total, offenders)
    return Found(total, offenders)


def _note(found: Counter[str], name: str, total: Counter[str], offenders: list[str]) -> None:
    total.update(found)
    bad = {what: found[what] for what in MUST_BE_NONE if found[what]}
    if bad:
        offenders.append(f"{name}: {bad}")


def _lost(filter: Any, status: Any, time: np.ndarray, tracks: int) -> int:
    return lost(np.reshape(status, (tracks, -1)), time.reshape(tracks, -1), getattr(filter, "coast", None))


def _prior(filter: Any) -> Prior:
    n = len(filter.components)
    return Prior(np.full(n, 1e-3), np.diag(np.full(n, 1e4)))


def live(filter: Any, rows: Rows, tracks: int, prior: Prior | None) -> Counter[str]:
    """All tracks together scan by scan, with a lag where there is a smoother; saved, restored, gone on with twice."""
    scans = min(LIVE_SCANS, len(rows.time) // tracks)
    time, z = (values.reshape(tracks, -1, *values.shape[1:])[:, :scans] for values in (rows.time, rows.z))
    lag = 0 if filter.not_smoothed else 2
    first, second, total = filter.start(tracks, lag=lag), filter.start(tracks, lag=lag), Counter[str]()
    if prior is not None:
        for track in range(tracks):
            first.begin(track, np.asarray(prior.x), np.asarray(prior.P), float(time[track, 0]))
    statuses = []
    for scan in range(scans):
        if scan == scans // 2:
            second.restore(first.save())
        one = first.update(time[:, scan], z[:, scan])
        total.update(checked(one, tracks))
        statuses.append(np.asarray(one.status))
        if scan >= scans // 2:  # what the lag looks back over is not part of a saved state
            two = second.update(time[:, scan], z[:, scan])
            same = [np.array_equal(one.results[k], two.results[k], equal_nan=True) for k in one.results]
            total["restored otherwise"] += 0 if all(same) or scan < scans // 2 + lag else tracks
    if not lag:  # else estimates are of scans before
        total["lost"] += _lost(filter, np.stack(statuses, axis=1), time, tracks)
    return total


def cases(options: argparse.Namespace) -> list[Case]:
    """Filters by sensors; as many scans as give about the updates asked for."""
    filters = [options.filter] if options.filter else list(FILTERS)
    sensors = [options.sensor] if options.sensor else list(SENSORS)
    sds, steps = (SDS[::5], STEPS[::3]) if options.quick else (SDS, STEPS)
    pairs = len(filters) * len(sensors)
    each = options.updates / (pairs * len(sds) * len(steps) * TRACKS * 1.6)  # some are smoothed, some refused
    scans = 6 if options.quick else max(LIVE_SCANS, round(each))
    long = 0 if options.quick else LONG
    return [Case(f, s, sds, steps, scans, long, options.seed) for f, s in product(filters, sensors)]


def main(arguments: list[str] | None = None) -> int:
    """Print a line per filter, the offenders, and the totals."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.torture", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--updates", type=float, default=1e8, help="about how many in all")
    parser.add_argument("--filter", choices=FILTERS)
    parser.add_argument("--sensor", choices=SENSORS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="a few scans of the outermost noises and steps")
    options = parser.parse_args(arguments)
    began, total, offenders = clock.perf_counter(), Counter[str](), list[str]()
    columns = ("updates", *MUST_BE_NONE, "refused")
    print(f"{'filter':20}" + "".join(f"{name:>20}" for name in columns))
    with ProcessPoolExecutor(options.workers) as pool:
        planned = cases(options)
        by_filter: dict[str, Counter[str]] = {}
        last = {case.filter: case for case in planned}
        for case, found in zip(planned, pool.map(run, planned), strict=True):
            by_filter.setdefault(case.filter, Counter()).update(found.counts)
            offenders += found.offenders
            if last[case.filter] is case:
                _line(case.filter, by_filter[case.filter], columns)
                total.update(by_filter[case.filter])
    _line("all", total, columns)
    for offender in offenders[:40]:
        print(offender)
    print(f"{len(offenders)} runs with a count that is not 0; {clock.perf_counter() - began:.0f} s")
    return 1 if offenders else 0


def _line(name: str, counts: Counter[str], columns: tuple[str, ...]) -> None:
    print(f"{name:20}" + "".join(f"{counts[column]:>20,}" for column in columns), flush=True)


if __name__ == "__main__":
    sys.exit(main())
