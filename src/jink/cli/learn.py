"""`jink learn`: check the request, learn, check on held-out data, write filter and page; an error writes nothing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import PACKAGES, exit_status, failed
from .request import (
    FLAG,
    CheckRuns,
    Columns,
    Json,
    Quiet,
    Seed,
    check_at_least,
    check_kind,
    check_seed,
    completed_from,
    filter_path,
    json_text,
    output_path,
    parse_columns,
)

SEARCH = "Only for fuzzy-imm and fuzzy-kalman, which search for rules"
NETWORKS = "Only for networks and for the filters that they aid"
AIDS = ("anfis-kf", "nn-kf")
FEWEST_FAMILIES = 20
LABELLED = ("nnvsmm", "nnvsmm-modes")


@frozen(kw_only=True)
class LearnRequest:
    """Learn fuzzy rules or networks from targets whose truth is known.

    The learned filter is checked on data that it has not seen.
    """

    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            show_default=False,
            help="The filter to learn: {learned}.",
            autocompletion=completed_from("learned"),
        ),
    ]
    data: Annotated[
        str,
        typer.Argument(
            metavar="FILE|SCENARIO",
            show_default=False,
            help="A file of positions with their truth (corrector: also without), or scenarios (with commas).",
            autocompletion=completed_from("scenarios"),
        ),
    ]
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE", help="Write the filter as .json, for jink track --filter."),
    ] = None
    truth: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMNS",
            help="The file's columns of truth: px=true_x,vx=… Default: those of jink simulate.",
        ),
    ] = None
    columns: Columns = None
    kind: Annotated[
        str | None,
        typer.Option(
            metavar="KIND",
            show_default=False,
            help="What the targets are: {kinds}. It decides how hard they accelerate.",
            autocompletion=completed_from("kinds"),
        ),
    ] = None
    acceleration: Annotated[
        float | None,
        typer.Option(metavar="M/S²", help="How hard the targets accelerate, instead of the kind's figure."),
    ] = None
    runs: Annotated[int, typer.Option(metavar="N", help="Number of runs of a scenario to learn from.")] = 200
    check_runs: CheckRuns = 500
    seed: Seed = 0
    optimiser: Annotated[
        str | None,
        typer.Option(
            "--optimizer",
            metavar="NAME",
            rich_help_panel=SEARCH,
            help="ga (default, as published), cma, or together: all modes and their transitions at once.",
            autocompletion=completed_from("optimisers"),
        ),
    ] = None
    generations: Annotated[
        int | None,
        typer.Option(metavar="N", rich_help_panel=SEARCH, help="Number of generations. Default: 100; together: 250."),
    ] = None
    population: Annotated[
        int | None,
        typer.Option(
            metavar="N", rich_help_panel=SEARCH, help="Candidates in a generation. Default: 500; together: 24."
        ),
    ] = None
    rules: Annotated[
        int | None,
        typer.Option(metavar="N", rich_help_panel=SEARCH, help="Most rules for a mode. Default: 50; together: 2."),
    ] = None
    weight: Annotated[
        float | None,
        typer.Option(
            metavar="λ",
            rich_help_panel=SEARCH,
            help="Weight of the tracking error, 0 to 1; the rest rewards few rules. Default: 0.95.",
        ),
    ] = None
    inputs: Annotated[
        str | None,
        typer.Option(
            metavar="M/S²,…|NAME",
            help="For fuzzy-imm: accelerations of the modes. Default: 1, 10 and 100 % of the kind's. "
            "For an aid: its inputs, innovations (default), sums of them, or titi-guney.",
        ),
    ] = None
    process_sd: Annotated[
        float | None,
        typer.Option(
            metavar="M/S²",
            rich_help_panel=SEARCH,
            help="Process noise of targets that do not manoeuvre, for fuzzy-imm. Default: 1 % of --acceleration.",
        ),
    ] = None
    own_inputs: Annotated[
        bool,
        typer.Option(
            "--own-inputs",
            rich_help_panel=SEARCH,
            help="Learn each mode of fuzzy-imm on a target of its own acceleration, as published, instead of the data.",
            **FLAG,
        ),
    ] = False
    along_track: Annotated[
        bool,
        typer.Option(
            "--along-track",
            rich_help_panel=SEARCH,
            help="Rules along and across the track instead of one set for every axis, with --optimizer together.",
            **FLAG,
        ),
    ] = False
    base: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            rich_help_panel=NETWORKS,
            help="The filter that anfis-kf or nn-kf aids. Default: constant acceleration, tuned.",
            autocompletion=completed_from("filters"),
        ),
    ] = None
    functions: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            rich_help_panel=NETWORKS,
            help="Membership functions of each input of anfis-kf. Default: 2; sums: 3; titi-guney: 4.",
        ),
    ] = None
    membership: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=NETWORKS,
            help="Their form: gaussian (default), triangular (default for titi-guney's inputs) or bell.",
        ),
    ] = None
    method: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=NETWORKS,
            help="How anfis-kf is trained: hybrid (default) or backpropagation, as published.",
        ),
    ] = None
    epochs: Annotated[
        int | None,
        typer.Option(
            metavar="N", rich_help_panel=NETWORKS, help="Epochs of training, or steps when trained end to end."
        ),
    ] = None
    labels: Annotated[
        bool,
        typer.Option(
            "--labels",
            rich_help_panel=NETWORKS,
            help="Learn which mode was the best one, instead of reducing the tracking error itself.",
            **FLAG,
        ),
    ] = False
    bank: Annotated[
        str | None,
        typer.Option(
            metavar="KINDS",
            rich_help_panel=NETWORKS,
            help="The modes of nnvsmm-modes: three constant velocities (cv), an acceleration (ca), a turn (ct), "
            "for example cv,ca,ct. They are learned from labels.",
        ),
    ] = None
    argmin_labels: Annotated[
        bool,
        typer.Option(
            "--argmin-labels",
            rich_help_panel=NETWORKS,
            help="Learn nnvsmm from the published labels: at each scan the filter of least error.",
            **FLAG,
        ),
    ] = False
    families: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            rich_help_panel=NETWORKS,
            help="Random families of targets that a corrector is learned on, besides the data. "
            "Default: 1000; with recorded tracks: 1200.",
        ),
    ] = None
    checkpoint: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            rich_help_panel=SEARCH,
            help="Keep the state of the search here while it runs. Default: beside the output.",
        ),
    ] = None
    resume: Annotated[
        bool, typer.Option("--resume", rich_help_panel=SEARCH, help="Go on from the checkpoint.", **FLAG)
    ] = False
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write one HTML page with figures, rules and their surfaces.")
    ] = None
    json: Json = False
    quiet: Quiet = False


def run_learn(request: LearnRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    After an interrupt a search for rules is kept in its checkpoint, and --resume goes on from there.
    """
    packages = (*PACKAGES, "scipy", "cma", "pymoo", "autograd")
    return exit_status(lambda: _run(request), packages=packages, extra="learn,track")


def _run(request: LearnRequest) -> int:
    from ..learn.learning import learn

    output = filter_path(request.output, request.data)
    report = output_path("--report", request.report, data=request.data)
    recipe = _recipe(request)
    kept = _kept(request)
    if not request.resume:
        _remove(kept)
    try:
        with _progress(not (request.quiet or request.json)) as progress:
            learned = learn(
                request.name,
                request.data,
                truth=request.truth,
                columns=parse_columns(request.columns) or None,
                kind=request.kind,
                runs=request.runs,
                check_runs=request.check_runs,
                seed=request.seed,
                base=request.base,
                checkpoint=kept,
                progress=progress,
                **recipe,
            )
    except KeyboardInterrupt:
        return failed("interrupted" + ("; --resume goes on from the checkpoint" if _files(kept) else ""), 130)
    if output:
        learned.save(output)
    if report:
        from ..report.learn_page import write_learn_report

        write_learn_report(learned, report)
    if not request.checkpoint:
        _remove(kept)
    if request.json:
        sys.stdout.write(json_text(learned.as_dict()))
    elif not request.quiet:
        from ..report.learn_table import show

        show(learned)
    return 0


def _recipe(request: LearnRequest) -> dict[str, Any]:
    """What was asked of the recipe, checked as far as that needs no data."""
    from ..learn.rule_recipes import OPTIMISERS

    _check_options_go_with_the_name(request)
    check_at_least(
        1,
        runs=request.runs,
        check_runs=request.check_runs,
        generations=request.generations,
        population=request.population,
        rules=request.rules,
        epochs=request.epochs,
    )
    if request.families is not None:
        check_at_least(FEWEST_FAMILIES, families=request.families)
    check_seed(request.seed)
    if request.kind is not None:
        check_kind(request.kind)
    if request.optimiser is not None and request.optimiser not in OPTIMISERS:
        raise InputError(f"--optimizer is {request.optimiser!r}; expected one of {', '.join(OPTIMISERS)}")
    if request.acceleration is not None and not request.acceleration > 0:
        raise InputError(f"--acceleration is {request.acceleration:g}; expected more than 0 m/s²")
    if request.process_sd is not None and not 0 < request.process_sd < float("inf"):
        raise InputError(f"--process-sd is {request.process_sd:g}; expected more than 0 m/s²")
    for option, value in (("--process-sd", request.process_sd), ("--own-inputs", request.own_inputs or None)):
        if value is not None and request.optimiser == "together":
            raise InputError(
                f"{option} is about modes that are learned one by one; --optimizer together does not have it"
            )
    if request.along_track and request.optimiser != "together":
        raise InputError("--along-track searches all modes at once; give --optimizer together with it")
    if request.weight is not None and not 0 <= request.weight <= 1:
        raise InputError(f"--weight is {request.weight:g}; expected 0 to 1")
    same = (
        "acceleration",
        "process_sd",
        "optimiser",
        "generations",
        "population",
        "rules",
        "weight",
        "epochs",
        "families",
    )
    given = {name: getattr(request, name) for name in same}
    given |= {
        "along_track": request.along_track or None,
        "own_inputs": request.own_inputs or None,
        "labels": request.labels or None,
    }
    if request.argmin_labels:
        given["labels"] = "argmin"
    if request.bank is not None:
        given["bank"] = tuple(each.strip() for each in request.bank.split(","))
    given |= _of_an_aid(request) if request.name in AIDS else {"inputs": _numbers(request.inputs)}
    return {name: value for name, value in given.items() if value is not None}


def _of_an_aid(request: LearnRequest) -> dict[str, Any]:
    """What an aid looks at and how its ANFIS is made. Errors: InputError."""
    from ..learn.anfis import METHODS
    from ..models.anfis import PARAMETERS
    from ..models.corrector import INPUTS

    check_at_least(1, functions=request.functions)
    for option, value, names in (
        ("--inputs", request.inputs, INPUTS),
        ("--membership", request.membership, tuple(PARAMETERS)),
        ("--method", request.method, METHODS),
    ):
        if value is not None and value not in names:
            raise InputError(f"{option} is {value!r}; expected one of {', '.join(names)}")
    given = {"aid_inputs": request.inputs}
    return given | {name: getattr(request, name) for name in ("functions", "membership", "method")}


def _check_options_go_with_the_name(request: LearnRequest) -> None:
    """Errors: InputError for an option that the filter to be learned does not have, and for an unknown filter."""
    from ..checks import unknown
    from ..learn.recipes import RECIPES
    from ..learn.rule_recipes import SEARCHED

    if request.name not in RECIPES:
        raise InputError(unknown("learned filter", request.name, RECIPES))
    for option, value, names in (
        ("--optimizer", request.optimiser, SEARCHED),
        ("--generations", request.generations, SEARCHED),
        ("--population", request.population, SEARCHED),
        ("--rules", request.rules, SEARCHED),
        ("--weight", request.weight, SEARCHED),
        ("--process-sd", request.process_sd, ("fuzzy-imm",)),
        ("--own-inputs", request.own_inputs or None, ("fuzzy-imm",)),
        ("--along-track", request.along_track or None, SEARCHED),
        ("--checkpoint", request.checkpoint, SEARCHED),
        ("--resume", request.resume or None, SEARCHED),
        ("--epochs", request.epochs, tuple(name for name in RECIPES if name not in SEARCHED)),
        ("--families", request.families, ("corrector",)),
        ("--base", request.base, AIDS),
        ("--functions", request.functions, ("anfis-kf",)),
        ("--membership", request.membership, ("anfis-kf",)),
        ("--method", request.method, ("anfis-kf",)),
        ("--labels", request.labels or None, LABELLED),
        ("--bank", request.bank, ("nnvsmm-modes",)),
        ("--argmin-labels", request.argmin_labels or None, ("nnvsmm",)),
    ):
        if value is not None and request.name not in names:
            raise InputError(f"{option} is an option for {', '.join(names)}; {request.name} does not have it")
    if request.labels and request.argmin_labels:
        raise InputError("--labels and --argmin-labels are two kinds of labels; give one")
    if request.bank is not None and request.inputs is not None:
        raise InputError("--bank and --inputs both say which modes there are; give one")
    if request.resume and not (request.checkpoint or request.output):
        raise InputError("--resume needs a checkpoint: give --checkpoint, or the -o that the search was started with")


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
    """Where a search for rules keeps its state, one file for each mode."""
    from ..learn.rule_recipes import SEARCHED

    if request.name not in SEARCHED:
        return None
    return request.checkpoint or (f"{request.output}.checkpoint" if request.output else None)


def _files(kept: str | None) -> list[Path]:
    if kept is None:
        return []
    path = Path(kept)
    return sorted(file for file in path.parent.glob("*.npz") if file.name.startswith(f"{path.name}."))


def _remove(kept: str | None) -> None:
    for file in _files(kept):
        file.unlink()


@contextmanager
def _progress(wanted: bool) -> Iterator[Callable[[str, int, int], None] | None]:
    """A bar on standard error that says what is best so far; None if nobody wants or sees it."""
    if not wanted or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = BarColumn(20), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda words, done, of: bar.update(task, description=words, completed=done, total=of)
