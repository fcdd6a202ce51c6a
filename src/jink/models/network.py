"""A small multilayer network as data; :mod:`jink.learn.mlp` trains it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array
from ..frozen import frozen
from .fuzzy import _tuples


@frozen
class Network:
    """y = W_L tanh(… tanh(W₁ u + b₁) …) + b_L.

    weights, one (outputs, inputs) per layer; biases, one (outputs,) per layer; the last layer is linear.
    Errors: ValueError for layers that do not fit each other or numbers that are not finite.
    """

    weights: Sequence[Sequence[Sequence[float]]]
    biases: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        weights = [np.asarray(w, dtype=float) for w in self.weights]
        biases = [np.asarray(b, dtype=float) for b in self.biases]
        if not weights or len(weights) != len(biases):
            raise ValueError(
                f"Network: expected as many layers of weights as of biases, got {len(weights)} and {len(biases)}"
            )
        for layer, (w, b) in enumerate(zip(weights, biases, strict=True)):
            before = w.shape[-1] if layer == 0 else len(biases[layer - 1])
            if w.ndim != 2 or w.shape != (b.size, before) or b.ndim != 1:
                raise ValueError(
                    f"Network: layer {layer} has weights {w.shape} and biases {b.shape}; expected (n, {before}) "
                    "and (n,)"
                )
            if not (np.isfinite(w).all() and np.isfinite(b).all()):
                raise ValueError(f"Network: layer {layer} has numbers that are not finite")
        object.__setattr__(self, "weights", tuple(_tuples(w.tolist()) for w in weights))
        object.__setattr__(self, "biases", tuple(_tuples(b.tolist()) for b in biases))

    @property
    def inputs(self) -> int:
        """How many numbers go in."""
        return len(self.weights[0][0])

    @property
    def outputs(self) -> int:
        """How many numbers come out."""
        return len(self.biases[-1])

    def __call__(self, u: ArrayLike) -> Array:
        """y (..., outputs) for u (..., inputs)."""
        y = np.asarray(u, dtype=float)
        for layer, (w, b) in enumerate(zip(self.weights, self.biases, strict=True)):
            y = y @ np.asarray(w).T + np.asarray(b)
            if layer < len(self.weights) - 1:
                y = np.tanh(y)
        return y
