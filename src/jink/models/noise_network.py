"""Networks that choose the process noise of the scan, or score the modes: NNVSMM, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, positive
from ..frozen import frozen
from .network import Network
from .provenance import Trained

INPUTS = ("likelihood", "log-nis")
OUTPUTS = ("variance", "log-variance")
LEAST_NIS = 0.01  # log NIS is log(NIS + this): below it a residual says nothing more


@frozen(kw_only=True)
class NoiseNetwork:
    """The variance q of the acceleration noise (m²/s⁴) for a scan, chosen by a network.

    The network sees the last q and how well it explains the measurement.

    With P⁻ of the last q and S = H P⁻ Hᵀ + R along x and along y: inputs "likelihood" (q, N(νx; 0, Sx), N(νy; 0, Sy))
    as published; "log-nis" (log q, log(νx²/Sx + .01), log(νy²/Sy + .01)). With y = network((u − centre)/scale): output
    "variance" q = clip(output_centre + output_scale · y, least, most); "log-variance" q = least (most/least)^σ(y), σ
    the logistic function. The new q then gives the P⁻ of the update. Before the first update the last q is ``start``.
    sensor_sd (m) is that of the measurements it was trained on.

    Source: Choi, Samal & Ahn 2001, §3 (parameter-based design); the logarithmic forms are jink's.
    """

    network: Network
    inputs: str
    output: str
    centre: Sequence[float]
    scale: Sequence[float]
    least: float
    most: float
    start: float
    output_centre: float = 0.0
    output_scale: float = 1.0
    sensor_sd: float | None = None
    trained: Trained | None = None

    def __post_init__(self) -> None:
        if self.inputs not in INPUTS:
            raise ValueError(f"NoiseNetwork.inputs: expected one of {', '.join(INPUTS)}, got {self.inputs!r}")
        if self.output not in OUTPUTS:
            raise ValueError(f"NoiseNetwork.output: expected one of {', '.join(OUTPUTS)}, got {self.output!r}")
        if (self.network.inputs, self.network.outputs) != (3, 1):
            raise ValueError(
                f"NoiseNetwork.network: expected 3 inputs and 1 output, got {self.network.inputs} and "
                f"{self.network.outputs}"
            )
        _scaling(self, 3)
        if not positive("NoiseNetwork.least", self.least) < positive("NoiseNetwork.most", self.most):
            raise ValueError(f"NoiseNetwork.least: expected below most, got {self.least:g} and {self.most:g}")
        if not self.least <= self.start <= self.most:
            raise ValueError(f"NoiseNetwork.start: expected {self.least:g} to {self.most:g}, got {self.start:g}")

    def check_units(self, sensor_sd: float) -> None:
        """Does this network suit the residuals of such a sensor (sd in m)?

        Errors: ValueError where the sd differs by more than a factor of ten.
        """
        own = self.sensor_sd
        if own is not None and not own / 10 <= sensor_sd <= own * 10:
            raise ValueError(
                f"NoiseNetwork: was trained on measurements of sd {own:g} m, and the sensor's is {sensor_sd:g} m; "
                "expected metres; NoiseNetwork.scaled(sd) makes it one for another sensor"
            )

    def scaled(self, sensor_sd: float) -> NoiseNetwork:
        """The same network for a sensor of another sd (m): variances scale with its square, as for a larger target.

        Errors: ValueError for inputs that are not logarithms, or a network that does not know its sensor.
        """
        if self.inputs != "log-nis" or self.sensor_sd is None:
            raise ValueError("NoiseNetwork.scaled: expected log-nis inputs and a known sensor_sd")
        factor = (positive("sensor_sd", sensor_sd) / self.sensor_sd) ** 2
        return replace(
            self,
            least=self.least * factor,
            most=self.most * factor,
            start=self.start * factor,
            sensor_sd=sensor_sd,
            centre=(self.centre[0] + float(np.log(factor)), *self.centre[1:]),
        )

    def features(self, q: Array, residual: Array, S: Array) -> Array:
        """u (N, 3) from the last q (N,), residuals (N, 2) in m and their variances (N, 2)."""
        nis = residual**2 / S
        if self.inputs == "log-nis":
            return np.column_stack([np.log(q), np.log(nis + LEAST_NIS)])
        return np.column_stack([q, np.exp(-0.5 * nis) / np.sqrt(2 * np.pi * S)])

    def __call__(self, u: ArrayLike) -> Array:
        """q (N,) for features u (N, 3)."""
        y = self.network((np.asarray(u, dtype=float) - np.asarray(self.centre)) / np.asarray(self.scale))[:, 0]
        if self.output == "variance":
            return np.clip(self.output_centre + self.output_scale * y, self.least, self.most)
        return self.least * (self.most / self.least) ** (0.5 * (1 + np.tanh(0.5 * y)))


@frozen(kw_only=True)
class ModeNetwork:
    """The weights of M modes, from those of the scan before and how well each mode explains the measurement.

    u = (w₁ … w_M of the scan before, log(NIS₁/m + .01) … log(NIS_M/m + .01)), m the number of measured components;
    scores s = network((u − centre)/scale); the ``best`` highest are kept, w = softmax of those, zero for the rest. All
    modes go on from the combined estimate. Before the first update the weights are equal.

    Source: Choi, Samal & Ahn 2001, eq. 8 and §3 (mode-based design: "choosing k modes"); the inputs are jink's.
    """

    network: Network
    centre: Sequence[float]
    scale: Sequence[float]
    best: int
    trained: Trained | None = None

    def __post_init__(self) -> None:
        modes = self.network.outputs
        if self.network.inputs != 2 * modes:
            raise ValueError(
                f"ModeNetwork.network: expected {2 * modes} inputs for {modes} modes, got {self.network.inputs}"
            )
        _scaling(self, 2 * modes)
        if int(self.best) != self.best or not 1 <= self.best <= modes:
            raise ValueError(f"ModeNetwork.best: expected a whole number from 1 to {modes}, got {self.best!r}")

    def __call__(self, weights: Array, nis: Array, dof: int) -> Array:
        """w (N, M) from the last weights (N, M) and NIS (N, M) of dof components."""
        u = np.concatenate([weights, np.log(nis / dof + LEAST_NIS)], axis=1)
        scores = self.network((u - np.asarray(self.centre)) / np.asarray(self.scale))
        order = np.argsort(-scores, axis=1, kind="stable")
        kept = np.zeros(scores.shape, dtype=bool)
        np.put_along_axis(kept, order[:, : self.best], True, axis=1)
        w = np.where(kept, np.exp(scores - scores.max(axis=1, keepdims=True)), 0.0)
        return w / w.sum(axis=1, keepdims=True)


def _scaling(owner: NoiseNetwork | ModeNetwork, inputs: int) -> None:
    name = type(owner).__name__
    for field in ("centre", "scale"):
        values = tuple(float(v) for v in getattr(owner, field))
        if len(values) != inputs or not np.isfinite(values).all():
            raise ValueError(f"{name}.{field}: expected {inputs} finite numbers, got {values}")
        object.__setattr__(owner, field, values)
    if not all(s > 0 for s in owner.scale):
        raise ValueError(f"{name}.scale: expected positive numbers")
