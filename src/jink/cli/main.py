"""The command line. Nothing heavy is imported before it is needed: `jink --help` has to be instant."""

from __future__ import annotations

import sys
from typing import Annotated, Any

try:
    import typer
except ImportError:
    sys.exit('jink: the command line needs some more packages: pip install "jink[track]"')

from ..scenarios.observation import Seeing
from . import options
from . import options_fit as fitting
from . import options_learn as learning
from . import options_track as tracking
from .options import FLAG, Kind

app = typer.Typer(
    help="Track targets that manoeuvre: from noisy positions to velocity, acceleration, turn rate and the "
    "probability that they manoeuvre.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"jink {version('jink')}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and leave.")
    ] = False,
) -> None:
    """Track targets that manoeuvre."""


@app.command()
def track(
    inputs: tracking.Inputs,
    output: tracking.Output = None,
    report: tracking.Report = None,
    json: tracking.Json = False,
    quiet: tracking.Quiet = False,
    smooth: tracking.Smooth = False,
    kind: tracking.KindOfTarget = Kind.aircraft,
    filter_: tracking.Filter = None,
    sensor_sd: tracking.SensorSd = None,
    threads: tracking.Threads = None,
    columns: tracking.Columns = None,
    altitude_unit: tracking.UnitOfAltitude = None,
    time_unit: tracking.UnitOfTime = None,
    site: tracking.Site = None,
    gap: tracking.Gap = None,
    min_points: tracking.MinPoints = 4,
    no_sort: tracking.NoSort = False,
    keep_duplicates: tracking.KeepDuplicates = False,
    keep_stale: tracking.KeepStale = False,
    no_check: tracking.NoCheck = False,
) -> None:
    """Tracks from position reports: clean, estimate the noise, filter or smooth, write estimates.

    Rows that end up in no track go to *.rejected.parquet beside the output, with file, row and reason.
    """
    from .track import Request, run_command

    request = Request(
        inputs=inputs,
        output=output,
        report=report,
        smooth=smooth,
        kind=kind.value,
        filter=filter_,
        sensor_sd=sensor_sd,
        site=site,
        columns=columns or [],
        altitude_unit=altitude_unit and altitude_unit.value,
        time_unit=time_unit and time_unit.value,
        gap=gap,
        min_points=min_points,
        sort=not no_sort,
        drop_duplicates=not keep_duplicates,
        drop_stale=not keep_stale,
        check_coordinates=not no_check,
        threads=threads,
        json=json,
        quiet=quiet,
    )
    raise typer.Exit(run_command(request))


@app.command()
def simulate(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            show_default=False,
            help="A scenario (lee-2003, benchmark-1, random-turns, terminal-area, …; a wrong name lists all), "
            "or a file of recorded positions whose smoothed tracks become the truth.",
        ),
    ],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE", help="One table: .parquet .csv .jsonl .arrow")
    ],
    runs: options.Runs = 100,
    seed: options.Seed = 0,
    sensor: options.Sensor = None,
    interval: options.Interval = None,
    jitter: options.Jitter = None,
    detection: options.Detection = None,
    outliers: options.Outliers = None,
    bias: options.Bias = None,
    kind: options.Recorded = Kind.aircraft,
    json: Annotated[bool, typer.Option("--json", help="The summary as JSON.", **FLAG)] = False,
    quiet: options.Quiet = False,
) -> None:
    """Measurements and truth of a scenario, as one table that jink track and jink compare read as well."""
    from .simulate import SimulateRequest, run_simulate

    seeing = Seeing(sensor, interval, jitter, detection, outliers, bias)
    request = SimulateRequest(name, runs, seed, output, seeing, kind.value, json, quiet)
    raise typer.Exit(run_simulate(request))


@app.command()
def compare(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|FILE",
            show_default=False,
            help="A scenario (a wrong name lists all), a file that jink simulate wrote, or one of recorded positions: "
            "without truth, or with sensor options its smoothed tracks are the truth.",
        ),
    ],
    filters: Annotated[
        str,
        typer.Option(
            metavar="A,B,C.json",
            help="Names (a wrong one lists all), all, or files written by save(); beside them always raw "
            "measurements, tuned Kalman filters, the default IMM and the clairvoyant bound.",
        ),
    ] = "",
    runs: options.Runs = 1000,
    seed: options.Seed = 0,
    json: options.JsonFile = None,
    report: Annotated[str | None, typer.Option(metavar="FILE", help="One HTML page to look at.")] = None,
    sensor: options.Sensor = None,
    interval: options.Interval = None,
    jitter: options.Jitter = None,
    detection: options.Detection = None,
    outliers: options.Outliers = None,
    bias: options.Bias = None,
    kind: options.Recorded = Kind.aircraft,
    columns: options.Columns = None,
    quiet: options.Quiet = False,
) -> None:
    """A fair race of filters: common random numbers, standard errors, no verdict without an interval."""
    from .compare import CompareRequest, run_compare

    seeing = Seeing(sensor, interval, jitter, detection, outliers, bias)
    request = CompareRequest(
        scenario, filters, runs, seed, json, report, seeing, kind.value, columns or (), quiet
    )
    raise typer.Exit(run_compare(request))


@app.command()
def reproduce(
    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER",
            show_default=False,
            help="lee-2003, lee-2002, wang-2010, choi-2001, titi-guney, or all.",
        ),
    ],
    runs: Annotated[
        int | None, typer.Option(metavar="N", help="Monte Carlo runs; without: the paper's own number here.")
    ] = None,
    seed: options.Seed = 0,
    json: options.JsonFile = None,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="One HTML page with the paper's figures redrawn.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A tenth of the runs or so.", **FLAG)] = False,
    retrain: Annotated[
        bool,
        typer.Option(
            "--retrain",
            help="Train the learned filters again, which takes a while (with --quick, less of it).",
            **FLAG,
        ),
    ] = False,
    quiet: options.Quiet = False,
) -> None:
    """A paper's figures beside those measured here, with standard errors and the baselines that it left out."""
    from .reproduce import ReproduceRequest, run_reproduce

    raise typer.Exit(run_reproduce(ReproduceRequest(paper, runs, seed, json, report, quick, retrain, quiet)))


@app.command()
def fit(
    data: fitting.Data,
    filter_: fitting.Filter = None,
    search: fitting.Search = False,
    output: fitting.Output = None,
    objective: fitting.Objective = None,
    truth: fitting.Truth = None,
    ahead: fitting.Ahead = 1,
    free: fitting.Free = None,
    fix: fitting.Fix = None,
    minutes: fitting.Minutes = None,
    runs: fitting.Runs = 200,
    check_runs: options.CheckRuns = 500,
    seed: fitting.Seed = 0,
    starts: fitting.Starts = 3,
    kind: options.Recorded = Kind.aircraft,
    columns: options.Columns = None,
    checkpoint: fitting.Checkpoint = None,
    resume: fitting.Resume = False,
    report: fitting.Report = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """A filter learned from your own targets, with or without truth, checked on data it has not seen."""
    from .fit import FitRequest, run_fit

    request = FitRequest(
        data=data, output=output, filter=filter_, search=search, objective=objective, truth=truth, ahead=ahead, free=free or (),
        fix=fix or (), runs=runs, check_runs=check_runs, seed=seed, starts=starts, minutes=minutes,
        kind=kind.value, columns=columns or (), checkpoint=checkpoint, resume=resume, report=report, json=json,
        quiet=quiet,
    )  # fmt: skip
    raise typer.Exit(run_fit(request))


@app.command()
def learn(
    name: learning.Name,
    data: learning.Data,
    output: learning.Output = None,
    truth: learning.Truth = None,
    columns: options.Columns = None,
    kind: learning.KindOfTarget = None,
    acceleration: learning.Acceleration = None,
    runs: learning.Runs = 200,
    check_runs: options.CheckRuns = 500,
    seed: learning.Seed = 0,
    optimizer: learning.Optimizer = None,
    generations: learning.Generations = None,
    population: learning.Population = None,
    rules: learning.Rules = None,
    weight: learning.Weight = None,
    inputs: learning.Inputs = None,
    base: learning.Base = None,
    epochs: learning.Epochs = None,
    labels: learning.Labels = False,
    checkpoint: learning.Checkpoint = None,
    resume: learning.Resume = False,
    report: learning.Report = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Fuzzy rules, aids and networks learned from targets whose truth is known, checked on data they have not seen."""
    from .learn import LearnRequest, run_learn

    request = LearnRequest(
        name=name, data=data, output=output, truth=truth, columns=columns or (), kind=kind.value if kind else None,
        runs=runs, check_runs=check_runs, seed=seed, acceleration=acceleration, optimiser=optimizer,
        generations=generations, population=population, rules=rules, weight=weight, inputs=inputs, base=base,
        epochs=epochs, labels=labels, checkpoint=checkpoint, resume=resume, report=report, json=json, quiet=quiet,
    )  # fmt: skip
    raise typer.Exit(run_learn(request))


def main() -> Any:
    """Entry point of the console script."""
    return app()


if __name__ == "__main__":
    sys.exit(main())
