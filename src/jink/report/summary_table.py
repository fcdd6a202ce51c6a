"""The summary of a run: one line for each question that someone asks after it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..io.printable import printable
from ..tracking.summary import CLEANED
from .terminal import standard_output

UNUSED = 12  # columns that are named
# what noise is said of, its unit, and how many of that are one SI unit
FIGURES = {
    "position": ("m", 1.0),
    "altitude": ("m", 1.0),
    "range": ("m", 1.0),
    "azimuth": ("mrad", 1000.0),
    "elevation": ("mrad", 1000.0),
    "velocity": ("m/s", 1.0),
    "vertical_rate": ("m/s", 1.0),
    "range_rate": ("m/s", 1.0),
}


def show(summary: dict[str, Any]) -> None:
    """Print the summary on standard output, in colour if the terminal has it."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in lines(summary):
        table.add_row(name, Text(printable(text)))
    standard_output().print(table)


def lines(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Name and text of every line; a name that repeats is left empty."""
    rejected = sum(summary["rejected"].values())
    yield "Rows", f"{summary['rows']:,} read, {summary['accepted']:,} in tracks, {rejected:,} rejected"
    yield from _listed("Rejected", [f"{count:,}  {reason}" for reason, count in summary["rejected"].items()])
    parts = f" in {_plural(summary['parts'], 'part')}"
    rule = f" (a new part after {summary['gap_seconds']:g} s without position)"
    yield "Targets", f"{summary['targets']:,}" + ("" if "association" in summary else parts + rule)
    yield "Time", _times(summary["start"], summary["end"])
    yield (
        "Columns",
        ", ".join(f"{role} = {name}" if role != name else role for role, name in summary["columns"].items()),
    )
    unused = summary.get("unused_columns", [])
    if unused:
        yield (
            "Not used",
            ", ".join(unused[:UNUSED]) + (f" and {len(unused) - UNUSED} more" if len(unused) > UNUSED else ""),
        )
    done = [
        f"{count:,}  {CLEANED[name]}"
        for name, count in summary["cleaning"].items()
        if count and "rejected" not in CLEANED[name]
    ]
    yield from _listed("Cleaning", done or ["nothing to do"])
    yield from _listed("Noise", list(_noise(summary["noise"], summary["files"])))
    how = "smoothed" if summary["smoothed"] else "filtered"
    how += f" with a lag of {summary['lag']}" if "lag" in summary else ""
    yield from _listed(
        "Filter",
        [f"{text}, {how}, for {summary['kind']}, {axes}" for axes, text in summary["filter"].items()],
    )
    yield "Status", ", ".join(f"{count:,} {status}" for status, count in summary["status"].items())
    if summary["consistency"]:
        share, mean = summary["consistency"]["inside_95"], summary["consistency"]["mean_per_dimension"]
        yield (
            "NIS",
            f"{100 * share:.1f} % inside the 95 % band, mean per dimension {mean:.2f} "
            "(1: consistent, of a mixture only roughly)",
        )
    yield from _listed("Warning", [warning["message"] for warning in summary["warnings"]])
    yield from _listed("Note", summary["notes"])
    yield from _listed("Written", [f"{path} ({_size(_bytes(Path(path)))})" for path in summary.get("written", [])])
    yield "Took", f"{summary['seconds']:.1f} s"


def _noise(sources: list[dict[str, Any]], files: list[str]) -> Iterator[str]:
    """The noise of the first few sources: where each figure comes from, and its range over the targets.

    Of a file the last part of its path is shown, unless several have that.
    """
    shown = [Path(line["source"]).name if line["source"] in files else line["source"] for line in sources]
    for line, name in zip(sources[:3], shown, strict=False):
        pieces = [_figure(line, name) for name in FIGURES]
        if line.get("time_sd"):
            pieces.insert(1, f"time stamps {line['time_sd']:.2g} s")
        where = f"{name if shown.count(name) == 1 else line['source']}: " if len(sources) > 1 else ""
        yield where + ", ".join(filter(None, pieces))
    if len(sources) > 3:
        yield f"and {len(sources) - 3} more sources (--json lists them)"


def _figure(line: dict[str, Any], name: str) -> str:
    if f"{name}_sd" not in line:
        return ""
    unit, factor = FIGURES[name]
    origin = line[f"{name}_sd_from"]
    if f"{name}_sd_range" in line and origin == "estimated":
        low, high = (_short(factor * value) for value in line[f"{name}_sd_range"])
        origin += f"; {low} to {high} {unit} by target" if low != high else ""
    stated = line.get(f"{name}_sd_stated_rows")
    origin += f"; as the source states in {stated:,} rows" if stated else ""
    return f"{name.replace('_', ' ')} {_short(factor * line[f'{name}_sd'])} {unit} ({origin})"


def _short(value: float) -> str:
    """Two digits, and no power of ten for what is larger."""
    return f"{value:.2g}" if value < 100.0 else f"{float(f'{value:.2g}'):.0f}"


def _times(start: Any, end: Any) -> str:
    """Start and end; the date stands once if it is the same."""
    if not isinstance(start, str):
        return f"{start:g} to {end:g} s"
    first, last = (text.replace("T", " ").replace(".000", "").removesuffix("+00:00") for text in (start, end))
    return f"{first} to {last[11:] if last[:10] == first[:10] else last} UTC"


def _listed(name: str, texts: list[str]) -> Iterator[tuple[str, str]]:
    for number, text in enumerate(texts):
        yield name if number == 0 else "", text


def _plural(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def _bytes(path: Path) -> int:
    """The size of a file, or of all files in a folder."""
    files = path.rglob("*") if path.is_dir() else [path]
    return sum(each.stat().st_size for each in files if each.is_file())


def _size(count: float) -> str:
    for unit in ("B", "kB", "MB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} GB"
