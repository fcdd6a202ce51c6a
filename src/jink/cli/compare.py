"""`jink compare`: check the request, race the filters, print tables, write JSON and a page; an error writes nothing."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import exit_status
from .request import (
    Columns,
    JsonFile,
    Quiet,
    RecordedKind,
    Runs,
    Seed,
    SensorOptions,
    check_at_least,
    check_kind,
    check_seed,
    completed_from,
    json_text,
    output_path,
    parse_columns,
    progress_line,
    words_of,
)


@frozen(kw_only=True)
class CompareRequest(SensorOptions):
    """Compare filters fairly: the same random numbers for all, standard errors, no verdict without an interval.

    Raw measurements, tuned Kalman filters, the default IMM and the clairvoyant bound always take part.
    """

    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|FILE",
            show_default=False,
            help="A scenario (a wrong name lists all), a file from jink simulate, or a file of recorded positions. "
            "Without truth, filters are scored on predictions. With sensor options, smoothed tracks are the truth.",
            autocompletion=completed_from("scenarios"),
        ),
    ]
    filters: Annotated[
        str,
        typer.Option(
            metavar="A,B,C.json",
            help="More filters to compare: names (a wrong one lists all), the word all, files written by save(), or "
            "yours as my.py:name.",
            autocompletion=completed_from("filters", also=("all",)),
        ),
    ] = ""
    association: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            help="On a whole sky, such as sky-regional: how plots are given to tracks, {associations}.",
            autocompletion=completed_from("associations"),
        ),
    ] = ""
    runs: Runs = 1000
    seed: Seed = 0
    lag: Annotated[
        str | None,
        typer.Option(
            metavar="N|TIME",
            help="Every filter takes part once more, with what is measured so many scans (2) or seconds (8s) later.",
        ),
    ] = None
    json: JsonFile = None
    report: Annotated[str | None, typer.Option(metavar="FILE", help="Write one HTML page with tables and charts.")] = (
        None
    )
    kind: RecordedKind = "aircraft"
    columns: Columns = None
    quiet: Quiet = False


def run_compare(request: CompareRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    After an interrupt the runs that are finished are reported and marked partial.
    """
    return exit_status(lambda: _run(request), interrupted="interrupted before any run was finished")


def _run(request: CompareRequest) -> int:
    from ..compare.race import compare

    check_at_least(1, runs=request.runs)
    check_seed(request.seed)
    check_kind(request.kind)
    output, report = _output(request, "--json", request.json), _output(request, "--report", request.report)
    if output is not None and report is not None and output.absolute() == report.absolute():
        raise InputError(f"--json and --report are both {output}; expected two names")
    if request.scenario.startswith("sky-") and not Path(request.scenario).exists():
        return _run_sky(request, output, report)
    if request.association:
        raise InputError("--association needs a whole sky, such as sky-regional")
    with progress_line(not request.quiet) as say:
        race = compare(
            _scenario(request),
            [name.strip() for name in request.filters.split(",") if name.strip()],
            request.runs,
            request.seed,
            kind=request.kind,
            columns=parse_columns(request.columns) or None,
            progress=say and (lambda done, asked: say(f"{done:,} of {asked:,}")),
            lag=request.lag,
        )
    _write(race, request, output, report)
    if not request.quiet and request.json != "-":
        from ..report.race_table import show

        show(race)
    return 130 if race.partial else 0


def _run_sky(request: CompareRequest, output: Path | None, report: Path | None) -> int:
    """Filters and associations on plots without identity."""
    from ..compare.sky_race import race_on_sky

    if request.sensor_options or request.columns or request.lag:
        options = "--columns, --lag and sensor options"
        raise InputError(f"{request.scenario} is a whole sky: {options} do not apply")
    with progress_line(not request.quiet) as say:
        race = race_on_sky(
            request.scenario,
            words_of([request.filters]) or ["imm"],
            words_of([request.association]) or ["marginal"],
            request.runs,
            request.seed,
            kind=request.kind,
            example=report is not None,
            progress=say and (lambda done, asked: say(f"{done:,} of {asked:,}")),
        )
    _write(race, request, output, report)
    if str(output) != "-" and not request.quiet:
        from ..report.sky_table import show

        show(race)
    return 0


def _scenario(request: CompareRequest) -> Any:
    """The name or file; with sensor options the scenario measured so, recorded tracks being its truth."""
    if not request.sensor_options:
        return request.scenario
    if Path(request.scenario).is_file():
        from ..compare.truth_file import has_truth

        if has_truth(request.scenario):
            raise InputError(
                f"{request.scenario} holds simulated measurements; sensor options need a scenario or recorded positions"
            )
    return request.scenario_called(request.scenario, request.kind)


def _output(request: CompareRequest, option: str, given: str | None) -> Path | None:
    """Where JSON or page go, checked before the work begins."""
    path = output_path(option, given, stdout=option == "--json", data=request.scenario)
    if path is not None and {path.name, str(path)} & set(request.filters.split(",")):
        raise InputError(f"{path} is one of the filters; the output needs another name")
    return path


def _write(race: Any, request: CompareRequest, output: Path | None, report: Path | None) -> None:
    """Write JSON and page, both or none: under other names first, then renamed."""
    from ..io.writing import atomically

    text = json_text(race.as_dict())
    wanted = [path for path in (output, report) if path is not None and str(path) != "-"]
    with atomically(*wanted) as temporary:
        for path, name in zip(wanted, temporary, strict=True):
            if path is output:
                name.write_text(text, encoding="utf-8")
            else:
                _write_page(race, name, command_line(request))
    if str(output) == "-":
        sys.stdout.write(text)


def _write_page(race: Any, path: Path, command: str) -> None:
    from ..compare.sky_race import SkyRace

    if isinstance(race, SkyRace):
        from ..report.sky_page import write_sky_page

        write_sky_page(race, path, command=command)
        return
    from ..report.race_page import write_race_report

    write_race_report(race, path, command=command)


def command_line(request: CompareRequest) -> str:
    """The command that does it again; files have the names they were given."""
    asked: dict[str, Any] = {"filters": request.filters, "runs": request.runs, "seed": request.seed}
    asked |= {"association": request.association, **request.sensor_options}
    if request.kind != "aircraft":
        asked["kind"] = request.kind
    words = ["jink", "compare", request.scenario]
    words += [part for name, value in asked.items() if value != "" for part in (f"--{name}", str(value))]
    words += [part for given in request.columns or () for part in ("--columns", given)]
    return shlex.join(words)
