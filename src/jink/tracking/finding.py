"""One thing that cannot be true of tracks, and how it is said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import polars as pl

from ..frozen import frozen

NAMED = 5  # targets that a finding names


@frozen
class Finding:
    """One thing that cannot be true.

    code: its name in `--json`; what was found; targets it holds for, the first few by name; count of them and of rows;
    likely reason; mend: the option; fatal: nothing can be made of these targets.
    """

    code: str
    what: str
    targets: Sequence[str]
    count: int
    rows: int
    likely: str
    mend: str
    fatal: bool = False

    def sentence(self, of: int) -> str:
        """For people; `of` is the number of all targets."""
        if self.count == of:
            who = "all targets" if of > 1 else f"target {self.targets[0]}"
        else:
            who = ", ".join(self.targets) + (f" and {self.count - NAMED} more" if self.count > NAMED else "")
            who = f"target{'s' if self.count > 1 else ''} {who}"
        return f"{who}: {self.what}. Likely: {self.likely}. {self.mend}"


def as_dicts(found: Sequence[Finding], targets: int) -> list[dict[str, Any]]:
    """What `--json` writes under `warnings`, with the sentence for people as `message`."""
    return [
        asdict(finding) | {"targets": list(finding.targets), "message": finding.sentence(targets)} for finding in found
    ]


def named(some: pl.DataFrame) -> dict[str, Any]:
    """The targets of these rows, how many they are, and how many rows they have."""
    return {"targets": some["target"].head(NAMED).to_list(), "count": some.height, "rows": int(some["measured"].sum())}


def range_of(values: pl.Series) -> str:
    """The least and the largest value, in words."""
    low, high = float(values.to_numpy().min()), float(values.to_numpy().max())
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
