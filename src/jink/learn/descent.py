"""Gradient descent on lists of arrays, and the best of what was met on the way."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from ..checks import Array

T = TypeVar("T")


@dataclass
class Adam:
    """Adam: steps of about ``rate`` along the gradient, scaled by its running size.

    Source: Kingma & Ba, ICLR 2015.
    """

    rate: float
    decay: tuple[float, float] = (0.9, 0.999)
    _mean: list[Array] = field(default_factory=list)
    _square: list[Array] = field(default_factory=list)
    _steps: int = 0

    def step(self, values: list[Array], gradients: list[Array], rate: float | None = None) -> list[Array]:
        """The values after one step."""
        if not self._mean:
            self._mean, self._square = ([np.zeros_like(v) for v in values] for _ in range(2))
        self._steps += 1
        first, second = self.decay
        unbias = np.sqrt(1 - second**self._steps) / (1 - first**self._steps)
        out = []
        for k, (value, gradient) in enumerate(zip(values, gradients, strict=True)):
            self._mean[k] = first * self._mean[k] + (1 - first) * gradient
            self._square[k] = second * self._square[k] + (1 - second) * gradient**2
            size = (self.rate if rate is None else rate) * unbias
            out.append(value - size * self._mean[k] / (np.sqrt(self._square[k]) + 1e-10))
        return out


@dataclass
class Kept(Generic[T]):
    """The value with the least loss offered so far."""

    loss: float = np.inf
    _value: T | None = None

    def offer(self, loss: float, value: T) -> bool:
        """Keep it if it is better than all before."""
        if loss < self.loss:
            self.loss, self._value = loss, value
            return True
        return False

    @property
    def value(self) -> T:
        """The best. Errors: ValueError where every loss was NaN or infinite."""
        if self._value is None:
            raise ValueError("training: no step had a finite loss; check the data for NaN and infinite numbers")
        return self._value


def clipped(gradients: list[Array]) -> list[Array]:
    """Shortened to a norm of one where it is larger."""
    norm = np.sqrt(sum(float((g * g).sum()) for g in gradients))
    return [g / max(1.0, norm) for g in gradients]
