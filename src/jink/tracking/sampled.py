"""Whole targets of a table of tracks that is too large for a page, drawn by their names."""

from __future__ import annotations

from dataclasses import dataclass, field

import polars as pl

MOST = 500_000  # rows of tracks that are kept: about 400 MB
WHOLE = 2**64


@dataclass
class Sampled:
    """Tracks that come table by table, of which at most about `most` rows are kept.

    Every target has the same chance, whatever its length: it is kept where the hash of its name lies below a limit,
    which is halved when the rows become too many. A single target of more rows is kept whole.
    """

    most: int = MOST
    below: int = WHOLE
    targets: int = 0
    rows: int = 0
    kept: list[pl.DataFrame] = field(default_factory=list)

    def take(self, tracks: pl.DataFrame) -> pl.DataFrame:
        """Keep some of a table's targets; the table is given back."""
        self.targets += tracks["target"].n_unique()
        self.rows += tracks.height
        self.kept.append(self._drawn(tracks))
        while sum(one.height for one in self.kept) > self.most and self.names() > 1:
            self.below //= 2
            left = [self._drawn(one) for one in self.kept]
            if not any(one.height for one in left):
                self.below *= 2
                break
            self.kept = left
        return tracks

    def _drawn(self, tracks: pl.DataFrame) -> pl.DataFrame:
        if self.below == WHOLE:
            return tracks
        return tracks.filter(pl.col("target").cast(pl.String).hash(seed=0) < self.below)

    def names(self) -> int:
        """How many targets are kept."""
        return sum(one["target"].n_unique() for one in self.kept)

    def tracks(self) -> pl.DataFrame:
        """What was kept, in its order."""
        return pl.concat(self.kept, how="diagonal")

    def said(self) -> str:
        """What the page says of it; nothing where all is kept."""
        kept = sum(one.height for one in self.kept)
        if kept == self.rows:
            return ""
        return (
            f"This page shows a sample: {self.names():,} of {self.targets:,} targets with {kept:,} of {self.rows:,} "
            "rows, drawn by their names, because the table is larger than --memory."
        )
