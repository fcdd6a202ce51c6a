"""The one command behind `make bench`: measures, prints the table, keeps it in benchmarks/RESULTS.md.

python -m benchmarks.run [--quick | --ratios] [--only TASK ...] [--output FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any

from . import adaptive_targets, commands, doppler, gradients, learning, ratios, sky_race, stages, table, targets

ROOT = Path(__file__).resolve().parents[1]
POOLS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
)  # other libraries' threads: one core for all
# memory that is freed stays with the process, so that a round does not pay for pages fresh from the system
KEPT = {"MALLOC_MMAP_MAX_": "0", "MALLOC_TRIM_THRESHOLD_": str(1 << 40)}
TASKS = (
    "engine",
    "adaptive",
    "structure",
    "learning",
    "gradients",
    "peers",
    "skies",
    "doppler",
    "fresh",
    "threads",
    "memory",
    "start",
    "track",
    "compare",
)
FLAGS = {
    "v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "v3": {"avx2", "fma", "bmi2"},
    "v2": {"sse4_2"},
}


def measure(chosen: tuple[str, ...], quick: bool) -> dict[str, Any]:
    """Run the chosen tasks one after another; a task that fails leaves its reason."""
    size = "quick" if quick else "full"
    tasks: dict[str, Callable[[], dict[str, Any]]] = {
        "engine": lambda: _engine(size, rounds=1 if quick else 3),
        "adaptive": lambda: {"adaptive": _attempt("adaptive", size, **KEPT)},
        "structure": lambda: {"structure": _attempt("structure", size, **KEPT)},
        "learning": lambda: {"learning": _attempt("learning", size, **KEPT)},
        "gradients": lambda: {"gradients": _attempt("gradients", size, **KEPT)},
        "peers": lambda: {"peers": _attempt("peers", size, **KEPT)},
        "skies": lambda: {"skies": _attempt("skies", size)},
        "doppler": lambda: {"doppler": _attempt("doppler", size)},
        "fresh": lambda: {"fresh": _attempt("fresh", size)},
        "threads": lambda: {"threads": _attempt("threads", size, **KEPT)},
        "memory": lambda: {
            "memory, states": _attempt("memory", size, "--outputs", "STATES"),
            "memory, everything": _attempt("memory", size, "--outputs", "EVERYTHING"),
        },
        "start": lambda: {"start": _guard(lambda: commands.measure_start(5 if quick else 15))},
        "track": lambda: {"track": _guard(lambda: commands.measure_track(1 if quick else 5))},
        "compare": lambda: {
            "compare": _guard(lambda: commands.measure_compare(1 if quick else 5)),
            "compare, long": _guard(lambda: commands.measure_compare(1, 2000 if quick else 10_000)),
        },
    }
    results: dict[str, Any] = {}
    for name in chosen:
        begin = time.perf_counter()
        print(f"{name} ...", end=" ", file=sys.stderr, flush=True)
        results |= tasks[name]()
        print(f"{time.perf_counter() - begin:.0f} s", file=sys.stderr)
    return results


def machine() -> dict[str, str]:
    """Processor and versions, for the head of the report."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        found = [
            line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")
        ]
        model = found[0] if found else model
    versions = {name: _version(name) for name in ("jink", "numpy")}
    if hasattr(os, "getloadavg"):
        versions["load average at the start"] = f"{os.getloadavg()[0]:.1f}"
    return {"Processor": f"{model}, {os.cpu_count()} cores", "Python": platform.python_version(), **versions}


def main(arguments: list[str] | None = None) -> int:
    """Measure, print, write; exit status 0 whether or not every target is reached."""
    parser = argparse.ArgumentParser(
        prog="benchmarks.run", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="smaller sizes, under a minute; nothing is written")
    parser.add_argument("--only", nargs="+", choices=TASKS, default=TASKS, help="some tasks only; nothing is written")
    parser.add_argument(
        "--output",
        type=Path,
        help="where the report goes (default: benchmarks/RESULTS.md for a whole, full run)",
    )
    parser.add_argument("--ratios", action="store_true", help="ratios alone, under three minutes; nothing is written")
    options = parser.parse_args(arguments)
    facts = machine()
    if options.ratios:
        return _ratios(facts, options.output)
    results = measure(tuple(options.only), options.quick)
    rows = targets.rows(results) + adaptive_targets.rows(results) + learning.rows(results) + gradients.rows(results)
    if options.only != TASKS:
        rows = [row for row in rows if row.measured != "not measured" and "(not run)" not in row.measured]
    size = "quick: indicative only" if options.quick else "full"
    body = [*table.target_table(rows), "", "### Peers", "", *table.peer_table(results.get("peers", {}))]
    if "skies" in results.get("skies", {}):
        body += ["", "### Many targets", "", *sky_race.table_of(**results["skies"])]
    if "doppler" in results:
        body += ["", "### Doppler radar of the Optimized Kalman Filter", "", *doppler.table_of(results["doppler"])]
    text = table.part(facts, size, body, rows)
    print(text)
    output = options.output
    if output is None and not options.quick and options.only == TASKS:
        output = Path(__file__).with_name("RESULTS.md")
    _keep(output, text)
    return 0


def _ratios(facts: dict[str, str], output: Path | None) -> int:
    """The ratios and the stages of `jink track`, in under three minutes on an idle machine."""
    rows = ratios.rows(_attempt("ratios", "full")["ratios"]) + stages.rows(stages.measure(3))
    text = table.part(facts, "ratios", table.target_table(rows), rows)
    print(text)
    _keep(output, text)
    return 0


def _keep(output: Path | None, part: str) -> None:
    """Write the part into the report, in place of an older one of this machine."""
    if output is None:
        return
    before = output.read_text(encoding="utf-8") if output.exists() else ""
    output.write_text(table.with_part(before, part), encoding="utf-8")
    print(f"written to {output}", file=sys.stderr)


def _engine(size: str, rounds: int) -> dict[str, Any]:
    """Instruction-set levels in turn, their costs pooled over the rounds."""
    levels = [level for level, flags in FLAGS.items() if flags <= _processor_flags()]
    results: dict[str, Any] = {
        level: {"error": "this processor has not got it"} for level in FLAGS if level not in levels
    }
    for _ in range(rounds):
        for level in levels:
            costs = _attempt("engine", size, JINK_ISA=level, **KEPT)
            if "error" in costs:
                results[level] = costs
                continue
            pooled = results.setdefault(level, {})
            for job, values in costs.items():
                pooled[job] = [*pooled.get(job, []), *values]
    return results


def _attempt(task: str, size: str, *arguments: str, **environment: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "benchmarks.child", task, "--size", size, *arguments]
    environment = {**os.environ, **dict.fromkeys(POOLS, "1"), **environment}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stderr, file=sys.stderr)
        words = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        return {"error": words[-1]}
    return json.loads(done.stdout.splitlines()[-1])


def _guard(task: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    try:
        return task()
    except (OSError, RuntimeError) as error:
        return {"error": str(error)}


def _processor_flags() -> set[str]:
    info = Path("/proc/cpuinfo")
    if not info.exists():
        return set()
    lines = [line for line in info.read_text().splitlines() if line.startswith("flags")]
    return set(lines[0].split(":", 1)[1].split()) if lines else set()


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "(not installed)"


if __name__ == "__main__":
    sys.exit(main())
