"""What jink has promised of its speed and memory, and whether the measurements keep it."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .race import Lap, Ratio, compare

LEVELS = {"v4": "AVX-512", "v3": "AVX2", "v2": "SSE4"}
SAME = 1e-9  # a race counts only if jink's states are the textbook's
FIRST_ROW = "IMM 3 × 4 states, full covariances, {}, one core, {}"


@dataclass(frozen=True)
class Row:
    """One line of the table; reached is None where there is no target or nothing was measured."""

    what: str
    measured: str
    must: str = ""
    reached: bool | None = None


def rows(results: dict[str, Any]) -> list[Row]:
    """The whole table from the results of all tasks; a task missing or failed leaves rows that say so."""
    parts: Sequence[Callable[[dict[str, Any]], list[Row]]] = (
        _imm_rows,
        _imm_peer_rows,
        _harder_rows,
        _kalman_rows,
        _thread_rows,
        _live_rows,
        _track_rows,
        _compare_rows,
        _start_rows,
        _memory_rows,
    )
    return [row for part in parts for row in part(results)]


def _imm_rows(results: dict[str, Any]) -> list[Row]:
    limits = {"v4": (40, 70), "v3": (80, 140), "v2": (None, None)}
    out = []
    for level, pair in limits.items():
        for job, outputs, limit in zip(
            ("imm", "imm, every output"), ("states and log-likelihood", "every output"), pair, strict=True
        ):
            what = FIRST_ROW.format(outputs, LEVELS[level])
            out.append(_cost_row(what, _lap(results, level, job), 1e9, "ns", limit))
    what = "every output, its memory fresh from the operating system"
    fresh = _lap(results, "fresh", "imm, every output")
    return [*out, _cost_row(what, fresh, 1e9, "ns", None)]


def _imm_peer_rows(results: dict[str, Any]) -> list[Row]:
    return [_peer_row(results, "imm", "filterpy", "the first row against FilterPy's IMM", 8000)]


def _harder_rows(results: dict[str, Any]) -> list[Row]:
    level = best_level(results)
    cases = [
        (
            "IMM CV 4 + CV 4 + CA 6, irregular, 10% missing, states and log-likelihood",
            "mixed",
            "imm",
            2,
        ),
        (
            "IMM CV 4 + CV 4 + CA 6, irregular, 10% missing, every output",
            "mixed, every output",
            "imm, every output",
            2,
        ),
        ("IMM CV + CT (EKF), polar sensor, irregular", "turning", "imm", 6),
    ]
    out = []
    for what, job, first, limit in cases:
        lap, base = _lap(results, level, job), _lap(results, level, first)
        must = f"≤ {limit} × the first row"
        if lap is None or base is None:
            out.append(_missing(results, level, what, must))
            continue
        ratio = compare(lap, base)
        out.append(Row(what, f"{lap.median * 1e9:.1f} ns; {times(ratio)}", must, ratio.median <= limit))
    return out


def _kalman_rows(results: dict[str, Any]) -> list[Row]:
    level = best_level(results)
    what = "Kalman filter, 4 states, own covariance per track, one core, states out"
    lap = _lap(results, level, "kalman")
    must = "≥ 50 M updates/s"
    first = _missing(results, level, what, must)
    if lap is not None:
        rate = 1e-6 / lap.median
        first = Row(what, f"{rate:.0f} M updates/s ({lap.median * 1e9:.1f} ns)", must, rate >= 50)
    names = {"dynamax": "dynamax", "simdkalman": "simdkalman"}
    return [
        first,
        *(_peer_row(results, "kalman", key, f"that Kalman filter against {name}", 20) for key, name in names.items()),
    ]


def _thread_rows(results: dict[str, Any]) -> list[Row]:
    what, must = "the first row on two threads, wall clock", "≥ 1.8 × one"
    threads = results.get("threads", {})
    if "1" not in threads:
        return [_missing(results, "threads", what, must)]
    rounds = sorted(zip(threads["1"], threads["2"], strict=True), key=sum)
    one, two = zip(*rounds[: (len(rounds) + 1) // 2], strict=True)  # other processes slow the rest
    ratio = compare(Lap(one), Lap(two))
    return [Row(what, times(ratio), must, ratio.median >= 1.8)]


def _live_rows(results: dict[str, Any]) -> list[Row]:
    level = best_level(results)
    one = _cost_row("one live update of one IMM track from Python", _lap(results, level, "live"), 1e6, "µs", 1.5)
    peers = [
        ("filterpy", "FilterPy", 200),
        ("kalbee", "kalbee", 200),
        ("nrl_tracker", "nrl-tracker", 1),
        ("quakfilter", "quakfilter", 1),
    ]
    races = [_peer_row(results, "live", key, f"that live update against {name}", limit) for key, name, limit in peers]
    batch = _lap(results, level, "live batch")
    return [one, *races, _cost_row("one live scan of 10,000 tracks at once, one core", batch, 1e3, "ms", 1.5)]


def _track_rows(results: dict[str, Any]) -> list[Row]:
    track = results.get("track", {})
    what = "`jink track --smooth` on the quickstart collection, Parquet out, process start included"
    if "seconds" not in track:
        return [_missing(results, "track", what, "≤ 3 s, ≤ 600 MB")]
    cpu = f", {statistics.median(track['cpu']):.2f} s of CPU"
    seconds, megabytes = statistics.median(track["seconds"]), max(track["bytes"]) / 1e6
    return [
        Row(what, f"{seconds:.2f} s {_range(track['seconds'], 1, '.2f')}{cpu}", "≤ 3 s", seconds <= 3),
        Row("its peak memory", f"{megabytes:.0f} MB", "≤ 600 MB", megabytes <= 600),
    ]


def _compare_rows(results: dict[str, Any]) -> list[Row]:
    """The race of filters: its time, and that its memory does not grow with the runs."""
    raced, long = results.get("compare", {}), results.get("compare, long", {})
    what = "`jink compare lee-2003`, ten filters × 1000 runs × 180 scans, simulation and process start included"
    if "seconds" not in raced or "seconds" not in long:
        task = "compare" if "seconds" not in raced else "compare, long"
        return [_missing(results, task, what, "≤ 5 s")]
    cpu = f", {statistics.median(raced['cpu']):.2f} s of CPU"
    seconds = statistics.median(raced["seconds"])
    short_peak, long_peak = (max(each["bytes"]) / 1e6 for each in (raced, long))
    more = f"{long_peak:.0f} MB against {short_peak:.0f}"
    return [
        Row(what, f"{seconds:.2f} s {_range(raced['seconds'], 1, '.2f')}{cpu}", "≤ 5 s", seconds <= 5),
        Row("its peak memory with more runs (10,000)", more, "≤ 1.2 ×", long_peak <= 1.2 * short_peak),
    ]


def _start_rows(results: dict[str, Any]) -> list[Row]:
    start = results.get("start", {})
    out = []
    for name, what, limit in (("jink", "`import jink`", 30), ("help", "`jink --help`", 150)):
        must = f"≤ `import numpy` + {limit} ms"
        if name not in start:
            out.append(_missing(results, "start", what, must))
            continue
        numpy, ours = (1e3 * statistics.median(start[key]) for key in ("numpy", name))
        out.append(Row(what, f"{ours:.0f} ms = {numpy:.0f} ms + {ours - numpy:.0f} ms", must, ours - numpy <= limit))
    return out


def _memory_rows(results: dict[str, Any]) -> list[Row]:
    out = []
    for task, outputs in (
        ("memory, states", "states and log-likelihood"),
        ("memory, everything", "every output"),
    ):
        what, must = f"peak memory of the batch filter, {outputs}", "≤ 1.2 × input + output arrays"
        memory = results.get(task, {})
        if "grown" not in memory:
            out.append(_missing(results, task, what, must))
            continue
        arrays = memory["in"] + memory["out"]
        share = (memory["in"] + memory["grown"]) / arrays
        out.append(Row(what, f"{share:.2f} × ({arrays / 1e6:.0f} MB)", must, share <= 1.2))
    return out


def best_level(results: dict[str, Any]) -> str:
    """The widest instruction-set level that was measured."""
    return next((level for level in LEVELS if "imm" in results.get(level, {})), "v4")


def _lap(results: dict[str, Any], task: str, job: str) -> Lap | None:
    costs = results.get(task, {}).get(job)
    return Lap(tuple(costs)) if costs else None


def _cost_row(what: str, lap: Lap | None, scale: float, unit: str, limit: float | None) -> Row:
    must = "" if limit is None else f"≤ {limit} {unit}"
    if lap is None:
        return Row(what, "not measured", must)
    cost = scale * lap.median
    digits = ".1f" if unit == "ns" else ".2f"
    reached = None if limit is None else cost <= limit
    return Row(what, f"{cost:{digits}} {unit} {_range(lap.costs, scale, digits)}", must, reached)


def _peer_row(results: dict[str, Any], job: str, key: str, what: str, limit: float) -> Row:
    must = "ahead" if limit == 1 else f"≥ {limit:,} ×"
    race = results.get("peers", {}).get(job, {})
    peer, ours = race.get(key, {}), race.get("jink", {})
    if "costs" not in peer or "costs" not in ours:
        return Row(what, peer.get("missing") or peer.get("cannot") or reason(results, "peers"), must)
    ratio = compare(Lap(tuple(peer["costs"])), Lap(tuple(ours["costs"])))
    same = ours["difference"] < SAME
    warning = "" if same else f", but jink differs from the textbook by {ours['difference']:.0e}"
    return Row(what, times(ratio) + warning, must, same and ratio.median >= limit)


def _missing(results: dict[str, Any], task: str, what: str, must: str) -> Row:
    return Row(what, reason(results, task), must)


def reason(results: dict[str, Any], task: str) -> str:
    """Why a task has no figures."""
    return f"not measured ({results.get(task, {}).get('error', 'not run')})"


def times(ratio: Ratio) -> str:
    """A ratio as median × (least–most)."""
    digits = ".2f" if ratio.median < 20 else ",.0f"
    return f"{ratio.median:{digits}} × ({ratio.low:{digits}}–{ratio.high:{digits}})"


def _range(values: Sequence[float], scale: float, digits: str) -> str:
    return f"({scale * min(values):{digits}}–{scale * max(values):{digits}})"
