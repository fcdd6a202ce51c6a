"""What cannot be true of a target that is tracked live: the limits of `plausibility`, over its last rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..catalogue.targets import KINDS
from ..estimate import Status
from .plausibility import TOO_FAST
from .seen import REJECTED

ROWS = 20.0  # rows that are remembered; nothing is said before as many were measured
KEPT = 1.0 - 1.0 / ROWS


@dataclass(slots=True)
class Watch:
    """Shares of a target's last measured rows: rejected, and faster than its kind."""

    rows: int = 0
    rejected: float = 0.0
    fast: float = 0.0

    def look(self, name: str, status: int, speed: float, kind: str) -> Iterator[str]:
        """What can be said after one more row."""
        if status == Status.predicted:
            return
        refused = status in (Status.gated, Status.restarted)
        self.rows += 1
        self.rejected = KEPT * self.rejected + (1.0 - KEPT) * refused
        limit = KINDS[kind].speed
        self.fast = KEPT * self.fast + (1.0 - KEPT) * (status == Status.updated and speed > TOO_FAST * limit)
        if self.rows < ROWS:
            return
        if self.rejected > REJECTED:
            yield (
                f"warning: target {name}: more than {100 * REJECTED:.0f} % of its last positions are not where the "
                "track can be. Likely: several targets under one name, noise that is set too small, or another kind. "
                "--columns target=NAME, --sensor-sd or --kind mends it"
            )
        if self.fast > 0.5:
            yield (
                f"warning: target {name}: half of the time faster than {TOO_FAST * limit:g} m/s; a target of kind "
                f"{kind} reaches about {limit:g} m/s. Likely: another kind, or a wrong unit. --kind, --columns or "
                "--time-unit mends it"
            )
