"""The options of `jink learn`."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import FLAG, Kind

SEARCH, NETWORKS = "Searches for rules (fuzzy-imm, fuzzy-kalman)", "Aids and networks"

Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        show_default=False,
        help="fuzzy-imm, fuzzy-kalman, anfis-kf, nn-kf, nnvsmm or nnvsmm-modes.",
    ),
]
Data = Annotated[
    str,
    typer.Argument(
        metavar="FILE|SCENARIO",
        show_default=False,
        help="A file of positions with their truth; or a scenario, or several of them with commas.",
    ),
]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="FILE", help="The learned filter: .json for jink track --filter."),
]
Truth = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMNS",
        help="Truth in the file: px=true_x,vx=…; without: the columns that jink simulate writes.",
    ),
]
KindOfTarget = Annotated[
    Kind | None,
    typer.Option(
        metavar="KIND", help="What the targets are; it says how hard they pull.", show_default=False
    ),
]
Acceleration = Annotated[
    float | None, typer.Option(metavar="M/S²", help="How hard they pull, instead of the kind's.")
]
Runs = Annotated[int, typer.Option(metavar="N", help="Runs of a scenario to learn on.")]
Seed = Annotated[int, typer.Option(metavar="S", help="The same seed learns the same filter.")]
Optimizer = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        rich_help_panel=SEARCH,
        help="ga, as published; cma; or together: all modes and their transition matrix at once.",
    ),
]
Generations = Annotated[
    int | None, typer.Option(metavar="N", rich_help_panel=SEARCH, help="Default 100; together 250.")
]
Population = Annotated[
    int | None, typer.Option(metavar="N", rich_help_panel=SEARCH, help="Default 500; together 24.")
]
Rules = Annotated[
    int | None,
    typer.Option(metavar="N", rich_help_panel=SEARCH, help="Per mode, at most 50 by default; together 2."),
]
Weight = Annotated[
    float | None,
    typer.Option(metavar="λ", rich_help_panel=SEARCH, help="Of the error against few rules; default 0.95."),
]
Inputs = Annotated[
    str | None,
    typer.Option(metavar="M/S²,…", help="Accelerations of the modes; default 1, 10 and 100 % of the kind's."),
]
Base = Annotated[
    str | None,
    typer.Option(
        metavar="NAME|FILE",
        rich_help_panel=NETWORKS,
        help="The filter to be aided; default: constant acceleration, tuned.",
    ),
]
Epochs = Annotated[
    int | None, typer.Option(metavar="N", rich_help_panel=NETWORKS, help="Epochs, or steps end to end.")
]
Labels = Annotated[
    bool,
    typer.Option(
        "--labels",
        rich_help_panel=NETWORKS,
        help="Learn which mode was best instead of the tracking error itself.",
        **FLAG,
    ),
]
Checkpoint = Annotated[
    str | None,
    typer.Option(
        metavar="FILE",
        rich_help_panel=SEARCH,
        help="Where the search is kept while it runs; default: beside the output.",
    ),
]
Resume = Annotated[
    bool,
    typer.Option("--resume", rich_help_panel=SEARCH, help="Take up the search of the checkpoint.", **FLAG),
]
Report = Annotated[
    str | None, typer.Option(metavar="FILE", help="A page with figures, rules and their surfaces.")
]
