"""`jink fit`: check the request, fit, check on held-out data, write filter and page; an error writes nothing."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import PACKAGES, exit_status
from .request import (
    FLAG,
    CheckRuns,
    Columns,
    Json,
    Quiet,
    RecordedKind,
    Seed,
    check_at_least,
    check_kind,
    check_seed,
    completed_from,
    filter_path,
    json_text,
    output_path,
    parse_columns,
    progress_line,
    say,
    words_of,
)


@frozen(kw_only=True)
class FitRequest:
    """Fit a filter's parameters to your own targets and check the result on data it has not seen.

    The targets need no known truth. Ctrl-C keeps the best parameters found so far.
    """

    data: Annotated[
        str,
        typer.Argument(
            metavar="FILE|SCENARIO",
            show_default=False,
            help="A file of recorded positions, or one or several scenarios (with commas).",
            autocompletion=completed_from("scenarios"),
        ),
    ]
    filter: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="The filter to fit: a name (a wrong one lists all), a file written by save(), or yours as my.py:name. "
            "Default: imm. "
            "With --search: the candidates, with commas, yours as my.py:name among them. Default: all.",
            autocompletion=completed_from("filters"),
        ),
    ] = None
    search: Annotated[
        bool,
        typer.Option(
            "--search",
            help="Find the filter that fits best: fit filters of 1 to 3 modes in parallel, rank them on held-out data.",
            **FLAG,
        ),
    ] = False
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE", help="Write the filter as .json, for jink track --filter."),
    ] = None
    objective: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What is made best: {objectives}. Default: tracking if the truth is known, else likelihood.",
            autocompletion=completed_from("objectives"),
        ),
    ] = None
    truth: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMNS",
            help="The file's columns of truth: px=true_x,vx=… The word true stands for those of jink simulate.",
        ),
    ] = None
    ahead: Annotated[int, typer.Option(metavar="SCANS", help="How far ahead the objective prediction looks.")] = 1
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN", help="Fit these parameters too, for example 'sensor.*' (a wrong one lists all)."
        ),
    ] = None
    fix: Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave these parameters as they are.")] = None
    minutes: Annotated[
        float | None, typer.Option(metavar="M", help="Stop after this time and keep the best found so far.")
    ] = None
    runs: Annotated[int, typer.Option(metavar="N", help="Number of runs of a scenario to fit on.")] = 200
    check_runs: CheckRuns = 500
    seed: Seed = 0
    starts: Annotated[int, typer.Option(metavar="N", help="Number of points the optimisation starts from.")] = 3
    kind: RecordedKind = "aircraft"
    columns: Columns = None
    anonymous: Annotated[
        bool,
        typer.Option(
            "--anonymous",
            help="Plots of the file do not say whose they are: fit detection, false plots, new targets and noise. "
            "Default for a table without identity in which several rows share a time.",
            **FLAG,
        ),
    ] = False
    period: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Time of one scan, where plots without identity have times of their own."),
    ] = None
    checkpoint: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Keep the state of the fit here while it runs. Default: beside the output."),
    ] = None
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint.", **FLAG)] = False
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write one HTML page: held-out tracks before and after the fit.")
    ] = None
    json: Json = False
    quiet: Quiet = False


def run_fit(request: FitRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    After an interrupt the best parameters so far are checked, written and marked partial.
    """
    return exit_status(
        lambda: _run(request),
        packages=(*PACKAGES, "scipy", "cma"),
        extra="fit",
        interrupted="interrupted before there was anything to keep",
    )


def _run(request: FitRequest) -> int:
    output = filter_path(request.output, request.data)
    report = output_path("--report", request.report, data=request.data)
    options = _options(request)
    if request.anonymous or request.period is not None:
        return _sky(request, output)
    try:
        return _of_tracks(request, options, output, report)
    except InputError as error:
        from ..compare.recorded import WithoutIdentity

        if not isinstance(error, WithoutIdentity):
            raise
        return _sky(request, output)


def _of_tracks(request: FitRequest, options: dict[str, Any], output: Path | None, report: Path | None) -> int:
    """Of a scenario, or of rows that say whose they are."""
    if request.search:
        return _search(request, options, output, report)
    from ..fit import fit as fit_one

    checkpoint = request.checkpoint or (f"{request.output}.checkpoint" if request.output else None)
    with progress_line(not (request.quiet or request.json)) as say:
        fit = fit_one(
            request.data,
            request.filter or "imm",
            free=words_of(request.free),
            fixed=words_of(request.fix),
            minutes=request.minutes,
            checkpoint=checkpoint,
            resume=request.resume,
            starts=request.starts,
            progress=_progress(say, "{words} (batch {begun} of {stages})"),
            **options,
        )
    if checkpoint and not fit.partial and not request.checkpoint:
        Path(checkpoint).unlink(missing_ok=True)
    if output:
        fit.save(output)
    if report:
        from ..report.fit_page import write_fit_report

        write_fit_report(fit, report)
    if request.json:
        sys.stdout.write(json_text(fit.as_dict()))
    elif not request.quiet:
        from ..report.fit_table import show

        show(fit)
        _say_where(output, report)
    return 130 if fit.interrupted else 0


def _sky(request: FitRequest, output: Path | None) -> int:
    """Of plots without identity."""
    from ..fit.sky import fit_sky

    for option, given in {
        "--search": request.search,
        "--objective": request.objective not in (None, "likelihood"),
        "--truth": request.truth,
        "--report": request.report,
        "--checkpoint": request.checkpoint,
        "--resume": request.resume,
    }.items():
        if given:
            raise InputError(f"{option}: plots without identity are fitted by likelihood alone; leave it out")
    with progress_line(not (request.quiet or request.json)) as tell:
        fit = fit_sky(
            request.data,
            request.filter or "imm",
            free=words_of(request.free),
            fixed=words_of(request.fix),
            period=request.period,
            kind=request.kind,
            columns=parse_columns(request.columns) or None,
            minutes=request.minutes,
            progress=_progress(tell, "{words}"),
        )
    if output:
        fit.save(output)
    if request.json:
        sys.stdout.write(json_text(fit.as_dict()))
    elif not request.quiet:
        from ..report.sky_fit_table import show

        show(fit)
        say(f"\njink track FILE {'' if output is None else f'--filter {output} '}{fit.options()}\n")
    return 130 if fit.interrupted else 0


def _say_where(output: Path | None, report: Path | None) -> None:
    """Where the filter and the page are, and how the filter is used."""
    if output:
        say(f"\nfilter in {output}: jink track FILE --filter {output}\n")
    if report:
        say(f"page in {report}\n")


def _search(request: FitRequest, options: dict[str, Any], output: Path | None, report: Path | None) -> int:
    """Fit all candidates in parallel and write the best one."""
    from ..checks import thread_count
    from ..fit.fitting import chosen_objective, training_data
    from ..fit.search import search

    for option, given in {"--checkpoint": request.checkpoint, "--resume": request.resume}.items():
        if given:
            raise InputError(
                f"{option} cannot be used with --search, which always begins anew; use --minutes to limit it"
            )
    objective, ahead = options.pop("objective"), options.pop("ahead")
    training = training_data(request.data, **options)
    with progress_line(not (request.quiet or request.json)) as say:
        found = search(
            training,
            chosen_objective(objective, training, ahead),
            names=words_of([request.filter or ""]),
            minutes=request.minutes,
            workers=thread_count(None),
            seed=request.seed,
            free=words_of(request.free),
            fixed=words_of(request.fix),
            progress=_progress(say, "{stage} of {stages} fitted; under way: {words}"),
        )
    if output:
        found.fit.save(output)
    if report:
        from ..report.fit_page import write_fit_report

        write_fit_report(found.fit, report, found)
    if request.json:
        sys.stdout.write(json_text(found.as_dict()))
    elif not request.quiet:
        from ..report.search_table import show

        show(found)
        _say_where(output, report)
    return 130 if found.interrupted else 0


def _options(request: FitRequest) -> dict[str, Any]:
    """What a fit and a search are both told, checked."""
    check_at_least(1, runs=request.runs, check_runs=request.check_runs, starts=request.starts)
    check_seed(request.seed)
    check_kind(request.kind)
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
        "columns": parse_columns(request.columns) or None,
    }


def _progress(say: Callable[[str], None] | None, form: str) -> Callable[[str, int, int], None] | None:
    """Progress as a fit tells it, in words; the stages are unknown at first."""
    if say is None:
        return None

    def tell(words: str, stage: int, stages: int) -> None:
        say(form.format(words=words, stage=stage, begun=stage + 1, stages=stages) if stages else words)

    return tell
