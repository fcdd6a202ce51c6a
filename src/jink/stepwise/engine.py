"""Filters with models of the user's own, in Python: scan by scan over all tracks at once.

The same step as the engine's, with the engine's mix and update; used wherever a motion model or a sensor
has no native form.

A motion model is any object with

    f(x, dt)          x (B, n) after dt (B,) seconds; B tracks at once
    Q(dt)             covariance (B, n, n) of the process noise
    jacobian(x, dt)   optional: df/dx (B, n, n); else by differences of fourth order
    G(dt)             optional: (B, n, axes), what a known acceleration adds
    components        optional names; default px vx (ax) py vy (ay) ... by their number
    prior_variance    by name: where components start that no position gives, or that other modes lack
    step_seconds      optional: it is for whole numbers of such steps alone
    name              optional, of the mode

and a sensor any object with

    h(x)              what is measured of x (B, n), (B, m)
    R                 variances (m,) or covariance (m, m)
    jacobian(x)       optional: dh/dx (B, m, n)
    residual(z, h)    optional: z − h, for instance with angles wrapped
    position(z, R)    optional: the position (B, axes) a track may start from, its covariance (B, axes, axes)
    state             names of the components h is a function of; needed where modes have different states
    extent            how far outliers spread, per component, if the filter has outliers
    axes              optional: of the space the target moves in

Functions of dt may also be written for one float at a time; they are then called once for each elapsed
time that occurs.
"""

from typing import Any

from .batch import run
from .live import LiveMany, LiveOne
from .scan import Scan


class Stepwise(Scan):
    """Whole tracks or live targets, scan by scan; the interface of the native engine."""

    def one(self, lag: int, filter: Any = None) -> LiveOne:
        """One live target, started by a filter."""
        return LiveOne(self, lag, filter)

    def many(self, n: int, lag: int) -> LiveMany:
        """n live targets."""
        return LiveMany(self, n, lag)

    def run(self, *arguments: Any) -> None:
        """Whole tracks at once; the arguments are those of the native engine's run."""
        run(self, *arguments)
