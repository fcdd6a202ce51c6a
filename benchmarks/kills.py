"""Commands that are killed at random moments: no torn output, no input changed, nothing left after the next run.

    python -m benchmarks.kills        50 moments of each command
    python -m benchmarks.kills 5      as many of each

Each command runs once to its end, to know how long that takes; then it is killed (SIGKILL) at random moments of it.
Runs that end before their moment do not count as kills, and say how long a run takes now.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import polars as pl

from jink.filters.loading import read
from jink.io.temporary import PREFIX

LATE = 1.1  # of the time of a whole run: some kills come too late


@dataclass(frozen=True)
class Command:
    """What follows `jink`, and the files that it may write beside those of `inputs`."""

    line: str
    outputs: tuple[str, ...]
    kept: tuple[str, ...] = ()  # checkpoints, which a killed run leaves for --resume

    @property
    def words(self) -> list[str]:
        """What follows `jink`."""
        return self.line.split()


COMMANDS = {
    "track": Command(
        "track plots.parquet -o t.parquet --report t.html -q",
        ("t.parquet", "t.html", "t.rejected.parquet"),
    ),
    "track, share by share": Command(
        "track large.parquet -o l.csv.gz --memory 600MB -q", ("l.csv.gz", "l.rejected.parquet")
    ),
    "fit": Command(
        "fit plots.parquet --starts 1 --minutes 0.03 -o f.json --report f.html -q",
        ("f.json", "f.html"),
        ("f.checkpoint", "f.json.checkpoint"),
    ),
    "fit --search": Command("fit plots.parquet --search --minutes 0.05 -o s.json -q", ("s.json",)),
    "learn": Command(
        "learn nn-kf random-turns --runs 4 --check-runs 4 --epochs 3 -o n.json --report n.html -q",
        ("n.json", "n.html"),
    ),
    "compare --report": Command(
        "compare lee-2003 --runs 40 --json c.json --report c.html -q",
        ("c.json", "c.html"),
    ),
}


@dataclass
class Counts:
    """What was found in all kills of a command."""

    killed: int = 0
    ended: int = 0
    torn: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    orphans: int = 0

    @property
    def faults(self) -> int:
        """How many of all kinds."""
        return len(self.torn) + len(self.changed) + len(self.unknown) + len(self.left) + self.orphans


def make_inputs(folder: Path, large: int = 200_000) -> None:
    """Turning targets, some rows of which are in no track; and a table that is larger than 600 MB takes."""
    rng, t = np.random.default_rng(0), np.arange(300.0)
    tables = []
    for number in range(30):
        course = np.cumsum(np.repeat(rng.choice([0.0, 0.03, -0.03], 6), 50))
        x, y = np.cumsum(200.0 * np.array([np.sin(course), np.cos(course)]), axis=1) + rng.normal(0, 20.0, (2, 300))
        tables.append(pl.DataFrame({"target": f"t{number}", "time": t, "x": x, "y": y}))
    table = pl.concat(tables)
    pl.concat([table, table[:5]]).write_parquet(folder / "plots.parquet")
    copies = [table.with_columns(pl.col("target") + f"-{k}") for k in range(large // table.height)]
    if copies:
        pl.concat(copies).write_parquet(folder / "large.parquet")


def whole(path: Path) -> bool:
    """Whether a file can be read to its end."""
    try:
        if path.name.endswith(".parquet"):
            return pl.read_parquet(path).width > 0
        if path.name.endswith(".csv.gz"):
            return pl.read_csv(path, infer_schema=False).width > 10
        text = path.read_text(encoding="utf-8")
        if path.name.endswith(".html"):
            return text.rstrip().endswith("</html>")
        body = json.loads(text)
        if body.get("jink") == "filter":
            read(text, path.name)
        return True
    except (OSError, ValueError, pl.exceptions.PolarsError):
        return False


def digests(folder: Path, names: list[str]) -> dict[str, str]:
    """What the files hold."""
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


def start(folder: Path, words: Sequence[str]) -> subprocess.Popen[bytes]:
    """The command in a session of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "jink", *words],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def alive(session: int) -> list[int]:
    """Processes of a session that still run."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.getsid(int(entry.name)) == session and "\nState:\tZ" not in (entry / "status").read_text():
                    found.append(int(entry.name))
            except OSError:
                continue
    return found


def left_behind(folder: Path) -> list[str]:
    """Temporary files and folders."""
    return sorted(entry.name for entry in folder.iterdir() if entry.name.startswith(PREFIX))


def killed_at(folder: Path, command: Command, seconds: float, counts: Counts, patience: float = 5.0) -> None:
    """Kill one run, then look at what is there."""
    inputs = [name for name in ("plots.parquet", "large.parquet") if (folder / name).exists()]
    before = digests(folder, inputs)
    for name in command.outputs + command.kept:
        (folder / name).unlink(missing_ok=True)
    process = start(folder, command.words)
    try:
        process.wait(seconds)
        counts.ended += 1
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
        counts.killed += 1
    after = {entry.name for entry in folder.iterdir()}
    counts.torn += [name for name in command.outputs if name in after and not whole(folder / name)]
    known = {*inputs, *command.outputs, *command.kept}
    counts.unknown += [name for name in after - known if not name.startswith(PREFIX)]
    counts.changed += [name for name, digest in digests(folder, inputs).items() if digest != before[name]]
    deadline = time.monotonic() + patience
    while (others := alive(process.pid)) and time.monotonic() < deadline:
        time.sleep(0.1)
    counts.orphans += len(others)
    for other in others:
        os.kill(other, signal.SIGKILL)


def tried(folder: Path, command: Command, kills: int, seed: int) -> tuple[Counts, float]:
    """All kills of a command, and a run to its end that takes away what they left."""
    counts, rng = Counts(), random.Random(seed)
    began = time.monotonic()
    if start(folder, command.words).wait() != 0:
        raise SystemExit(f"jink {' '.join(command.words)} fails")
    seconds = time.monotonic() - began
    lasts = seconds
    while counts.killed < kills and counts.ended < kills:
        began, before = time.monotonic(), counts.ended
        killed_at(folder, command, rng.uniform(0.1, LATE) * lasts, counts)
        if counts.ended > before:  # the machine is faster now than it was
            lasts = min(lasts, time.monotonic() - began)
    if start(folder, command.words).wait() != 0 or not all(
        whole(folder / name) for name in command.outputs if (folder / name).exists()
    ):
        counts.torn.append("the run after")
    counts.left += left_behind(folder)
    for name in command.outputs + command.kept:
        (folder / name).unlink(missing_ok=True)
    return counts, seconds


def main() -> None:
    """One line for each command; the exit status is 1 where a fault was found."""
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    chosen = sys.argv[2:] or list(COMMANDS)
    faults = 0
    with tempfile.TemporaryDirectory() as name:
        make_inputs(Path(name))
        for seed, what in enumerate(chosen):
            counts, seconds = tried(Path(name), COMMANDS[what], kills, seed)
            faults += counts.faults
            print(
                f"{what:>22}: {seconds:5.1f} s, {counts.killed} killed, {counts.ended} had ended; "
                f"torn {counts.torn or 0}, inputs changed {counts.changed or 0}, unknown files {counts.unknown or 0}, "
                f"left after the next run {counts.left or 0}, processes left {counts.orphans}",
                flush=True,
            )
    sys.exit(faults > 0)


if __name__ == "__main__":
    main()
