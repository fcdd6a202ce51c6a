"""A learned aid to a filter: its inputs, what it corrects, and where it corrects nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, positive
from ..frozen import frozen
from .anfis import Anfis
from .network import Network
from .provenance import Trained

INPUTS = ("titi-guney", "innovations", "sums")
MOST_SUMS = 7  # of 64 innovations
MOST_SD = 2.0  # of the measurement: the largest unit of a correction
CORRECTS = ("position", "velocity", "acceleration")


def history_of(inputs: str, count: int) -> int:
    """How many innovations these inputs look back on."""
    return {"titi-guney": 0, "innovations": count, "sums": 2 ** (count - 1)}[inputs]


@frozen(kw_only=True)
class Corrector:
    """A correction of the estimate along each axis by itself, x̂ + c(u) · unit, from what the filter has just seen.

    inputs "titi-guney": u = (z − x̂(t|t), x̂(t|t−1) − x̂(t|t)), positions in m, unit 1 (m, m/s, m/s²);
    inputs "innovations": u = ν/√S of the newest and of the scans before, zero before the track began; unit √(S P_cc /
    P_pp) of the newest scan for component c (for the position √S), so that it carries over to another sensor. S counts
    up to 4 R: the estimate stays near its measurement, however much the prediction errs. A miss enters no innovation,
    and is not corrected. inputs "sums": the sums of the newest 1, 2, 4, … of these, over √1, √2,
    √4, …; the same unit.

    c(u) = f · output_scale · model((clip(u, low, high) − centre) / scale), with f = max(0, 1 − e/fade) and e the
    largest distance of an input from its range [low, high], in widths of the range: outside what it has seen the aid
    fades to nothing.

    sd_factors, of position, velocity, acceleration: what the corrected estimate's sds are over the filter's own; P goes
    out as W P W, W diagonal of 1 + f (factor − 1). Those not given are 1.

    model an :class:`jink.models.anfis.Anfis` or a :class:`jink.models.network.Network`; low, high, centre, scale, one
    number per input; output_scale one per corrected quantity; corrects ("position",), then "velocity", "acceleration".
    Errors: ValueError where these do not fit. Source: Titi & Güney (inputs, sum); ranges, fading and covariance are
    jink's.
    """

    model: Anfis | Network
    inputs: str
    low: Sequence[float]
    high: Sequence[float]
    centre: Sequence[float]
    scale: Sequence[float]
    output_scale: Sequence[float]
    corrects: Sequence[str] = ("position",)
    fade: float = 0.5
    trained: Trained | None = None
    sd_factors: Sequence[float] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.model, Anfis | Network):
            raise TypeError(f"Corrector.model: expected an Anfis or a Network, got {type(self.model).__name__}")
        if self.inputs not in INPUTS:
            raise ValueError(f"Corrector.inputs: expected one of {', '.join(INPUTS)}, got {self.inputs!r}")
        if self.inputs == "titi-guney" and self.model.inputs != 2:
            raise ValueError(f"Corrector.model: titi-guney has 2 inputs, the model {self.model.inputs}")
        for name in ("low", "high", "centre", "scale", "output_scale"):
            values = tuple(float(v) for v in getattr(self, name))
            expected = self.model.outputs if name == "output_scale" else self.model.inputs
            if len(values) != expected or not np.isfinite(values).all():
                raise ValueError(f"Corrector.{name}: expected {expected} finite numbers, got {values}")
            object.__setattr__(self, name, values)
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError("Corrector.low: expected to lie below high")
        if not all(s > 0 for s in self.scale):
            raise ValueError("Corrector.scale: expected positive numbers")
        object.__setattr__(self, "corrects", tuple(self.corrects))
        if self.corrects != CORRECTS[: self.model.outputs]:
            raise ValueError(
                f"Corrector.corrects: expected the first {self.model.outputs} of {', '.join(CORRECTS)}, got "
                f"{self.corrects}"
            )
        positive("Corrector.fade", self.fade)
        if self.inputs == "sums" and self.count > MOST_SUMS:
            raise ValueError(f"Corrector.model: expected at most {MOST_SUMS} sums, the model has {self.count} inputs")
        factors = tuple(float(v) for v in self.sd_factors)
        if len(factors) > len(CORRECTS) or not all(0 < v < np.inf for v in factors):
            raise ValueError(f"Corrector.sd_factors: expected at most 3 numbers above 0, got {factors}")
        object.__setattr__(self, "sd_factors", factors)

    @property
    def count(self) -> int:
        """How many inputs there are; for "innovations", how many scans are looked back on, the newest included."""
        return len(self.low)

    @property
    def history(self) -> int:
        """How many innovations it looks back on, the newest included."""
        return history_of(self.inputs, self.count)

    @property
    def factors(self) -> tuple[float, ...]:
        """Of the sds of position, velocity and acceleration, one each."""
        return (*self.sd_factors, *[1.0] * (len(CORRECTS) - len(self.sd_factors)))

    def share(self, u: ArrayLike) -> Array:
        """f (N,): one inside the training range, zero far outside."""
        u, low, high = (np.asarray(a, dtype=float) for a in (u, self.low, self.high))
        outside = np.maximum(np.maximum(low - u, u - high), 0.0) / (high - low)
        return np.maximum(0.0, 1.0 - outside.max(axis=-1) / self.fade)

    def scaled(self, u: ArrayLike) -> Array:
        """What the model is given, (N, inputs)."""
        return (np.clip(u, self.low, self.high) - np.asarray(self.centre)) / np.asarray(self.scale)

    def __call__(self, u: ArrayLike) -> Array:
        """c(u) (N, outputs) for u (N, inputs), in the unit that goes with the inputs."""
        return self.share(u)[:, None] * np.asarray(self.output_scale) * self.model(self.scaled(u))

    def check_units(self, sensor_sd: float) -> None:
        """Does this aid suit the residuals of such a sensor (sd in m)?

        Errors: ValueError for inputs in metres whose range is below a third or above a hundred thousand of the sensor's
        sd.
        """
        width = max(b - a for a, b in zip(self.low, self.high, strict=True))
        if self.inputs == "titi-guney" and not 0.3 * sensor_sd <= width <= 1e5 * sensor_sd:
            raise ValueError(
                f"Corrector: was trained on residuals within {width:.3g} m, and the sensor's sd is "
                f"{sensor_sd:.3g} m; expected metres"
            )
