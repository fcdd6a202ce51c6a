"""A race on a whole sky as a table."""

from __future__ import annotations

from ..compare.sky_race import SkyEntrant, SkyRace
from ..metrics.figure import Figure
from .terminal import print_line, print_table, standard_output

HEAD = ("filter", "association", "GOSPA m", "places", "missed", "false", "switches", "ids", "held", "spurious", "ms")
MORE = (
    "filter",
    "association",
    "MOTA",
    "MOTP m",
    "completeness",
    "ambiguity",
    "spuriousness",
    "accuracy m",
    "id changes / h",
    "longest",
)


def show(race: SkyRace) -> None:
    """Print the race on standard output."""
    console = standard_output()
    print_line(console, f"{race.sky.name}: {race.sky.summary}", style="bold")
    print_line(console, f"{race.runs:,} runs, seed {race.seed}, cut-off {race.sky.cutoff:g} m (p = α = 2)")
    print_table(console, HEAD, [row_of(e) for e in race.entrants], left=(0, 1))
    print_line(
        console,
        "GOSPA and its parts are root mean squares over runs and scans; switches per run, ids per target; "
        "held: share of targets and scans with a track; spurious: of tracks without a target; ms of CPU per scan.",
    )
    print_table(console, MORE, [second_row_of(e) for e in race.entrants], left=(0, 1))
    print_line(
        console,
        "CLEAR-MOT: MOTA, MOTP. SIAP, where a track belongs to the target nearest to it: completeness, ambiguity, "
        "spuriousness, positional accuracy, id changes per hour of target, longest stretch on one track.",
    )


def row_of(entrant: SkyEntrant) -> tuple[str, ...]:
    """Cells under ``HEAD``."""
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


def second_row_of(entrant: SkyEntrant) -> tuple[str, ...]:
    """Cells under ``MORE``."""
    s, m = entrant.siap, entrant.clear_mot
    hourly = Figure(3600 * s.id_change_rate.value, 3600 * s.id_change_rate.se)
    return (
        entrant.filter,
        entrant.association,
        _figure(m.mota),
        _figure(m.motp),
        f"{s.completeness.value:.3f}",
        f"{s.ambiguity.value:.3f}",
        f"{s.spuriousness.value:.3f}",
        _figure(s.position_accuracy),
        _figure(hourly),
        f"{s.longest_segment.value:.3f}",
    )


def _figure(figure: Figure) -> str:
    return f"{figure.value:.4g}" + (f" ± {figure.se:.2g}" if figure.se == figure.se else "")
