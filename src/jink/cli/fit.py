"""`jink fit`: check what was asked, fit, check on held-out data, write filter and page; nothing is written on an error."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from .exit_status import PACKAGES, exit_status


@dataclass(frozen=True)
class FitRequest:
    """What the command line asked for, as it came."""

    data: str
    output: str | None = None
    filter: str | None = None
    search: bool = False
    objective: str | None = None
    truth: str | None = None
    ahead: int = 1
    free: Sequence[str] = ()
    fix: Sequence[str] = ()
    runs: int = 200
    check_runs: int = 500
    seed: int = 0
    starts: int = 3
    minutes: float | None = None
    kind: str = "aircraft"
    columns: Sequence[str] = ()
    checkpoint: str | None = None
    resume: bool = False
    report: str | None = None
    json: bool = False
    quiet: bool = False


def run_fit(request: FitRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    Interrupted, the best parameters so far are checked and written, marked partial.
    """
    return exit_status(
        lambda: _run(request), packages=(*PACKAGES, "scipy", "cma"), extra="fit",
        interrupted="interrupted before there was anything to keep",
    )  # fmt: skip


def _run(request: FitRequest) -> int:
    output, report = checked_outputs(request.output, request.report, request.data)
    options = _options(request)
    if request.search:
        return _search(request, options, output, report)
    from ..fit import fit as fit_one

    checkpoint = request.checkpoint or (f"{request.output}.checkpoint" if request.output else None)
    fit = fit_one(
        request.data, request.filter or "imm", free=_names(request.free), fixed=_names(request.fix), minutes=request.minutes,
        checkpoint=checkpoint, resume=request.resume, starts=request.starts, progress=_progress(request), **options,
    )  # fmt: skip
    _clear(request)
    if checkpoint and not fit.partial and not request.checkpoint:
        Path(checkpoint).unlink(missing_ok=True)
    if output:
        fit.save(output)
    if report:
        from ..report.fit_page import write_fit_report

        write_fit_report(fit, report)
    if request.json:
        sys.stdout.write(json.dumps(fit.as_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    elif not request.quiet:
        from ..report.fit_table import show

        show(fit)
        _say_where(output, report)
    return 130 if fit.interrupted else 0


def _say_where(output: Path | None, report: Path | None) -> None:
    """Where the filter and the page are, and what the filter is for."""
    if output:
        sys.stdout.write(f"\nfilter in {output}: jink track FILE --filter {output}\n")
    if report:
        sys.stdout.write(f"page in {report}\n")


def _search(request: FitRequest, options: dict[str, Any], output: Path | None, report: Path | None) -> int:
    """Candidates fitted in parallel; what is written is the best one."""
    from ..checks import thread_count
    from ..fit.fitting import chosen_objective, training_data
    from ..fit.search import search

    for option, given in {"--checkpoint": request.checkpoint, "--resume": request.resume}.items():
        if given:
            raise InputError(f"{option}: a search begins anew; limit it with --minutes")
    objective, ahead = options.pop("objective"), options.pop("ahead")
    training = training_data(request.data, **options)
    found = search(
        training, chosen_objective(objective, training, ahead), names=_names([request.filter or ""]), minutes=request.minutes,
        workers=thread_count(None), seed=request.seed, free=_names(request.free), fixed=_names(request.fix),
        progress=_progress(request, "{stage} of {stages} fitted; under way: {words}"),
    )  # fmt: skip
    _clear(request)
    if output:
        found.fit.save(output)
    if report:
        from ..report.fit_page import write_fit_report

        write_fit_report(found.fit, report, found)
    if request.json:
        sys.stdout.write(json.dumps(found.as_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    elif not request.quiet:
        from ..report.search_table import show

        show(found)
    return 130 if found.interrupted else 0


def _options(request: FitRequest) -> dict[str, Any]:
    from .track import parse_columns

    checks = {"--runs": request.runs, "--check-runs": request.check_runs, "--starts": request.starts}
    for option, value in checks.items():
        if value < 1:
            raise InputError(f"{option} is {value}; expected at least 1")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    if request.minutes is not None and not request.minutes > 0:
        raise InputError(f"--minutes is {request.minutes}; expected more than 0")
    return {
        "objective": request.objective,
        "truth": request.truth,
        "ahead": request.ahead,
        "runs": request.runs,
        "check_runs": request.check_runs,
        "seed": request.seed,
        "kind": request.kind,
        "columns": parse_columns(list(request.columns)) or None,
    }


def checked_outputs(filter: str | None, page: str | None, data: str) -> tuple[Path | None, Path | None]:
    """Where filter and page go, checked before the work. Errors: InputError."""
    output = Path(filter) if filter else None
    report = Path(page) if page else None
    if output is not None and output.suffix != ".json":
        raise InputError(f"-o {output}: a filter is written as .json")
    for path in (each for each in (output, report) if each is not None):
        if path.is_dir() or not path.parent.is_dir():
            raise InputError(f"{path}: expected a file in a folder that exists")
        if path.exists() and Path(data).exists() and path.samefile(data):
            raise InputError(f"{path} is the input; the output needs another name")
    return output, report


def _clear(request: FitRequest) -> None:
    """Take the line of progress away."""
    if _progress(request):
        sys.stderr.write("\r\033[K")
        sys.stderr.flush()


def _names(given: Sequence[str]) -> list[str]:
    return [name.strip() for item in given for name in item.split(",") if name.strip()]


def _progress(request: FitRequest, form: str = "{words} (batch {begun} of {stages})") -> Any:
    if request.quiet or request.json or not sys.stderr.isatty():
        return None

    def say(words: str, stage: int, stages: int) -> None:
        said = form.format(words=words, stage=stage, begun=stage + 1, stages=stages) if stages else words
        sys.stderr.write(f"\r\033[K{said}")
        sys.stderr.flush()

    return say
