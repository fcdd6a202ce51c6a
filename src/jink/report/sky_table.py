"""A race on a whole sky as a table."""

from __future__ import annotations

from ..compare.sky_race import SkyEntrant, SkyRace
from ..metrics.figure import Figure
from .terminal import print_line, print_table, standard_output

HEAD = ("filter", "association", "GOSPA m", "places", "missed", "false", "switches", "ids", "held", "spurious", "ms")


def show(race: SkyRace) -> None:
    """Print the race on standard output."""
    console = standard_output()
    print_line(console, f"{race.sky.name}: {race.sky.summary}", style="bold")
    print_line(console, f"{race.runs:,} runs, seed {race.seed}, cut-off {race.sky.cutoff:g} m (p = α = 2)")
    print_table(console, HEAD, [_row(e) for e in race.entrants], left=(0, 1))
    print_line(
        console,
        "GOSPA and its parts are root mean squares over runs and scans; switches per run, ids per target; "
        "held: share of targets and scans with a track; spurious: of tracks without a target; ms of CPU per scan.",
    )


def _row(entrant: SkyEntrant) -> tuple[str, ...]:
    f = entrant.figures
    return (
        entrant.filter,
        entrant.association,
        _figure(f.gospa),
        f"{f.localisation:.4g}",
        f"{f.missed:.4g}",
        f"{f.false:.4g}",
        _figure(f.switches),
        f"{f.identities:.3g}",
        f"{f.completeness:.3f}",
        f"{f.spurious:.3f}",
        f"{entrant.milliseconds:.3g}",
    )


def _figure(figure: Figure) -> str:
    return f"{figure.value:.4g}" + (f" ± {figure.se:.2g}" if figure.se == figure.se else "")
