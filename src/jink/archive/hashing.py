"""Which bucket a target is in: buckets are ranges of a hash of its name, so that a sample by hash is in the first ones.

`tracking.prepare.drawn` takes the targets of the lowest hash; both use the same one.
"""

from __future__ import annotations

import polars as pl

RANGE = 2**64
PROBE = ("", "0", "4ca7b3", "211234560", "île")


def bucket_of(targets: pl.Series, buckets: int) -> pl.Series:
    """The number of each target's bucket; rows without a target cannot be."""
    step = -(-RANGE // buckets)
    return (targets.hash(seed=1) // step).cast(pl.UInt32).alias("bucket")


def probe() -> list[int]:
    """What this version of polars makes of some names; another version may differ."""
    return pl.Series(PROBE).hash(seed=1).to_list()
