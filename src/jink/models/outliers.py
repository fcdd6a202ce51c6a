"""Measurements that are not of the target: the share of outliers, and how far off they may lie."""

from collections.abc import Sequence

from ..checks import positive, whole
from ..frozen import frozen


@frozen(kw_only=True)
class Outliers:
    """A measurement is the target's with probability 1 − share, else anything within the sensor's extent.

    p(z) = (1 − ε) Σⱼ cⱼ N(z; ẑⱼ, Sⱼ) + ε / V,   V = the product of the extents of the measured components.
    The log-likelihood is that of this mixture; a row that is likelier an outlier is gated (treated as missing), and
    after ``restart_after`` gated rows in a row (0: never) the track starts again from the last of them. ``extent`` (m)
    holds for positions and ranges, or is one number per component; angles have 2π, velocities ``velocity_extent``
    (m/s).

    hindsight: a row that may be either is followed both ways until the next one decides. Until then the estimate is the
    mixture of both. For filters of fixed modes that are mixed as in the IMM, GPB1 or not at all.
    """

    share: float = 0.01
    extent: float | Sequence[float] = 1e5
    velocity_extent: float = 1e3
    restart_after: int = 2
    hindsight: bool = False

    def __post_init__(self) -> None:
        if not 0 < positive("Outliers.share", self.share) < 1:
            raise ValueError(f"Outliers.share: expected a probability below 1, got {self.share:g}")
        for extent in self.extent if isinstance(self.extent, Sequence) else [self.extent]:
            positive("Outliers.extent", extent)
        positive("Outliers.velocity_extent", self.velocity_extent)
        whole("Outliers.restart_after", self.restart_after, 0, 2**31 - 1, of=" of rows")
