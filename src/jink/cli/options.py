"""Options that several commands of the command line share."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

FLAG: dict[str, Any] = {"metavar": " "}
SEEN = "How the targets are seen"


class Kind(StrEnum):
    """What is tracked; it decides the default filter and what counts as a gap."""

    aircraft = "aircraft"
    fighter = "fighter"
    vessel = "vessel"
    vehicle = "vehicle"
    drone = "drone"
    person = "person"


class AltitudeUnit(StrEnum):
    """Unit of an altitude whose column name does not say."""

    ft = "ft"
    m = "m"


class TimeUnit(StrEnum):
    """Unit of numeric times whose column name does not say."""

    s = "s"
    ms = "ms"
    us = "us"
    ns = "ns"


Runs = Annotated[int, typer.Option(metavar="N", help="Monte Carlo runs.")]
Seed = Annotated[int, typer.Option(metavar="S", help="The same seed gives the same numbers.")]
Recorded = Annotated[
    Kind, typer.Option(metavar="KIND", help="What a recorded file's targets are, as for track.")
]
Sensor = Annotated[
    str | None,
    typer.Option(
        metavar="SENSOR",
        rich_help_panel=SEEN,
        help="radar-20hz, radar-1hz, radar-4s, radar-12s, or a position noise in metres; "
        "without: the scenario's own.",
    ),
]
Interval = Annotated[
    float | None, typer.Option(metavar="SECONDS", rich_help_panel=SEEN, help="Between scans.")
]
Jitter = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", rich_help_panel=SEEN, help="Scans are early or late by up to this."),
]
Detection = Annotated[
    float | None,
    typer.Option(metavar="P", rich_help_panel=SEEN, help="Probability that a scan sees the target."),
]
Outliers = Annotated[
    float | None,
    typer.Option(metavar="SHARE", rich_help_panel=SEEN, help="Share of scans with 20 times the noise."),
]
Bias = Annotated[
    str | None,
    typer.Option(metavar="B1,B2", rich_help_panel=SEEN, help="Added to every measurement: m, rad, m/s."),
]
JsonFile = Annotated[
    str | None, typer.Option("--json", metavar="FILE", help="All figures as JSON; - for standard output.")
]
Columns = Annotated[
    list[str] | None,
    typer.Option(metavar="MAP", help="Of a file, name columns yourself: target=hex,time_ms=t"),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No tables, no progress.", **FLAG)]
CheckRuns = Annotated[int, typer.Option(metavar="N", help="Other runs of it to check on.")]
Json = Annotated[bool, typer.Option("--json", help="All figures as JSON.", **FLAG)]
