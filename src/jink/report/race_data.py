"""What the page of a race draws: errors over time, one run, mode probabilities, and the table's columns."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..compare.example import Example
from ..compare.result import AGAINST, Race
from ..metrics import Figure
from ..metrics.figure import student_quantile
from .arrays import ArrayBlock, round_mantissa
from .race_table import AROUND, COLUMNS, SHARES, label, ordered

YARDSTICKS = ("raw", "clairvoyant", "near-optimal")
OVER_TIME = {
    "position": ("Position RMSE", "length"),
    "velocity": ("Velocity RMSE", "speed"),
    "acceleration": ("Acceleration RMSE", "acceleration"),
}
TITLES = {**AROUND, **COLUMNS, "log_score": "ln p(truth)", "prediction_score": "ln p(next z)"} | {
    "nees": "NEES mean",
    "nis": "NIS mean",
    "estimated": "estimated",
    "velocity_efficiency": "vel. efficiency",
    "position_efficiency": "pos. efficiency",
    "onset_settling": "onset settles scans",
    "end_settling": "end settles scans",
    "us_per_update": "µs per update",
}
PERCENT = (*SHARES, "estimated")


def series(race: Race) -> list[dict[str, Any]]:
    """Every filter: name, label with its marks, what it is, and whether it is a yardstick."""
    return [
        {
            "name": name,
            "label": label(race, name),
            "words": race.entrants[name].words,
            "yardstick": name in YARDSTICKS,
            "worse": race.worse_than_raw(name),
        }
        for name in ordered(race)
    ]


def columns(race: Race) -> list[dict[str, Any]]:
    """A column per metric: values, half widths of their 95% intervals, and what is shown, in the order of series; last
    the bound.
    """
    names = ordered(race)
    figures = {name: race.figures(name) for name in names}
    metrics = [m for m in dict.fromkeys((*race.metrics, *_efficiencies(race))) if any(m in figures[n] for n in names)]
    out = []
    for metric in metrics:
        found = [figures[name].get(metric) for name in names]
        title, _, unit = _title(metric)
        bound = race.bound.get(metric)
        out.append(
            {
                "key": metric,
                "title": title,
                "unit": unit,
                "value": [*(None if f is None else f.value for f in found), bound],
                "text": [
                    *(interval_text(metric, f, race.runs) for f in found),
                    "–" if bound is None else f"{bound:.4g}",
                ],
            }
        )
    return out


def _efficiencies(race: Race) -> tuple[str, ...]:
    return ("position_efficiency", "velocity_efficiency") if "near-optimal" in race.tallies else ()


def _title(metric: str) -> tuple[str, str, str]:
    """A column's title and unit apart."""
    title = TITLES.get(metric, metric.replace("_", " ")).strip()
    return title.rpartition(" ") if title.rpartition(" ")[2] in ("m", "m/s", "m/s²", "scans", "µs") else (title, "", "")


def interval_text(metric: str, figure: Figure | None, runs: int) -> str:
    """A value ± half its 95% interval, to the digits that this leaves."""
    if figure is None or math.isnan(figure.value):
        return "–"
    if math.isinf(figure.value):
        return "never"
    factor, unit = (100.0, " %") if metric in PERCENT else (1.0, "")
    value, half = factor * figure.value, factor * half_width(figure, runs)
    if not half > 0:
        return f"{value:.4g}{unit}".replace("-", "−")
    digits = min(max(1 - math.floor(math.log10(half)), 0), 6)
    return f"{value:,.{digits}f} ± {half:.{digits}f}{unit}".replace(",", "\u202f").replace("-", "−")


def half_width(figure: Figure, runs: int) -> float:
    """Of the 95% interval of a figure from so many runs."""
    return student_quantile(0.975, runs - 1) * figure.se if runs > 1 else math.nan


def comparisons(race: Race) -> list[dict[str, Any]]:
    """Paired differences to those that are always there, in the first metric that is compared."""
    metric = race.compared[0]
    rows = []
    for name in ordered(race):
        if race.entrants[name].in_sample:
            continue
        row: dict[str, Any] = {"name": name}
        for other in AGAINST:
            if other in race.tallies and other != name:
                c = race.compare(name, other, metric)
                if math.isfinite(c.difference):
                    row[other] = c
        rows.append(row)
    return rows


def panels(race: Race, block: ArrayBlock) -> list[dict[str, Any]]:
    """The charts: errors over time with their standard errors, then what one run shows; arrays go to the block."""
    shown: list[tuple[str, str, str, dict[str, tuple[np.ndarray, np.ndarray]]]] = []
    names = ordered(race)
    if race.unit == "runs":
        for key, (title, quantity) in OVER_TIME.items():
            curves = {n: race.tallies[n].over_time(key) for n in names if f"{key}_square" in race.tallies[n].curves}
            if any(np.isfinite(value).any() for value, _ in curves.values()):
                shown.append((key, title, quantity, curves))
    if race.example is not None:
        for key, (title, quantity, curves) in race.example.curves.items():
            plain = {n: (c, np.full(len(c), np.nan)) for n, c in curves.items() if n in names}
            shown.append((key, title, quantity, plain))
    scans = len(race.example.time) if race.example is not None else 0
    out = []
    for key, title, quantity, curves in shown:
        entries = []
        for name, (value, se) in curves.items():
            lead = np.full(max(scans - len(value), 0), np.nan)
            array = f"{key}_{names.index(name)}"
            block.add(array, round_mantissa(np.concatenate([lead, value]), 16))
            block.add(f"{array}_se", round_mantissa(np.concatenate([lead, se]), 8))
            entries.append({"series": names.index(name), "array": array})
        out.append({"key": key, "title": title, "quantity": quantity, "curves": entries})
    return out


def run(example: Example, names: list[str], block: ArrayBlock) -> dict[str, Any]:
    """Truth, measurements, tracks and mode probabilities of one run; arrays go to the block."""
    plane = example.measured.shape[1] > 1
    block.add("time", example.time, "f8")
    busy = example.busy if example.busy is not None else np.zeros(len(example.time))
    block.add("busy", busy.astype(np.uint8), "u1")
    modes: dict[str, Any] = {}
    if plane:
        _add_plane(block, "measured", example.measured)
        if example.truth is not None:
            _add_plane(block, "truth", example.truth)
    drawn = []
    for name, track in example.tracks.items():
        k = names.index(name)
        if plane:
            _add_plane(block, f"track_{k}", track.position)
            drawn.append(k)
        if track.probability is not None:
            for m, values in enumerate(track.probability.T):
                code = np.round(np.clip(values, 0.0, 1.0) * 254.0)
                block.add(f"modes_{k}_{m}", np.where(np.isfinite(code), code, 255), "u1")
            modes[str(k)] = list(track.modes)
    return {
        "name": example.name,
        "plane": plane,
        "truth": plane and example.truth is not None,
        "tracks": drawn,
        "modes": modes,
    }


def _add_plane(block: ArrayBlock, name: str, position: np.ndarray) -> None:
    block.add(f"{name}_x", position[:, 0], "f8")
    block.add(f"{name}_y", position[:, 1], "f8")
