"""`jink reproduce`: check the request, measure, print tables, write JSON and a page; an error writes nothing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import exit_status
from .request import (
    FLAG,
    JsonFile,
    Quiet,
    Seed,
    check_seed,
    completed_from,
    json_text,
    output_path,
    progress_line,
)


@frozen(kw_only=True)
class ReproduceRequest:
    """Measure the figures of a paper again and print them beside the published ones.

    Every figure has its standard error. Baselines that the paper left out are measured too.
    """

    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER",
            show_default=False,
            help="One of {papers}; or all.",
            autocompletion=completed_from("papers", also=("all",)),
        ),
    ]
    runs: Annotated[
        int | None,
        typer.Option(metavar="N", help="Number of Monte Carlo runs. Default: jink's own number for the paper."),
    ] = None
    seed: Seed = 0
    json: JsonFile = None
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write one HTML page with the paper's figures redrawn.")
    ] = None
    quick: Annotated[bool, typer.Option("--quick", help="Use about a tenth of the runs.", **FLAG)] = False
    retrain: Annotated[
        bool,
        typer.Option(
            "--retrain",
            help="Train the learned filters again. This takes a while; --quick makes it shorter.",
            **FLAG,
        ),
    ] = False
    quiet: Quiet = False


def run_reproduce(request: ReproduceRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    After an interrupt the runs that are finished are reported and marked partial.
    """
    return exit_status(lambda: _run(request), interrupted="interrupted before any run was finished")


def _run(request: ReproduceRequest) -> int:
    from ..checks import unknown
    from ..papers import PAPERS, run
    from ..papers.learned import retrained, shipped

    if request.paper not in (*PAPERS, "all"):
        raise InputError(unknown("paper", request.paper, [*PAPERS, "all"]))
    if request.runs is not None and request.runs < 2:
        raise InputError(f"--runs is {request.runs}; expected at least 2, since one run has no standard error")
    check_seed(request.seed)
    output = output_path("--json", request.json, stdout=True)
    report = output_path("--report", request.report)
    bodies, sections, partial = [], {}, False
    models = retrained(request.quick) if request.retrain else shipped
    for name in PAPERS if request.paper == "all" else [request.paper]:
        with _progress(request, name) as progress:
            outcome = run(
                PAPERS[name], request.runs, request.seed, quick=request.quick, models=models, progress=progress
            )
        bodies.append(outcome.as_dict())
        partial = outcome.partial
        if not request.quiet and request.json != "-":
            from ..report.papers_table import show

            show(outcome)
        if report is not None:
            from ..report.reproduce_page import section

            # the races behind an outcome are large, and nothing needs them any more
            sections[name] = section(outcome)
        if partial:
            break
    if output is not None:
        _write({"papers": bodies} if request.paper == "all" else bodies[0], output)
    if report is not None:
        from ..report.reproduce_page import joined
        from ..report.shell import write_page

        write_page(report, joined(sections))
    return 130 if partial else 0


@contextmanager
def _progress(request: ReproduceRequest, paper: str) -> Iterator[Callable[[str, int, int], None] | None]:
    with progress_line(not request.quiet) as say:
        yield say and (lambda part, done, of: say(f"{paper}, {part}: {done:,} of {of:,} runs"))


def _write(body: dict[str, Any], path: Path) -> None:
    text = json_text(body)
    if str(path) == "-":
        sys.stdout.write(text)
        return
    from ..io.writing import atomically

    with atomically(path) as (temporary,):
        temporary.write_text(text, encoding="utf-8")
