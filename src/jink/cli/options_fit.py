"""The options of `jink fit`."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import FLAG

Data = Annotated[
    str,
    typer.Argument(
        metavar="FILE|SCENARIO",
        show_default=False,
        help="A file of recorded positions; or a scenario, or several of them with commas, whose truth is known.",
    ),
]
Filter = Annotated[
    str | None,
    typer.Option(
        "--filter",
        metavar="NAME",
        help="Where the fit starts: imm (default), another name (a wrong one lists all), or a file written by save(). "
        "With --search: the candidates, with commas; default: all.",
    ),
]
Search = Annotated[
    bool,
    typer.Option(
        "--search",
        help="Which filter fits these targets best? Fits 1–3 modes of many kinds in parallel, ranks them on held-out data.",
        **FLAG,
    ),
]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="FILE", help="The fitted filter: .json for jink track --filter."),
]
Objective = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="likelihood, prediction, tracking or normalised; without: tracking where there is truth, else likelihood.",
    ),
]
Truth = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMNS",
        help="Truth in the file: px=true_x,vx=…, or the word true for the columns that jink simulate writes.",
    ),
]
Ahead = Annotated[int, typer.Option(metavar="SCANS", help="How far the prediction objective looks.")]
Free = Annotated[
    list[str] | None,
    typer.Option(metavar="PATTERN", help="Fit these as well: 'sensor.*' (a wrong one lists all)."),
]
Fix = Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave these as they are.")]
Minutes = Annotated[float | None, typer.Option(metavar="M", help="Budget; the best so far is kept.")]
Runs = Annotated[int, typer.Option(metavar="N", help="Runs of a scenario to fit on.")]
Seed = Annotated[int, typer.Option(metavar="S", help="Of runs, splits and starts.")]
Starts = Annotated[int, typer.Option(metavar="N", help="Places the search starts from.")]
Checkpoint = Annotated[
    str | None,
    typer.Option(metavar="FILE", help="Where the search is kept while it runs; default: beside the output."),
]
Resume = Annotated[bool, typer.Option("--resume", help="Take up the search of the checkpoint.", **FLAG)]
Report = Annotated[
    str | None, typer.Option(metavar="FILE", help="A page that shows held-out tracks before and after.")
]
