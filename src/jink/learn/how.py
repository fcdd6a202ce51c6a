"""What `jink learn` was asked for."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from ..frozen import frozen

SHARES = (0.01, 0.1, 1.0)  # of the kind's acceleration: inputs of the sub-models, as in the paper
RANGE = (1e-3, 3.0)  # of the kind's acceleration: sds of noise that networks choose from


@frozen(kw_only=True)
class How:
    """What `jink learn` was asked for; None where the recipe has a default of its own.

    acceleration (m/s²): what the targets pull; process_sd (m/s²): of the noise that drives them without a manoeuvre, by
    default a hundredth of that; inputs: those of the sub-models; own_inputs: each sub-model learns on a target of its
    own input instead of the data; along_track: rules hold along and across the track. base: the filter to be aided;
    aid_inputs: what its aid looks at; functions, membership, method: of an ANFIS how many functions each input has, of
    which form, and how they are trained. labels: networks learn which mode was right instead of the tracking error,
    "argmin" as published. bank: the kinds of motion that a network scores, names of ``jink.learn.recipes.BANK``. kind
    of the targets; families: how many random ones a corrector learns on, besides the data. progress(words, done, of) is
    called as it goes on; checkpoint: of searches by populations.
    """

    acceleration: float
    kind: str = "aircraft"
    process_sd: float | None = None
    seed: int = 0
    optimiser: str = "ga"
    generations: int | None = None
    population: int | None = None
    rules: int | None = None
    weight: float = 0.95
    inputs: tuple[float, ...] = ()
    own_inputs: bool = False
    along_track: bool = False
    base: Any = None
    epochs: int | None = None
    aid_inputs: str = "innovations"
    functions: int | None = None
    membership: str | None = None
    method: str | None = None
    labels: bool | str = False
    bank: tuple[str, ...] = ()
    families: int | None = None
    checkpoint: str | os.PathLike[str] | None = None
    progress: Callable[[str, int, int], None] | None = None

    @property
    def quiet_sd(self) -> float:
        """√q of eq. 15, m/s²: the target's own process noise, the same for every sub-model."""
        return SHARES[0] * self.acceleration if self.process_sd is None else self.process_sd

    def given(self, **names: str) -> dict[str, Any]:
        """Keywords of those attributes that were asked for: keyword=attribute."""
        return {key: getattr(self, name) for key, name in names.items() if getattr(self, name) is not None}

    def counting(self, words: str, of: int) -> Callable[[int, float], None] | None:
        """A progress for loops that tell their step and the least loss."""
        tell = self.progress
        return None if tell is None else lambda step, loss: tell(f"{words}: least loss {loss:.4g}", step + 1, of)
