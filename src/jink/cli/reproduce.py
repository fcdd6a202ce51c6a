"""`jink reproduce`: check what was asked, measure, print tables, write JSON and a page; nothing is written on an error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from .exit_status import exit_status


@dataclass(frozen=True)
class ReproduceRequest:
    """What the command line asked for, as it came."""

    paper: str
    runs: int | None = None
    seed: int = 0
    json: str | None = None
    report: str | None = None
    quick: bool = False
    retrain: bool = False
    quiet: bool = False


def run_reproduce(request: ReproduceRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    Interrupted with some runs finished, these are reported and marked partial.
    """
    return exit_status(lambda: _run(request), interrupted="interrupted before any run was finished")


def _run(request: ReproduceRequest) -> int:
    from ..checks import unknown
    from ..papers import PAPERS, run
    from ..papers.learned import retrained, shipped

    if request.paper not in (*PAPERS, "all"):
        raise InputError(unknown("paper", request.paper, [*PAPERS, "all"]))
    if request.runs is not None and request.runs < 2:
        raise InputError(f"--runs is {request.runs}; expected at least 2, one has no standard error")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    files = [
        _output(option, value) for option, value in (("--json", request.json), ("--report", request.report))
    ]
    outcomes = []
    models = retrained(request.quick) if request.retrain else shipped
    for name in PAPERS if request.paper == "all" else [request.paper]:
        with _progress(request, name) as progress:
            outcome = run(
                PAPERS[name],
                request.runs,
                request.seed,
                quick=request.quick,
                models=models,
                progress=progress,
            )
        outcomes.append(outcome)
        if not request.quiet and request.json != "-":
            from ..report.papers_table import show

            show(outcome)
        if outcome.partial:
            break
    bodies = [outcome.as_dict() for outcome in outcomes]
    if files[0] is not None:
        _write({"papers": bodies} if request.paper == "all" else bodies[0], files[0])
    if files[1] is not None:
        from ..report.reproduce_page import write

        write(outcomes, files[1])
    return 130 if outcomes[-1].partial else 0


def _output(option: str, value: str | None) -> Path | None:
    """Where a file goes, checked before the work; Path("-") is standard output."""
    if value is None:
        return None
    path = Path(value)
    if value == "-" and option == "--json":
        return path
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"{option} {path}: expected a file in a folder that exists")
    return path


def _write(body: dict[str, Any], path: Path) -> None:
    text = json.dumps(body, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
        return
    from ..io.writing import atomically

    with atomically(path) as (temporary,):
        temporary.write_text(text, encoding="utf-8")


@contextmanager
def _progress(request: ReproduceRequest, paper: str) -> Iterator[Callable[[str, int, int], None] | None]:
    if request.quiet or not sys.stderr.isatty():
        yield None
        return

    def say(experiment: str, done: int, asked: int) -> None:
        sys.stderr.write(f"\r\033[K{paper}, {experiment}: {done:,} of {asked:,} runs")
        sys.stderr.flush()

    yield say
    sys.stderr.write("\r\033[K")
