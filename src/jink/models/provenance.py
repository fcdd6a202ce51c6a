"""Where a fitted model comes from: it travels with the model into every file."""

from collections.abc import Sequence

from ..frozen import frozen

VERSION = "0.1.0"


@frozen(kw_only=True)
class Trained:
    """What a model was trained on and how, and what it reached on runs it had not seen.

    data: scenario or file with its runs; method; seeds; figures: (what, value) pairs on unseen runs; version of jink.
    """

    data: str
    method: str
    seeds: Sequence[int] = ()
    figures: Sequence[Sequence[str | float]] = ()
    version: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "seeds", tuple(int(seed) for seed in self.seeds))
        object.__setattr__(self, "figures", tuple((str(what), float(value)) for what, value in self.figures))
