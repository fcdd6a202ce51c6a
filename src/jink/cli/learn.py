"""`jink learn`: check what was asked, learn, check on held-out data, write filter and page; nothing is written on an error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from ..learn.recipes import OPTIMISERS, SEARCHED
from .exit_status import PACKAGES, exit_status, failed


@dataclass(frozen=True)
class LearnRequest:
    """What the command line asked for, as it came."""

    name: str
    data: str
    output: str | None = None
    truth: str | None = None
    columns: Sequence[str] = ()
    kind: str | None = None
    runs: int = 200
    check_runs: int = 500
    seed: int = 0
    acceleration: float | None = None
    optimiser: str | None = None
    generations: int | None = None
    population: int | None = None
    rules: int | None = None
    weight: float | None = None
    inputs: str | None = None
    base: str | None = None
    epochs: int | None = None
    labels: bool = False
    checkpoint: str | None = None
    resume: bool = False
    report: str | None = None
    json: bool = False
    quiet: bool = False


def run_learn(request: LearnRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    Interrupted, a search by populations is kept in its checkpoint, which --resume takes up.
    """
    return exit_status(
        lambda: _run(request), packages=(*PACKAGES, "scipy", "cma", "pymoo", "autograd"), extra="learn,track"
    )


def _run(request: LearnRequest) -> int:
    from .fit import checked_outputs
    from .track import parse_columns

    output, report = checked_outputs(request.output, request.report, request.data)
    how = _how(request)
    kept = _kept(request)
    if kept and not request.resume:
        for file in _files(kept):
            file.unlink()
    from ..learn.learning import learn

    try:
        with _Progress(request) as progress:
            learned = learn(
                request.name, request.data, truth=request.truth, columns=parse_columns(list(request.columns)) or None,
                kind=request.kind, runs=request.runs, check_runs=request.check_runs, seed=request.seed, base=request.base,
                checkpoint=kept, progress=progress, **how,
            )  # fmt: skip
    except KeyboardInterrupt:
        return failed(
            "interrupted" + ("; --resume goes on from the checkpoint" if kept and _files(kept) else ""), 130
        )
    if output:
        learned.save(output)
    if report:
        from ..report.learn_page import write_learn_report

        write_learn_report(learned, report)
    if kept and not request.checkpoint:
        for file in _files(kept):
            file.unlink()
    if request.json:
        sys.stdout.write(json.dumps(learned.as_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    elif not request.quiet:
        from ..report.learn_table import show

        show(learned)
    return 0


def _how(request: LearnRequest) -> dict[str, Any]:
    """What was asked of the recipe, checked as far as that needs no data."""
    searched = request.name in SEARCHED
    for option, value in (
        ("--optimizer", request.optimiser), ("--generations", request.generations), ("--population", request.population),
        ("--rules", request.rules), ("--weight", request.weight), ("--checkpoint", request.checkpoint),
    ):  # fmt: skip
        if value is not None and not searched:
            raise InputError(
                f"{option}: is of searches for rules ({', '.join(SEARCHED)}), not of {request.name}"
            )
    if request.resume and not searched:
        raise InputError(
            f"--resume: {request.name} is learned in one go; only searches for rules are taken up again"
        )
    if request.resume and not (request.checkpoint or request.output):
        raise InputError("--resume: needs the checkpoint to take up (--checkpoint, or -o beside which it is)")
    for option, value in (("--epochs", request.epochs), ("--labels", request.labels or None)):
        if value is not None and searched:
            raise InputError(f"{option}: is of networks, not of {request.name}")
    if request.base is not None and request.name not in ("anfis-kf", "nn-kf"):
        raise InputError(f"--base: is the filter that anfis-kf and nn-kf aid, not of {request.name}")
    if request.labels and request.name not in ("nnvsmm", "nnvsmm-modes"):
        raise InputError(f"--labels: is of nnvsmm and nnvsmm-modes, not of {request.name}")
    for option, number in (
        ("--runs", request.runs), ("--check-runs", request.check_runs), ("--generations", request.generations),
        ("--population", request.population), ("--rules", request.rules), ("--epochs", request.epochs),
    ):  # fmt: skip
        if number is not None and number < 1:
            raise InputError(f"{option} is {number}; expected at least 1")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    if request.optimiser is not None and request.optimiser not in OPTIMISERS:
        raise InputError(f"--optimizer is {request.optimiser!r}; expected one of {', '.join(OPTIMISERS)}")
    if request.acceleration is not None and not request.acceleration > 0:
        raise InputError(f"--acceleration is {request.acceleration:g}; expected more than 0 m/s²")
    if request.weight is not None and not 0 <= request.weight <= 1:
        raise InputError(f"--weight is {request.weight:g}; expected 0 to 1")
    given = {
        "acceleration": request.acceleration, "optimiser": request.optimiser, "generations": request.generations,
        "population": request.population, "rules": request.rules, "weight": request.weight,
        "inputs": _numbers(request.inputs), "epochs": request.epochs, "labels": request.labels or None,
    }  # fmt: skip
    return {name: value for name, value in given.items() if value is not None}


def _numbers(text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    try:
        values = tuple(float(each) for each in text.split(","))
    except ValueError:
        values = ()
    if not values or not all(0 < value < float("inf") for value in values):
        raise InputError(f"--inputs is {text!r}; expected accelerations in m/s², for example 1,10,100")
    return values


def _kept(request: LearnRequest) -> str | None:
    """Where a search keeps its place, one file per sub-model."""
    if request.name not in SEARCHED:
        return None
    return request.checkpoint or (f"{request.output}.checkpoint" if request.output else None)


def _files(kept: str) -> list[Path]:
    path = Path(kept)
    return sorted(file for file in path.parent.glob("*.npz") if file.name.startswith(f"{path.name}."))


class _Progress:
    """A bar with what is best so far, on a terminal that nobody silenced; else nothing."""

    def __init__(self, request: LearnRequest) -> None:
        self.wanted = not (request.quiet or request.json) and sys.stderr.isatty()

    def __enter__(self) -> Callable[[str, int, int], None] | None:
        if not self.wanted:
            return None
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        self.bar = Progress(
            BarColumn(20), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn(),
            console=Console(stderr=True), transient=True,
        )  # fmt: skip
        self.bar.start()
        task = self.bar.add_task("", total=None)
        return lambda words, done, of: self.bar.update(task, description=words, completed=done, total=of)

    def __exit__(self, *error: object) -> None:
        if self.wanted:
            self.bar.stop()
