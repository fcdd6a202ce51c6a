"""What holds on any machine: ratios of jink's own costs, from interleaved rounds in one process on one core.

`python -m benchmarks.run --ratios` prints them. Memory comes as the system gives it: one ratio is about that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import jink

from . import engine, gradients, race, reference_kernel
from .cases import regular
from .race import Job, compare
from .targets import Row, times

TRACKS, SCANS = 2000, 200
DEFAULT = None  # the outputs that a call gives if none are named
STATES = ("x",)
OUTPUTS = {"states": STATES, "default outputs": DEFAULT}
# the most that a smoothed row may cost in filtered ones, a call in ones that reuse arrays, a row in the kernel's
SMOOTH, FRESH, KERNEL = 4.0, 1.3, 1.3
AGAINST_KERNEL = "filter ÷ reference kernel, IMM 3 × 4, states and log-likelihood"


@dataclass(frozen=True)
class Pair:
    """Two jobs and how many times dearer the first may be; None where nothing was promised."""

    what: str
    dear: Job
    cheap: Job
    most: float | None


def flights(tracks: int, scans: int) -> tuple[Any, np.ndarray, np.ndarray]:
    """Time, positions in three axes and offsets, as `jink track` filters aircraft."""
    case = regular(tracks, scans)
    height = 1e4 + 25.0 * np.random.default_rng(5).standard_normal(case.updates)
    return case.time, np.column_stack([case.z, height]), case.offsets


def pairs(tracks: int = TRACKS, scans: int = SCANS) -> list[Pair]:
    """Every ratio that is printed."""
    case, bank = regular(tracks, scans), engine._imm()
    aircraft = jink.default_filter("aircraft", jink.Position(sd=25.0, axes=3))
    flat, solid = (case.time, case.z, case.offsets), flights(tracks, scans)
    out = [
        Pair(
            f"smooth ÷ filter, {name}, {words}",
            _job(filter.smooth, given, outputs),
            _job(filter.filter, given, outputs),
            SMOOTH,
        )
        for name, filter, given in (("IMM 3 × 4", bank, flat), ("aircraft in 3 axes", aircraft, solid))
        for words, outputs in OUTPUTS.items()
    ]
    fresh, reused = _job(bank.filter, flat, DEFAULT, reuse=False), _job(bank.filter, flat, DEFAULT)
    slopes = gradients.jobs(max(1, tracks // 10), scans)
    return [
        *out,
        Pair("default call ÷ reused arrays, IMM 3 × 4", fresh, reused, FRESH),
        Pair(
            "log-likelihood and 10 derivatives ÷ log-likelihood",
            slopes[gradients.SLOPES],
            slopes[gradients.VALUE],
            None,
        ),
    ]


def kernel_pair(tracks: int, scans: int) -> Pair:
    """The filter against the kernel that was written by hand for its case, once both have given the same.

    Errors: RuntimeError without a C++ compiler, or if they differ.
    """
    case, bank = regular(tracks, scans), engine._imm()

    def verb(*given: Any, **keywords: Any) -> Any:
        return bank.filter(*given, initial=engine._prior(case), **keywords)

    dear = _job(verb, (case.time, case.z, case.offsets), engine.STATES)
    estimate = dear.run(None)
    reference_kernel.check(case, estimate.x, estimate.log_likelihood)
    return Pair(AGAINST_KERNEL, dear, reference_kernel.job(case), KERNEL)


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


def measure(rounds: int, tracks: int = TRACKS, scans: int = SCANS) -> list[dict[str, Any]]:
    """Costs of both jobs of each pair, round by round."""
    found: list[dict[str, Any]] = []
    wanted = pairs(tracks, scans)
    try:
        wanted.append(kernel_pair(tracks, scans))
    except RuntimeError as error:
        found.append({"what": AGAINST_KERNEL, "most": KERNEL, "error": str(error)})
    for pair in wanted:
        laps = race.run_race({"dear": pair.dear, "cheap": pair.cheap}, rounds)
        found.append({"what": pair.what, "most": pair.most, "dear": laps["dear"].costs, "cheap": laps["cheap"].costs})
    return found


def rows(found: Sequence[dict[str, Any]]) -> list[Row]:
    """A line each: the ratio, and the costs that it is of."""
    out = []
    for entry in found:
        if "error" in entry:
            out.append(Row(entry["what"], f"not measured: {entry['error']}", f"≤ {entry['most']:g}"))
            continue
        dear, cheap = (race.Lap(tuple(entry[name])) for name in ("dear", "cheap"))
        ratio, most = compare(dear, cheap), entry["most"]
        costs = f"{1e9 * dear.median:.0f} and {1e9 * cheap.median:.0f} ns a row"
        must = "" if most is None else f"≤ {most:g}"
        reached = None if most is None else ratio.median <= most
        out.append(Row(entry["what"], f"{times(ratio)}; {costs}", must, reached))
    return out
