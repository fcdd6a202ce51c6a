"""Which column names the target: one whose values come back, not one that numbers the rows."""

from __future__ import annotations

import polars as pl

from .columns import normal
from .sheet import Sheet

FEW = 8  # rows: fewer say nothing about an identifier
# registered identities stay what they are, even where each occurs once
REGISTERED = {"icao24", "icao", "hex", "hexident", "hex_ident", "mmsi", "imo", "registration", "tail", "callsign"}


def unique_per_row(series: pl.Series) -> bool:
    """Whether every row has a value of its own, so that no target would have two positions."""
    known = series.drop_nulls()
    # the first ones tell most tables
    return len(known) >= FEW and all(some.n_unique() == len(some) for some in (known.head(1000), known))


def choose_target(sheet: Sheet) -> None:
    """Take another identifier where the usual one is different in every row, or none; said in a note."""
    if "target" not in sheet or "target" in sheet.told or not unique_per_row(sheet.series("target")):
        return
    name = sheet.roles["target"].name
    rows = sheet.frame.height
    for other in sheet.others.get("target", ()):
        if sheet.frame[other.name].drop_nulls().n_unique() <= rows / 2 and sheet.frame[other.name].count() > rows / 2:
            sheet.roles["target"] = other
            sheet.notes.append(
                f"column {name!r} is different in every row, so column {other.name!r} is taken for the target; "
                "--columns target=... names another"
            )
            return
    at_one_time = sheet.series("time").n_unique() < rows / 2
    if normal(name) not in REGISTERED and not at_one_time:
        sheet.drop("target")
        sheet.notes.append(f"column {name!r} is different in every row, so it numbers the rows and names no target")
