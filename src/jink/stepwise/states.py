"""What the stepwise filters carry from scan to scan, many tracks at once, and what a scan says of itself."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from ..estimate import Status
from .functions import Array
from .modes import Mode

T = TypeVar("T")


class Rows:
    """A record of arrays, lists of arrays, or further records, whose first axis is the track."""

    def take(self: T, rows: Any) -> T:
        """The records of some tracks; a slice gives views."""
        return type(self)(*(_some(getattr(self, f.name), rows) for f in fields(self)))  # type: ignore[arg-type]

    def put(self: T, rows: Any, part: T) -> None:
        """Set the records of some tracks."""
        for f in fields(self):  # type: ignore[arg-type]
            to, value = getattr(self, f.name), getattr(part, f.name)
            for a, b in zip(to, value, strict=True) if isinstance(to, list) else [(to, value)]:
                a[rows] = b


def _some(value: Any, rows: Any) -> Any:
    if isinstance(value, list):
        return [_some(each, rows) for each in value]
    if isinstance(value, Rows):
        return value.take(rows)
    return None if value is None else value[rows]


@dataclass
class States(Rows):
    """Tracks: each mode's x and P after its last update, mode probabilities, how far their start has come."""

    x: list[Array]
    P: list[Array]
    probability: Array
    time: Array
    last_accepted: Array
    rejections: Array
    surprise: Array  # NIS of the rows accepted last, and their dimensions
    surprise_dof: Array
    first: Array  # position, while waiting for a second
    first_P: Array
    first_time: Array
    started: Array  # has a state
    running: Array  # its start is complete

    @classmethod
    def new(cls, modes: Sequence[Mode], probability: Array, axes: int, tracks: int) -> "States":
        """Tracks that have not started."""
        sizes = [len(mode.components) for mode in modes]
        return cls(
            [np.zeros((tracks, n)) for n in sizes],
            [np.tile(np.eye(n), (tracks, 1, 1)) for n in sizes],
            np.tile(probability, (tracks, 1)),
            np.zeros(tracks),
            np.zeros(tracks),
            np.zeros(tracks),
            np.zeros(tracks),
            np.zeros(tracks),
            np.zeros((tracks, axes)),
            np.zeros((tracks, axes, axes)),
            np.zeros(tracks),
            np.zeros(tracks, dtype=bool),
            np.zeros(tracks, dtype=bool),
        )

    def arrays(self) -> Iterator[Array]:
        """Every array, for saving."""
        for f in fields(self):
            value = getattr(self, f.name)
            yield from value if isinstance(value, list) else [value]


@dataclass
class Predicted(Rows):
    """Each mode's x⁻ and P⁻, and the mode probabilities before the measurement."""

    x: list[Array]
    P: list[Array]
    prior: Array

    def widened(self, by: Array) -> "Predicted":
        """With the covariances multiplied by a factor per track."""
        return Predicted(self.x, [P * by[:, None, None] for P in self.P], self.prior)


@dataclass
class Outcome(Rows):
    """What a scan says of itself."""

    log_likelihood: Array
    dof: Array
    nis: Array
    pit: Array
    measured: Array
    scored: Array  # its likelihood, NIS and PIT count
    gated: Array
    restarted: Array
    initialised: Array

    @classmethod
    def new(cls, tracks: int, columns: int) -> "Outcome":
        """Nothing measured."""
        numbers = (
            np.zeros(tracks),
            np.zeros(tracks),
            np.full(tracks, np.nan),
            np.full((tracks, columns), np.nan),
        )
        return cls(*numbers, *(np.zeros(tracks, dtype=bool) for _ in range(5)))

    def status(self, started: Array) -> Array:
        """Of :class:`~jink.estimate.Status`."""
        begun = np.where(self.restarted, Status.restarted, Status.initialised)
        going = np.where(self.gated, Status.gated, np.where(self.measured, Status.updated, Status.predicted))
        return np.where(started, np.where(self.initialised, begun, going), Status.none).astype(np.uint8)


@dataclass
class Measurement(Rows):
    """What was measured as h sees it: z, R and which components are present (B, m)."""

    z: Array
    R: Array
    present: Array


@dataclass
class Record(Rows):
    """What the forward pass leaves behind of one scan for the smoothers."""

    x: list[Array]
    P: list[Array]
    probability: Array
    dt: Array
    input: Array | None
    started: Array
    linked: Array  # it follows from the scan before
    sensor: Array
    measurements: list[Measurement]  # one per sensor, without what was not believed
