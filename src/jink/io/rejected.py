"""Rows that do not become part of a track: which, and why. Nothing is dropped silently."""

from __future__ import annotations

from collections.abc import Sequence

import polars as pl

SCHEMA = {"file": pl.String, "row": pl.UInt32, "target": pl.String, "reason": pl.String, "value": pl.String}


def unreadable(rows: Sequence[int] = (), reasons: Sequence[str] = (), values: Sequence[str] = ()) -> pl.DataFrame:
    """Rows of one file that could not be read at all: number, reason, beginning of their text."""
    return pl.DataFrame(
        {"row": list(rows), "reason": list(reasons), "value": list(values)},
        schema={"row": pl.UInt32, "reason": pl.String, "value": pl.String},
    )


def together(frames: Sequence[pl.DataFrame]) -> pl.DataFrame:
    """All rejected rows as one table of file, row, target, reason and value, in the order of the input."""
    complete = [
        frame.select(
            (pl.col(name) if name in frame.columns else pl.lit(None)).cast(kind).alias(name)
            for name, kind in SCHEMA.items()
        )
        for frame in frames
        if frame.height
    ]
    if not complete:
        return pl.DataFrame(schema=SCHEMA)
    return pl.concat(complete).sort("file", "row", maintain_order=True)
