"""How well a measurement was predicted: NIS and Gaussian log density of what a state says of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from ..checks import Array

STEP = 1e-3  # of a standard deviation, for derivatives by central differences
ANGLES = ("azimuth", "elevation")


class Density:
    """S = H P Hᵀ + R, ν = z − h(x), NIS = νᵀ S⁻¹ ν, ln p = −½ (NIS + ln |S| + m ln 2π), of what was measured."""

    def __init__(self, sensor: Any, components: tuple[str, ...]) -> None:
        axes = int(sensor.axes or 2)
        self._sensor = sensor
        self._angles = [k for k, name in enumerate(sensor.components) if name in ANGLES]
        self._places = {
            kind: [components.index(kind + a) if kind + a in components else -1 for a in "xyz"[:axes]] for kind in "pv"
        }
        if -1 in self._places["p"]:
            raise ValueError(f"components: expected a position for each of {axes} axes, got {', '.join(components)}")

    def __call__(self, x: Array, P: Array, z: Array, R: Array) -> dict[str, Array]:
        """nis and log_likelihood_scan (B,) of rows z (B, m) with NaN where nothing was measured."""
        residual, H = self._wrapped(z - self._seen(x)), self._jacobian(x, P)
        S = H @ P @ H.swapaxes(1, 2) + R
        there = np.isfinite(z)
        # rows and columns of what was not measured become those of the unit matrix: they add nothing
        both = there[:, :, None] & there[:, None, :]
        S = np.where(both, S, np.eye(z.shape[1]))
        nu = np.where(there, residual, 0.0)
        nis = np.einsum("bi,bi->b", nu, np.linalg.solve(S, nu[..., None])[..., 0])
        log_det = np.linalg.slogdet(S)[1]
        dof = there.sum(axis=1)
        return {"nis": nis, "log_likelihood_scan": -0.5 * (nis + log_det + dof * np.log(2.0 * np.pi))}

    def expected(self, x: Array, P: Array) -> tuple[Array, Array]:
        """h(x) (B, m) and its derivatives (B, m, n)."""
        return self._seen(x), self._jacobian(x, P)

    def _seen(self, x: Array) -> Array:
        found = {k: np.stack([x[:, p] if p >= 0 else 0.0 * x[:, 0] for p in at], 1) for k, at in self._places.items()}
        return self._sensor.observe(SimpleNamespace(position=found["p"], velocity=found["v"]))

    def _wrapped(self, residual: Array) -> Array:
        for k in self._angles:
            residual[:, k] = np.remainder(residual[:, k] + np.pi, 2.0 * np.pi) - np.pi
        return residual

    def _jacobian(self, x: Array, P: Array) -> Array:
        H = np.zeros((len(x), len(self._sensor.components), x.shape[1]))
        for k in (p for at in self._places.values() for p in at if p >= 0):
            step = STEP * np.sqrt(np.maximum(P[:, k, k], 1e-12))
            either = np.zeros_like(x)
            either[:, k] = step
            H[:, :, k] = self._wrapped(self._seen(x + either) - self._seen(x - either)) / (2.0 * step)[:, None]
        return H
