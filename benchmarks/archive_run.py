"""A run of `jink track FILES -o FOLDER/` by itself: its time, and the peak memory of each of its processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def command(files: Sequence[Path], output: Path, *more: str) -> list[str]:
    names = [str(path) for path in files]
    return [sys.executable, "-m", "jink", "track", *names, "-o", f"{output}/", "--memory", "2GB", "--json", *more]


class Watched:
    """Peak resident memory (bytes) of a process and of each of its children, sampled."""

    def __init__(self, pid: int):
        self.pid, self.peaks, self.over = pid, {}, threading.Event()
        self.thread = threading.Thread(target=self._watch, daemon=True)
        self.thread.start()

    def _watch(self) -> None:
        while not self.over.wait(0.05):
            for pid in (self.pid, *_children(self.pid)):
                try:
                    lines = Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines()
                except OSError:
                    continue
                found = next((int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM")), 0)
                self.peaks[pid] = max(self.peaks.get(pid, 0), found)


def _children(pid: int) -> list[int]:
    try:
        return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]
    except OSError:
        return []


def tracked(files: Sequence[Path], output: Path, *more: str) -> dict[str, Any]:
    """Wall and processor seconds of a run, of its first stage too, and the peaks of its processes."""
    before = os.times()
    began = time.perf_counter()
    words = command(files, output, *more)
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    watched = Watched(process.pid)
    assert process.stdout is not None and process.stderr is not None
    stages: dict[str, float] = {}
    mapped = 0.0
    for line in process.stderr:
        event = json.loads(line)
        stages[event["event"]] = time.perf_counter() - began
        if event["event"] == "map":
            mapped = _cpu(process.pid)
    summary = json.load(process.stdout)
    process.wait()
    watched.over.set()
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    peaks = sorted(watched.peaks.values())[-3:]
    wall = time.perf_counter() - began
    return {"wall": wall, "cpu": cpu, "map_cpu": mapped, "stages": stages, "peaks": peaks, "rows": summary["rows"]}


def _cpu(pid: int) -> float:
    """Processor seconds of a process and of its children until now."""
    total = 0.0
    for each in (pid, *_children(pid)):
        try:
            words = Path(f"/proc/{each}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        except OSError:
            continue
        total += (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    return total
