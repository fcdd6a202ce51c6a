"""`jink compare`: check what was asked, race, print the table or write it as JSON; nothing is written on an error."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from ..scenarios.observation import Seeing
from .exit_status import exit_status


@dataclass(frozen=True)
class CompareRequest:
    """What the command line asked for, as it came."""

    scenario: str
    filters: str
    runs: int
    seed: int
    json: str | None = None
    report: str | None = None
    seeing: Seeing = field(default_factory=Seeing)
    kind: str = "aircraft"
    columns: Sequence[str] = ()
    quiet: bool = False


def run_compare(request: CompareRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    Interrupted with some runs finished, these are reported and marked partial.
    """
    return exit_status(lambda: _run(request), interrupted="interrupted before any run was finished")


def _run(request: CompareRequest) -> int:
    from ..compare.race import compare
    from .track import parse_columns

    if request.runs < 1:
        raise InputError(f"--runs is {request.runs}; expected at least 1")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    output, report = _output(request, "--json", request.json), _output(request, "--report", request.report)
    if output is not None and report is not None and output.absolute() == report.absolute():
        raise InputError(f"--json and --report are both {output}; expected two names")
    names = [name.strip() for name in request.filters.split(",") if name.strip()]
    race = compare(
        _scenario(request),
        names,
        request.runs,
        request.seed,
        kind=request.kind,
        columns=parse_columns(list(request.columns)) or None,
        progress=_progress(request),
    )
    _write(race, request, output, report)
    if not request.quiet and request.json != "-":
        from ..report.race_table import show

        show(race)
    return 130 if race.partial else 0


def _scenario(request: CompareRequest) -> Any:
    """The name or file, or the scenario seen otherwise where that is asked; recorded tracks are then the truth."""
    if not request.seeing.asked:
        return request.scenario
    from .simulate import choose

    if Path(request.scenario).is_file():
        from ..compare.truth_file import has_truth

        if has_truth(request.scenario):
            raise InputError(
                f"{request.scenario} holds simulated measurements; sensor options are for a scenario "
                "or for recorded positions"
            )
    return choose(request.scenario, request.kind, request.seeing)


def _output(request: CompareRequest, option: str, given: str | None) -> Path | None:
    """Where JSON or page go, checked before the work; Path("-") is standard output."""
    if given is None:
        return None
    path = Path(given)
    if given == "-":
        if option == "--report":
            raise InputError("--report -: expected a file")
        return path
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"{option} {path}: expected a file in a folder that exists")
    if path.exists() and Path(request.scenario).exists() and path.samefile(request.scenario):
        raise InputError(f"{path} is the input; the output needs another name")
    if {path.name, str(path)} & set(request.filters.split(",")):
        raise InputError(f"{path} is one of the filters; the output needs another name")
    return path


def _write(race: Any, request: CompareRequest, output: Path | None, report: Path | None) -> None:
    """JSON and page, both or none: written under other names first, then renamed."""
    from ..io.writing import atomically

    text = json.dumps(race.as_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    wanted = [path for path in (output, report) if path is not None and str(path) != "-"]
    with atomically(*wanted) as temporary:
        for path, name in zip(wanted, temporary, strict=True):
            if path is output:
                name.write_text(text, encoding="utf-8")
            else:
                from ..report.race_page import write_race_report

                write_race_report(race, name, command=command_line(request))
    if str(output) == "-":
        sys.stdout.write(text)


def command_line(request: CompareRequest) -> str:
    """The command that does it again, files by the names they were given."""
    seeing = {name: value for name, value in vars(request.seeing).items() if value is not None}
    asked: dict[str, Any] = {"filters": request.filters, "runs": request.runs, "seed": request.seed, **seeing}
    if request.kind != "aircraft":
        asked["kind"] = request.kind
    words = ["jink", "compare", request.scenario]
    words += [part for name, value in asked.items() if value != "" for part in (f"--{name}", str(value))]
    words += [part for given in request.columns for part in ("--columns", given)]
    return shlex.join(words)


def _progress(request: CompareRequest) -> Any:
    if request.quiet or not sys.stderr.isatty():
        return None

    def say(done: int, asked: int) -> None:
        sys.stderr.write(f"\r{done:,} of {asked:,}" + ("\r\033[K" if done >= asked else ""))
        sys.stderr.flush()

    return say
