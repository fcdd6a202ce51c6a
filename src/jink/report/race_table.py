"""The race as tables: figures ± standard errors, and the verdicts that the intervals allow."""

from __future__ import annotations

import math
from typing import Any

from ..compare.result import AGAINST, Race
from ..metrics import Figure
from .terminal import print_line, print_table, standard_output

COLUMNS = {
    "position_rmse": "position m",
    "position_median": "median m",
    "position_95": "95% m",
    "velocity_rmse": "velocity m/s",
    "acceleration_rmse": "accel. m/s²",
    "normalised_position": "norm. pos.",
    "normalised_velocity": "norm. vel.",
    "prediction_rmse": "prediction m",
    "prediction_score": "ln p",
    "nees_inside": "NEES in",
    "nis_inside": "NIS in",
    "lost": "lost",
    "gated": "gated",
    "position_efficiency": "efficiency",
    "us_per_update": "µs",
}
AROUND = {
    "mean_euclidean": "mean |e| m",
    "onset_peak": "onset peak m",
    "onset_settling": "settles scans",
    "end_peak": "end peak m",
    "end_settling": "settles scans ",
    "noticed": "noticed",
    "detection_delay": "delay scans",
    "false_alarms": "false alarms",
    "detection": "detection",
    "false_alarm": "false alarm",
    "mode_jump_delay": "mode delay scans",
    "log_score": "ln p(truth)",
    "prediction_score": "ln p(next z)",
}
# columns of a terminal that shows all figures; a file shows them too
WIDE = 150
SHARES = ("nees_inside", "nis_inside", "lost", "gated", "noticed", "false_alarms", "detection", "false_alarm")
ONLY_WIDE = (
    "position_median",
    "position_95",
    "normalised_position",
    "normalised_velocity",
    "prediction_score",
)


def show(race: Race) -> None:
    """Print the race on standard output, in colour if the terminal has it."""
    console = standard_output()
    figures = {name: race.figures(name) for name in race.tallies}
    columns = [c for c in COLUMNS if any(c in found for found in figures.values())]
    if race.unit != "runs":
        columns = [c for c in columns if c in race.metrics]
    elif console.width < WIDE:
        extra = ("acceleration_rmse",) if "position_efficiency" in columns else ()
        columns = [c for c in columns if c not in (*ONLY_WIDE, *extra)]
    rows = [[label(race, name), *(written(c, figures[name].get(c)) for c in columns)] for name in ordered(race)]
    styles = [_style(race, name) for name in ordered(race)]
    if race.bound:
        rows.append(["PCRB", *(f"{race.bound[c]:.4g}" if c in race.bound else "" for c in columns)])
        styles.append("dim")
    print_line(console, heading(race), "bold")
    print_table(console, ["filter", *(COLUMNS[column] for column in columns)], rows, styles)
    if race.unit == "runs" and console.width >= WIDE:
        columns = [c for c in AROUND if any(c in found for found in figures.values())]
        rows = [[label(race, name), *(written(c, figures[name].get(c)) for c in columns)] for name in ordered(race)]
        print_table(console, ["manoeuvres, scores", *(AROUND[column].strip() for column in columns)], rows)
    for line in remarks(race):
        print_line(console, line)


def _style(race: Race, name: str) -> str:
    """Red for a filter that is worse than raw measurements, dim for what is there to compare with."""
    if race.worse_than_raw(name):
        return "red"
    return "dim" if name in ("raw", "clairvoyant", "near-optimal") else ""


def heading(race: Race) -> str:
    """What was run."""
    text = f"{race.scenario}: {race.words}; {race.runs:,} {race.unit}, seed {race.seed}"
    if race.seen:
        text += f"\nseen by {race.seen}"
    return f"{text}\nPARTIAL: interrupted after {race.runs:,} of {race.asked:,} {race.unit}" if race.partial else text


def ordered(race: Race) -> list[str]:
    """Names in the order they were asked for; those that were fitted on these very runs come last."""
    return sorted(race.tallies, key=lambda name: race.entrants[name].in_sample)


def label(race: Race, name: str) -> str:
    """The name with its marks: * fitted on this scenario, ** on these very runs, ! worse than raw."""
    entrant = race.entrants[name]
    mark = " **" if entrant.in_sample else " *" if entrant.fitted else ""
    return name + mark + (" !" if race.worse_than_raw(name) else "")


def written(metric: str, figure: Figure | None) -> str:
    """A value with its standard error, to the digits that the error leaves."""
    if figure is None or math.isnan(figure.value):
        return "–"
    if math.isinf(figure.value):
        return "never"
    if metric in SHARES:
        return f"{100 * figure.value:.1f}%"
    if metric == "us_per_update":
        return f"{figure.value:.2f}"
    if metric == "mode_jump_delay":
        return f"{figure.value:.3g}" + (f" ±{figure.se:.1f}" if figure.se >= 0.05 else "")
    if metric.endswith("_settling"):
        return f"{figure.value:.0f}" + (f" ±{figure.se:.0f}" if figure.se >= 0.5 else "")
    digits = 3
    if figure.se > 0:
        digits = min(max(-math.floor(math.log10(figure.se)), 0), 6)
    error = f" ±{figure.se:.{digits}f}" if figure.se > 0 else ""
    return f"{figure.value:.{digits}f}{error}"


def remarks(race: Race) -> list[str]:
    """Footnotes: verdicts, which data filters were fitted on, which filters are missing and why."""
    lines = ["value ± standard error; in: share inside the 95% χ² band (95% when consistent)"]
    if race.bound:
        lines.append("PCRB: posterior Cramér–Rao bound for filters that know the manoeuvres")
    for name in race.tallies:
        said = verdicts(race, name)
        if said:
            lines.append(f"{name}: {said}")
    return lines + footnotes(race)


def footnotes(race: Race) -> list[str]:
    """What the marks at the names mean, notes on filters, and which are missing and why."""
    lines = []
    fitted = {name: race.entrants[name] for name in race.tallies if race.entrants[name].fitted}
    here = [f"{name} ({e.fitted})" for name, e in fitted.items() if not e.in_sample]
    seen = [name for name, e in fitted.items() if e.in_sample]
    if here:
        source = "this scenario (other runs of it)" if race.unit == "runs" else "other rows of this file"
        lines.append(f"* fitted on {source}: {', '.join(here)}")
    if seen:
        lines.append(f"** fitted on the seed of this race, so not compared with the others: {', '.join(seen)}")
    worse = [name for name in race.tallies if race.worse_than_raw(name)]
    if worse:
        lines.append(f"! worse than not filtering: {', '.join(worse)}")
    lines += [f"{n}: {race.entrants[n].note}" for n in race.tallies if race.entrants[n].note]
    lines += [f"without {name}: {why}" for name, why in race.skipped.items()]
    return lines


def verdicts(race: Race, name: str) -> str:
    """Which filters it is better or worse than in the first metric, by the paired 95% intervals."""
    if name in (*AGAINST, "clairvoyant", "near-optimal") or race.entrants[name].in_sample:
        return ""
    metric = race.compared[0]
    groups: dict[str, list[str]] = {"better": [], "worse": [], "undecided": []}
    for other in AGAINST:
        if other in race.tallies:
            c = race.compare(name, other, metric)
            if math.isfinite(c.difference):
                groups[c.verdict].append(f"{other} ({c.low:+.3g} … {c.high:+.3g} m)")
    said: list[Any] = [
        f"{'not told apart from' if verdict == 'undecided' else verdict + ' than'} {', '.join(others)}"
        for verdict, others in groups.items()
        if others
    ]
    return "; ".join(said)
