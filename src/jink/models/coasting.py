"""What a target does while nothing is measured."""

from __future__ import annotations

from .._engine import native
from ..checks import positive
from ..frozen import frozen


@frozen(kw_only=True)
class Coasting:
    """A target without measurements ceases to manoeuvre: a' = −a / manoeuvre, vz' = −vz / climb, ω' = −ω / manoeuvre.

    after (s): without an accepted measurement for so long, a target coasts; for its height, one without a measured
    height. manoeuvre, climb (s): time constants of accelerations and turn rates, and of climb rates. reverses: whether
    it may go backwards; one that may not stands still where its velocity would turn about, at any time.

    Means alone change; covariances grow as the motion models say. It holds for constant velocity, constant acceleration
    and coordinated turns; other motion models go on as they were. Errors: ValueError for times that are not positive.
    """

    after: float
    manoeuvre: float
    climb: float
    reverses: bool = True

    def __post_init__(self) -> None:
        for name in ("after", "manoeuvre", "climb"):
            positive(name, getattr(self, name))

    def native(self) -> native.Coasting:
        """What the engine runs."""
        return native.Coasting(
            after=float(self.after),
            manoeuvre=float(self.manoeuvre),
            climb=float(self.climb),
            reverses=bool(self.reverses),
        )
