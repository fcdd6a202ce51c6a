"""A learned correction of position and velocity in the plane, along and across the course."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..checks import numbers, positive
from ..frozen import frozen
from .provenance import Trained

ODD = 6  # inputs that change sign when the plane is mirrored along the course
BOUND = 3.0  # of what the network remembers
ANSWERS = (3, 2)  # even ones: along in position and velocity, and of P; odd ones: across in position and velocity


def even_inputs(modes: int) -> int:
    """How many inputs stay as they are when the plane is mirrored, for a filter of so many modes."""
    return 12 + 2 * (modes - 1)


@frozen(kw_only=True)
class PlaneCorrector:
    """What an IMM's estimate of position and velocity in the plane lacks, in units of its own sds.

    low, high, centre, scale, one number per input: first the even ones, then the ``ODD`` odd ones; the equations and
    the list of inputs are in docs/corrector.md. The hidden layer of H units sees the inputs and what it remembers of
    the scans before: a (R,), which stays as it is when the plane is mirrored, and o (R,), which changes sign. even (H,
    even inputs + R), odd (H, ODD + R), bias (H,), h± = max(0, even (u, a) + bias ± odd (w, o)); along (3, H) and
    along_bias (3,), of (h+ + h−)/2; across (2, H), of (h+ − h−)/2. keep (R,), recall (R, H), recall_bias (R,),
    recall_across (R, H): after a scan a is keep a + (1 − keep) clip(recall (h+ + h−)/2 + recall_bias, ± ``BOUND``), and
    o likewise of recall_across (h+ − h−)/2. Without them nothing is remembered here. The engine computes the layers in
    single precision: corrections are exact to some 1e-6 of the estimate's sds.

    fade: outside the range of the training, in widths of the range, where the correction has faded to nothing. trust
    and memory: the correction is weighted by (trust + Σ ν·d) / (trust + Σ d·d), within 0 and 1, where d is what the
    corrections before said of the innovation ν, and both sums fade by ``memory`` per scan.
    Errors: ValueError where these do not fit.
    """

    low: Sequence[float]
    high: Sequence[float]
    centre: Sequence[float]
    scale: Sequence[float]
    even: Sequence[Sequence[float]]
    odd: Sequence[Sequence[float]]
    bias: Sequence[float]
    along: Sequence[Sequence[float]]
    along_bias: Sequence[float]
    across: Sequence[Sequence[float]]
    keep: Sequence[float] = ()
    recall: Sequence[Sequence[float]] = ()
    recall_bias: Sequence[float] = ()
    recall_across: Sequence[Sequence[float]] = ()
    fade: float = 0.25
    trust: float = 1.0
    memory: float = 0.98
    trained: Trained | None = None

    LAYERS: ClassVar[tuple[str, ...]] = (
        *("even", "odd", "bias", "along", "along_bias", "across"),
        *("keep", "recall", "recall_bias", "recall_across"),
    )

    def __post_init__(self) -> None:
        ranges = ("low", "high", "centre", "scale")
        given = {name: numbers(f"PlaneCorrector.{name}", getattr(self, name)) for name in (*ranges, *self.LAYERS)}
        inputs, hidden, kept = given["low"].size, given["bias"].size, given["keep"].size
        shapes = dict.fromkeys(ranges, (inputs,)) | self._shapes(inputs - ODD, hidden, kept)
        if inputs <= ODD:
            raise ValueError(f"PlaneCorrector.low: expected more than {ODD} numbers, one per input, got {inputs}")
        if not hidden:
            raise ValueError("PlaneCorrector.bias: expected one number for each unit of a hidden layer, got none")
        for name, shape in shapes.items():
            values = given[name] if given[name].size or 0 not in shape else np.zeros(shape)
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(f"PlaneCorrector.{name}: expected finite numbers of shape {shape}, got {values.shape}")
            object.__setattr__(self, name, values.tolist())
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError("PlaneCorrector.low: expected to lie below high")
        if not all(s > 0 for s in self.scale):
            raise ValueError("PlaneCorrector.scale: expected positive numbers")
        if not all(0 <= k < 1 for k in self.keep):
            raise ValueError("PlaneCorrector.keep: expected numbers from 0 to less than 1")
        positive("PlaneCorrector.fade", self.fade)
        positive("PlaneCorrector.trust", self.trust)
        if positive("PlaneCorrector.memory", self.memory) > 1:
            raise ValueError(f"PlaneCorrector.memory: expected more than 0 and at most 1, got {self.memory!r}")

    @staticmethod
    def _shapes(even: int, hidden: int, kept: int) -> dict[str, tuple[int, ...]]:
        return {
            "even": (hidden, even + kept),
            "odd": (hidden, ODD + kept),
            "bias": (hidden,),
            "along": (ANSWERS[0], hidden),
            "along_bias": (ANSWERS[0],),
            "across": (ANSWERS[1], hidden),
            "keep": (kept,),
            "recall": (kept, hidden),
            "recall_bias": (kept,),
            "recall_across": (kept, hidden),
        }

    @property
    def modes(self) -> int:
        """Of the filter that it corrects."""
        return (len(self.low) - ODD - 12) // 2 + 1

    @property
    def hidden(self) -> int:
        """Units of the hidden layer."""
        return len(self.bias)

    @property
    def sizes(self) -> list[int]:
        """Units of the hidden layer, and quantities of each kind that they remember, where there are any."""
        return [self.hidden, *([len(self.keep)] if self.keep else [])]

    def numbers(self) -> list[float]:
        """All of them, as the engine reads them."""
        ranges = [float(v) for four in zip(self.low, self.high, self.centre, self.scale, strict=True) for v in four]
        layers = [np.asarray(getattr(self, name), dtype=float).ravel() for name in self.LAYERS]
        return [*ranges, float(self.fade), float(self.trust), float(self.memory), *np.concatenate(layers).tolist()]
