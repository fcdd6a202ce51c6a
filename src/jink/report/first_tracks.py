"""The first few tracks as a table on the terminal, for those who gave no output."""

from __future__ import annotations

import math

import polars as pl

from .terminal import print_line, print_table, standard_output

FEW = 10


def show_first(tracks: pl.DataFrame) -> None:
    """One line per part: its target, rows, duration, and where it was going at its end."""
    ends = tracks.group_by("target", "part", maintain_order=True).agg(
        pl.len().alias("rows"),
        pl.col("time").first().alias("start"),
        pl.col("time").last().alias("end"),
        pl.col("speed").median().alias("speed"),
        pl.col("speed").last().alias("last"),
        pl.col("course").last(),
    )
    rows = []
    for line in ends.head(FEW).iter_rows(named=True):
        span = line["end"] - line["start"]
        seconds = span.total_seconds() if hasattr(span, "total_seconds") else float(span)
        course = "" if line["course"] is None else f"{math.degrees(line['course']):.0f}°"
        speeds = [f"{line[name]:.1f} m/s" if line[name] is not None else "" for name in ("speed", "last")]
        rows.append([str(line["target"]), str(line["part"]), f"{line['rows']:,}", f"{seconds:.0f} s", *speeds, course])
    console = standard_output()
    print_line(console)
    print_table(console, ["target", "part", "rows", "duration", "median speed", "last speed", "last course"], rows)
    if ends.height > FEW:
        print_line(console, f"and {ends.height - FEW:,} more; -o tracks.parquet writes every estimate")
    else:
        print_line(console, "-o tracks.parquet writes every estimate")
