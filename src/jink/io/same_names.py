"""Names of targets over all inputs: those that hold inside one file alone, and addresses in two spellings."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import PurePath

import polars as pl

from .columns import normal
from .measurements import Measurements

ADDRESSES = {"icao24", "icao", "hex", "hexident", "hex_ident", "address"}
ADDRESS = re.compile("[0-9A-Fa-f]{6}")


def keep_apart(parts: Sequence[Measurements], files: Sequence[str], local: Sequence[bool]) -> None:
    """Put the file's name before those of its targets, in place, where two local files have one name at one time.

    local: whether the names of a part hold in its file alone. Positions without a column of identity are local too;
    the plots of several radars, in ranges and angles, are of one target.
    """
    inside = [
        i for i, part in enumerate(parts) if local[i] or ("target" not in part.named and part.position != "polar")
    ]
    if len(inside) < 2 or not _meet([parts[i] for i in inside]):
        return
    common = os.path.commonpath([PurePath(files[i]).parent for i in inside])
    for i in inside:
        path = PurePath(files[i]).relative_to(common) if common else PurePath(files[i])
        name = path.with_suffix("").as_posix()
        own = "target" in parts[i].named
        renamed = pl.lit(f"{name}/") + pl.col("target") if own else pl.lit(name)
        parts[i].rows = parts[i].rows.with_columns(target=renamed)
        parts[i].rejected = [
            frame.with_columns(target=renamed) if "target" in frame.columns else frame for frame in parts[i].rejected
        ]
        parts[i].notes.append(
            "several files name their targets alike at the same times: the file's name stands before the target's"
        )


def one_spelling(parts: Sequence[Measurements]) -> None:
    """Aircraft addresses in capital and in small letters (SBS-1 and readsb) are one target, in place, as first written.

    Only addresses of 24 bits in hexadecimal are: other names may differ by their letters alone.
    """
    addressed = [part for part in parts if normal(part.named.get("target", "")) in ADDRESSES]
    names = [name for part in addressed for name in part.rows["target"].unique(maintain_order=True).drop_nulls()]
    first: dict[str, str] = {}
    other: dict[str, str] = {}
    for name in names:
        if ADDRESS.fullmatch(name) and first.setdefault(name.lower(), name) != name:
            other[name] = first[name.lower()]
    if not other:
        return
    for part in addressed:
        part.rows = part.rows.with_columns(pl.col("target").replace(other))
    addressed[0].notes.append(
        f"addresses in capital and in small letters ({len(set(other.values()))}) are each one target"
    )


def _meet(parts: Sequence[Measurements]) -> bool:
    """Whether one name stands in two files whose times overlap."""
    spans = pl.concat(
        part.rows.group_by("target").agg(first=pl.col("time").min(), last=pl.col("time").max()) for part in parts
    )
    ordered = spans.sort("target", "first").select(
        late=pl.col("first").shift(-1).over("target") <= pl.col("last"),
    )
    return bool(ordered["late"].any())
