"""The report of a benchmark run as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from . import peers
from .race import Lap, compare
from .targets import Row

MARK = {True: "pass", False: "**short**", None: ""}


HEAD = """\
# Speed and memory

One part for each machine and kind of run. `make bench` writes its machine's part, `python -m benchmarks.run --ratios
--output benchmarks/RESULTS.md` that of its ratios; the parts of other machines stay.
"""


def part(machine: dict[str, str], kind: str, lines: Sequence[str], rows: Sequence[Row]) -> str:
    """The part of one machine and kind of run: facts, how many targets are reached, the tables."""
    name, *others = machine.items()
    facts = "; ".join(f"{key} {value}" for key, value in others)
    counted = [row.reached for row in rows if row.must]
    reached, short, unknown = (counted.count(mark) for mark in (True, False, None))
    summary = f"{reached} of {len(counted)} targets reached, {short} short, {unknown} not measured."
    return "\n".join([f"## {name[1]}: {kind}", "", facts + ".", "", summary, "", *lines]) + "\n"


def with_part(text: str, new: str) -> str:
    """The report with a part in place of the one of the same title, or as its last one."""
    title = new.split("\n", 1)[0]
    parts = {each.split("\n", 1)[0]: each for each in re.split(r"^(?=## )", text, flags=re.MULTILINE)[1:]}
    parts.pop(HOW[0], None)
    parts[title] = new
    return "\n".join([HEAD, *(each.rstrip("\n") + "\n" for each in parts.values()), *HOW]) + "\n"


def target_table(rows: Iterable[Row]) -> list[str]:
    """What, measured, must reach, mark."""
    cells = [(row.what, row.measured, row.must, MARK[row.reached]) for row in rows]
    return markdown(("what", "measured: median (least–most)", "must reach", ""), cells)


def peer_table(race: dict[str, Any]) -> list[str]:
    """One line per job and library: cost per update, × jink, agreement with the textbook."""
    cells: list[tuple[str, ...]] = []
    for job, title in peers.JOBS.items():
        entries = race.get(job, {})
        for key, entry in entries.items():
            version = race.get("versions", {}).get(key, "") if "missing" not in entry else ""
            cells.append((title, key.replace("_", "-"), version, *_peer_cells(entry, entries.get("jink", {}))))
            title = ""
    for name, why in peers.LEFT_OUT.items():
        cells.append(("", name, "", "not installed", "", "", why))
    return markdown(
        ("job", "library", "version", "µs per update", "× jink", "differs from the textbook by", "note"),
        cells,
    )


def markdown(head: Sequence[str], cells: Iterable[Sequence[str]]) -> list[str]:
    """A Markdown table, columns padded so that it reads as plain text too."""
    table = [list(head), *(list(row) for row in cells)]
    width = [max(len(row[i]) for row in table) for i in range(len(head))]
    lines = ["| " + " | ".join(cell.ljust(width[i]) for i, cell in enumerate(row)) + " |" for row in table]
    return [lines[0], "|" + "|".join("-" * (w + 2) for w in width) + "|", *lines[1:]]


def _peer_cells(entry: dict[str, Any], ours: dict[str, Any]) -> tuple[str, str, str, str]:
    if "costs" not in entry:
        return (
            "not installed" if "missing" in entry else "cannot",
            "",
            "",
            entry.get("cannot") or entry.get("missing", ""),
        )
    lap = Lap(tuple(entry["costs"]))
    times = ""
    if "costs" in ours and entry is not ours:
        ratio = compare(lap, Lap(tuple(ours["costs"])))
        digits = ".1f" if ratio.median < 20 else ",.0f"
        times = f"{ratio.median:{digits}} ({ratio.low:{digits}}–{ratio.high:{digits}})"
    return f"{lap.median * 1e6:.4g}", times, f"{entry['difference']:.0e}", entry.get("note", "")


HOW = """\
## How it is measured

- All libraries of a job run in one process pinned to one core, round after round, each starting with another
  one; process CPU time; the median of the rounds; a ratio is taken round by round and given as median
  (least–most). Compilation and first calls are warmed up before. jink gets `threads=1`. Instruction sets
  are forced by `JINK_ISA` in processes of their own, in turn.
- Every library filters the same measurements from the same state and covariance; its states are compared with
  a textbook NumPy filter (`reference.py`) before it is timed: the largest difference relative to the largest
  value of that state component.
- Costs are per track and update. Libraries that loop in Python get 10 tracks, array libraries the batch they
  are fastest with (2,000 tracks), dynamax and jink all 10,000. New output arrays are part of the cost, but not
  what the operating system takes to find pages for them: memory once freed is kept (glibc's MALLOC_ settings,
  the same for all). A row without a target shows what a first call into fresh memory costs.
- Adaptive filters: 1,000 of the same tracks (axis by axis: the first axis; lee-2003's rules: all lengths × 20, for
  their 500 m sensor), states and log-likelihood out, against plain filters of as many modes in the same race;
  networks have random weights. The slowly changing level is described in `structure.py`.
- A live update of jink takes a time and a NumPy row, and its state is read as a NumPy array.
- Memory is the growth of the process's peak resident size during one call, plus the inputs, over inputs and
  outputs.
- Threads are timed by the wall clock; of 40 rounds the quicker half counts, the one other processes disturb less.
- Trackers of many targets get the same plots, the sensor's true figures and 60 s of processor time on each sky. What a
  library did in that time is compared with jink on the same scans. Positions are compared by GOSPA.
- The Doppler radar of the Optimized Kalman Filter is simulated anew by its published settings; see `doppler.py`. Errors
  count from the third scan on; standard errors are paired by target. OKF's time per update is the package's own.
- Trainings run alone on all cores, the quickest of three rounds; what counts is processor time, which other work on the
  machine does not add to and the wall clock on two idle cores does not exceed.
- Ratios are of calls side by side in one process on one core, with memory as the system gives it; the stages of
  `jink track` are those that `--timings` says, of the example's flights eight times over.
- Start-up and `jink track` are whole processes by the wall clock; `track` has all cores.\
""".splitlines()
