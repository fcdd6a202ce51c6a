"""The one number of a Kalman filter, its noise, found on training data: a coarse look, then golden section."""

from __future__ import annotations

import math
from collections.abc import Callable

RATIO = (math.sqrt(5.0) - 1.0) / 2.0


def golden_section(loss: Callable[[float], float], low: float, high: float, *, tolerance: float = 0.02) -> float:
    """The minimum of a loss with one valley between low and high, to ± tolerance.

    Source: Kiefer, Proc. Amer. Math. Soc. 4, 1953.
    """
    a, b = high - RATIO * (high - low), low + RATIO * (high - low)
    loss_a, loss_b = loss(a), loss(b)
    while high - low > tolerance:
        if loss_a <= loss_b:
            high, b, loss_b = b, a, loss_a
            a = high - RATIO * (high - low)
            loss_a = loss(a)
        else:
            low, a, loss_a = a, b, loss_b
            b = low + RATIO * (high - low)
            loss_b = loss(b)
    return 0.5 * (low + high)


def lowest(loss: Callable[[float], float], low: float, high: float, *, looks: int = 10) -> float:
    """Where a loss is least between low and high: golden section around the best of some looks, so that one of several
    valleys is found.
    """
    step = (high - low) / (looks - 1)
    grid = [low + k * step for k in range(looks)]
    losses = [_finite(loss(x)) for x in grid]
    best = losses.index(min(losses))
    begin, end = grid[max(best - 1, 0)], grid[min(best + 1, looks - 1)]
    return golden_section(lambda x: _finite(loss(x)), begin, end)


def best_noise(loss: Callable[[float], float], low: float, high: float, *, looks: int = 10) -> float:
    """The noise between low and high with the least loss, found on the logarithm."""
    return math.exp(lowest(lambda x: loss(math.exp(x)), math.log(low), math.log(high), looks=looks))


def _finite(loss: float) -> float:
    return loss if math.isfinite(loss) else math.inf
