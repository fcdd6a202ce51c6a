"""Random numbers that belong to a run: the same for every chunking, order and number of threads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..checks import Array

# independent streams of one run: another sensor leaves the truth as it is, a miss leaves the noise as it is
STREAMS = ("truth", "noise", "detection", "outliers", "schedule")


class Draws:
    """Random arrays whose row b depends on nothing but seed, run b, stream and the number of draws before.

    Philox (Salmon et al., SC11): the key is hashed from the seed, the 256-bit counter begins at (0, draw,
    stream, run). seed a non-negative integer; runs (B,) non-negative integers. Errors: ValueError for a
    negative seed or run.
    """

    def __init__(self, seed: int, runs: NDArray[np.int64] | list[int] | range, stream: str = "truth") -> None:
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise ValueError(f"seed: expected a non-negative integer, got {seed!r}")
        self.runs = np.asarray(runs, dtype=np.int64)
        if self.runs.ndim != 1 or (self.runs < 0).any():
            raise ValueError("runs: expected the numbers of runs, each a whole number from 0")
        self._stream, self._draw = STREAMS.index(stream), 0
        self._bits = np.random.Philox(key=np.random.SeedSequence(int(seed)).generate_state(2, np.uint64))
        self._numbers = np.random.Generator(self._bits)
        self._begin = self._bits.state

    def __len__(self) -> int:
        return len(self.runs)

    def normal(self, *shape: int) -> Array:
        """(B, *shape) standard normal."""
        return self._fill(shape, normal=True)

    def uniform(self, low: float, high: float, *shape: int) -> Array:
        """(B, *shape) uniform in [low, high)."""
        return low + (high - low) * self._fill(shape, normal=False)

    def sign(self, *shape: int) -> Array:
        """(B, *shape) of ±1, each as likely."""
        return np.where(self._fill(shape, normal=False) < 0.5, -1.0, 1.0)

    def geometric(self, mean: float, *shape: int) -> Array:
        """(B, *shape) whole numbers from 1 with p(n) = (1 − p)ⁿ⁻¹ p, p = 1/mean."""
        if mean <= 1.0:
            return np.ones((len(self), *shape))
        return np.ceil(np.log1p(-self._fill(shape, normal=False)) / np.log1p(-1.0 / mean)).clip(1.0)

    def _fill(self, shape: tuple[int, ...], *, normal: bool) -> Array:
        out = np.empty((len(self.runs), *shape))
        counter = self._begin["state"]["counter"]
        fill = self._numbers.standard_normal if normal else self._numbers.random
        for row, run in zip(out.reshape(len(self.runs), -1), self.runs, strict=True):
            counter[:] = (0, self._draw, self._stream, run)
            self._bits.state = self._begin
            fill(out=row)
        self._draw += 1
        return out
