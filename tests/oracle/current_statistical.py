"""Zhou's "current" statistical model, plain (CSAF) and with fuzzy acceleration limits (FACS).

x = [p v a] per axis; a is a first-order Markov process around its current mean, whose density is a modified
Rayleigh distribution between the present acceleration and a limit. Zhou & Kumar, "A 'current' statistical
model and adaptive algorithm for estimating maneuvering targets", J. Guidance 7(5), 1984; Wang, Qin, Yang &
Yang, Defence Technology 2010 no. 3, equations 8 to 18 (CSAF) and 24 to 27 (FACS), lost in the stored text.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from oracle.motion import Singer, singer_exact

Array = NDArray[np.float64]
RAYLEIGH = (4 - np.pi) / np.pi


class CurrentStatistical(Singer):
    """CSAF: P- = Phi P Phi' + 2 alpha sigma^2 Q0 with sigma^2 = (4 - pi)/pi (a_max - a)^2 for a >= 0 and
    (4 - pi)/pi (a - a_-max)^2 for a < 0.

    Readings: the mean of the process is the estimate before (abar = a(k-1|k-1), the one-step prediction), so
    Phi x + U abar moves the mean with constant acceleration, while Phi (Singer's, alpha = 1/time_constant)
    moves the covariance. The variance is taken at the same a. The distance to the limit is at least `floor`
    of the limit, so an acceleration at or beyond it does not freeze the filter.
    """

    name = "current_statistical"

    def __init__(
        self,
        axes,
        acceleration_max,
        time_constant,
        acceleration_min=None,
        floor=0.01,
        acceleration_prior_sd=None,
    ):
        prior = acceleration_max if acceleration_prior_sd is None else acceleration_prior_sd
        super().__init__(axes, prior, time_constant)
        self.upper = acceleration_max
        self.lower = -acceleration_max if acceleration_min is None else acceleration_min
        self.floor = floor

    def limits(self, a: Array) -> tuple[Array, Array]:
        """Upper and lower limit at the acceleration a."""
        return np.full_like(a, self.upper), np.full_like(a, self.lower)

    def variance(self, a: Array) -> Array:
        upper, lower = self.limits(a)
        limit = np.where(a >= 0, upper, -lower)
        distance = np.maximum(limit - np.abs(a), self.floor * limit)
        return RAYLEIGH * distance**2

    def f(self, x, dt):
        constant = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
        return x @ block_diag(*[constant] * self.axes).T

    def noise(self, x, dt):
        Q = np.zeros((*x.shape, x.shape[-1]))
        for axis, tau in enumerate(self.time_constant):
            block = slice(3 * axis, 3 * axis + 3)
            variance = self.variance(x[..., 3 * axis + 2])
            Q[..., block, block] = 2 / tau * variance[..., None, None] * singer_exact(float(dt), float(tau))[1]
        return Q


class FuzzyCurrentStatistical(CurrentStatistical):
    """FACS: a_max = a_th M(a), a_-max = a_-th M(a), M(a) = min(1, exp(-k (1 - |a|/a_th))), k1 for a >= 0 and
    k2 for a < 0.

    Reconstructed: the exponential form is said to have no jump, its constants to be bounded so that
    a_max >= |a| for |a| <= a_up, which this form satisfies for k <= a_th ln(a_th/a_up)/(a_th - a_up).
    """

    name = "fuzzy_current_statistical"

    def __init__(
        self,
        axes,
        time_constant,
        threshold=100.0,
        threshold_min=None,
        k1=0.97,
        k2=0.97,
        floor=0.01,
        acceleration_prior_sd=None,
        straight=False,
    ):
        super().__init__(axes, threshold, time_constant, threshold_min, floor, acceleration_prior_sd)
        self.k1, self.k2, self.straight = k1, k2, straight

    def limits(self, a):
        if self.straight:
            return tuple(
                end * np.minimum(1.0, np.exp(-k) + (1 - np.exp(-k)) * np.abs(a / end))
                for end, k in ((self.upper, self.k1), (self.lower, self.k2))
            )
        up = np.minimum(1.0, np.exp(-self.k1 * (1 - np.abs(a) / self.upper)))
        down = np.minimum(1.0, np.exp(-self.k2 * (1 - np.abs(a) / -self.lower)))
        return self.upper * up, self.lower * down


def largest_k(threshold: float, up: float) -> float:
    """The bound on k that keeps a_max >= |a| on [0, up]: a_th ln(a_th/a_up)/(a_th - a_up)."""
    return threshold * np.log(threshold / up) / (threshold - up)
