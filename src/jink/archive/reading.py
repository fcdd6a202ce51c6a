"""Measurements out of a folder of tracks: whole targets, as many as are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl

from ..io.measurements import Measurements
from . import job as names
from .errors import Stopped
from .gathering import gather, kind_of, places
from .manifest import Plan, incomplete, manifest_of
from .store import Store

ROWS = 200_000  # of a sample, about


def sample(path: str | Path, rows: int = ROWS) -> tuple[Measurements, str]:
    """What was measured of whole targets, and in words how many they are. They have the lowest hash of their names.
    Errors: Stopped.
    """
    store = Store(str(path))
    plan, manifest = Plan.read(store), manifest_of(store)
    if plan is None or manifest is None:
        raise incomplete(path)
    said = [_said(store, number) for number in range(len(plan.inputs))]
    kind = kind_of(said)
    frames: list[pl.DataFrame] = []
    for bucket in range(plan.buckets):
        frames.append(gather(store, kind, places(said, bucket)))
        if sum(frame.height for frame in frames) >= rows:
            break
    whole = pl.concat(frames)
    counts = whole.group_by("target").len("rows").sort(pl.col("target").hash(seed=1), "target")
    some = counts.filter(pl.col("rows").cum_sum() <= rows) if whole.height > rows else counts
    if not some.height:
        some = counts.head(1)
    found = whole.join(some.select("target"), on="target", how="semi", maintain_order="left")
    words = f"a sample of {some.height:,} of {_count(store, said):,} targets of {path}"
    return kind.measurements(found), words


def _count(store: Store, said: list[dict[str, Any]]) -> int:
    """The number of targets in all files."""
    found = pl.Series("target", [], dtype=pl.String)
    for number, each in enumerate(said):
        if each["parts"] and (content := store.get(names.targets(number))) is not None:
            found = pl.concat([found, pl.read_ipc(content)["target"]]).unique()
    return len(found)


def _said(store: Store, number: int) -> dict[str, Any]:
    import json

    content = store.get(names.mapped(number))
    if content is None:
        raise Stopped(f"{store.where} has no {names.mapped(number)} any more, so its measurements cannot be read")
    return json.loads(content)
