"""The options of `jink track`."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import FLAG, AltitudeUnit, Kind, TimeUnit

OUT, IN, CLEAN = "What comes out", "What goes in", "Cleaning (every step is on unless said otherwise)"

Inputs = Annotated[
    list[str],
    typer.Argument(
        metavar="INPUT...",
        show_default=False,
        help="Files or quoted patterns: CSV, Parquet, Arrow/Feather, JSON, JSON Lines, also .gz, .zst. "
        "'-' reads JSON Lines from standard input and writes estimates as they come.",
    ),
]
Output = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        rich_help_panel=OUT,
        help="Tracks: .parquet .csv .jsonl .geojson .arrow",
    ),
]
Report = Annotated[
    str | None, typer.Option(metavar="FILE", rich_help_panel=OUT, help="One HTML page to look at.")
]
Json = Annotated[
    bool,
    typer.Option("--json", rich_help_panel=OUT, help="The summary as JSON on standard output.", **FLAG),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", rich_help_panel=OUT, help="No progress, no summary.", **FLAG)
]
Smooth = Annotated[
    bool,
    typer.Option("--smooth", "-s", help="Use the whole track for every estimate, not only its past.", **FLAG),
]
KindOfTarget = Annotated[
    Kind,
    typer.Option(
        metavar="KIND",
        help="aircraft, fighter, vessel, vehicle, drone or person: decides the default filter.",
    ),
]
Filter = Annotated[
    str | None,
    typer.Option(
        "--filter",
        metavar="NAME",
        help="imm (default), cv, ca, singer, … (a wrong name lists all), or a file written by save().",
    ),
]
SensorSd = Annotated[
    str | None,
    typer.Option(
        metavar="SD",
        help="Measurement noise: 25 (metres), or position=25,altitude=10, or range=50,azimuth_deg=0.1. "
        "Without: from ADS-B accuracy columns, or estimated from the data.",
    ),
]
Threads = Annotated[int | None, typer.Option(metavar="N", help="Default: all cores.")]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        metavar="MAP",
        rich_help_panel=IN,
        help="Name columns yourself: target=hex,altitude_ft=alt,time_ms=t",
    ),
]
UnitOfAltitude = Annotated[
    AltitudeUnit | None,
    typer.Option(metavar="ft|m", rich_help_panel=IN, help="Where the column's name does not say."),
]
UnitOfTime = Annotated[
    TimeUnit | None,
    typer.Option(metavar="UNIT", rich_help_panel=IN, help="s, ms, us or ns, where size and name do not say."),
]
Site = Annotated[
    str | None,
    typer.Option(
        metavar="LAT,LON",
        rich_help_panel=IN,
        help="Where the radar stands (also LAT,LON,ALTITUDE): puts x, y on the map.",
    ),
]
Gap = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        rich_help_panel=CLEAN,
        help="So long without a position begins a new part; 0: never.",
    ),
]
MinPoints = Annotated[
    int,
    typer.Option(metavar="N", rich_help_panel=CLEAN, help="Reject parts with fewer positions; 1: none."),
]
NoSort = Annotated[
    bool,
    typer.Option(
        "--no-sort", rich_help_panel=CLEAN, help="Reject rows out of order instead of sorting.", **FLAG
    ),
]
KeepDuplicates = Annotated[
    bool,
    typer.Option(
        "--keep-duplicates", rich_help_panel=CLEAN, help="Keep rows whose time occurs twice.", **FLAG
    ),
]
KeepStale = Annotated[
    bool,
    typer.Option(
        "--keep-stale",
        rich_help_panel=CLEAN,
        help="Believe repeated positions of moving targets.",
        **FLAG,
    ),
]
NoCheck = Annotated[
    bool,
    typer.Option("--no-check", rich_help_panel=CLEAN, help="Believe impossible coordinates.", **FLAG),
]
