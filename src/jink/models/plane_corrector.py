"""A learned correction of position and velocity in the plane, along and across the course."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..checks import numbers, positive
from ..frozen import frozen
from .provenance import Trained

ODD = 6  # inputs that change sign when the plane is mirrored along the course
ANSWERS = (3, 2)  # even ones: along in position and velocity, and of P; odd ones: across in position and velocity


def even_inputs(modes: int) -> int:
    """How many inputs stay as they are when the plane is mirrored, for a filter of so many modes."""
    return 12 + 2 * (modes - 1)


@frozen(kw_only=True)
class PlaneCorrector:
    """What an IMM's estimate of position and velocity in the plane lacks, in units of its own sds.

    low, high, centre, scale, one number per input: first the even ones, then the ``ODD`` odd ones; the equations and
    the list of inputs are in docs/corrector.md. even (H, even inputs), odd (H, ODD) and bias (H,) of the hidden layer,
    h± = max(0, even u + bias ± odd w); along (3, H) and along_bias (3,), of (h+ + h−)/2; across (2, H), of
    (h+ − h−)/2.

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
    fade: float = 0.25
    trust: float = 4.0
    memory: float = 0.98
    trained: Trained | None = None

    LAYERS: ClassVar[tuple[str, ...]] = ("even", "odd", "bias", "along", "along_bias", "across")

    def __post_init__(self) -> None:
        ranges = ("low", "high", "centre", "scale")
        given = {name: numbers(f"PlaneCorrector.{name}", getattr(self, name)) for name in (*ranges, *self.LAYERS)}
        inputs, hidden = given["low"].size, given["bias"].size
        shapes = {
            **dict.fromkeys(ranges, (inputs,)),
            "even": (hidden, inputs - ODD),
            "odd": (hidden, ODD),
            "bias": (hidden,),
            "along": (ANSWERS[0], hidden),
            "along_bias": (ANSWERS[0],),
            "across": (ANSWERS[1], hidden),
        }
        if inputs <= ODD:
            raise ValueError(f"PlaneCorrector.low: expected more than {ODD} numbers, one per input, got {inputs}")
        if not hidden:
            raise ValueError("PlaneCorrector.bias: expected one number for each unit of a hidden layer, got none")
        for name, shape in shapes.items():
            values = given[name]
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(f"PlaneCorrector.{name}: expected finite numbers of shape {shape}, got {values.shape}")
            object.__setattr__(self, name, values.tolist())
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError("PlaneCorrector.low: expected to lie below high")
        if not all(s > 0 for s in self.scale):
            raise ValueError("PlaneCorrector.scale: expected positive numbers")
        positive("PlaneCorrector.fade", self.fade)
        positive("PlaneCorrector.trust", self.trust)
        if positive("PlaneCorrector.memory", self.memory) > 1:
            raise ValueError(f"PlaneCorrector.memory: expected more than 0 and at most 1, got {self.memory!r}")

    @property
    def modes(self) -> int:
        """Of the filter that it corrects."""
        return (len(self.low) - ODD - 12) // 2 + 1

    @property
    def hidden(self) -> int:
        """Units of the hidden layer."""
        return len(self.bias)

    def numbers(self) -> list[float]:
        """All of them, as the engine reads them."""
        ranges = [float(v) for four in zip(self.low, self.high, self.centre, self.scale, strict=True) for v in four]
        layers = [np.asarray(getattr(self, name), dtype=float).ravel() for name in self.LAYERS]
        return [*ranges, float(self.fade), float(self.trust), float(self.memory), *np.concatenate(layers).tolist()]
