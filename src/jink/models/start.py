"""How a track starts: from two points, from one, or from a given estimate."""

from numpy.typing import ArrayLike

from ..frozen import frozen


@frozen(kw_only=True)
class TwoPoint:
    """Start by two-point differencing: v = (z₂ − z₁)/T, P = [R, R/T; R/T, 2R/T²] per axis.

    Until the second point the velocity is zero with ``velocity_sd`` (m/s). The likelihood counts from the third point.

    bounded: targets are as fast as that. The velocity of two points is then conditioned on N(0, velocity_sd²) per axis,
    v ← v − P (P + velocity_sd²)⁻¹ v. A second point more than 5 standard deviations away contradicts the first, and
    the track begins anew from the second. After two such in a row the next two points are believed as they are.
    Source: Bar-Shalom, Li & Kirubarajan 2001, §5.5.3.
    """

    velocity_sd: float = 1000.0
    bounded: bool = False


@frozen(kw_only=True)
class OnePoint:
    """Start from one point: velocity zero with ``velocity_sd`` (m/s). The likelihood counts from the second point."""

    velocity_sd: float


@frozen(eq=False)
class Prior:
    """A given start: mean x (n,) or (B, n) and covariance P (n, n) or (B, n, n).

    They hold at each track's first row, before its update.
    Components are those of the filter's estimates, ``filter.components``.
    """

    x: ArrayLike
    P: ArrayLike


Initial = TwoPoint | OnePoint | Prior
