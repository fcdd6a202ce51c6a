"""Fuzzy rules that say how much process noise a residual and its change call for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, numbers, positive, whole
from ..frozen import frozen
from .provenance import Trained

LEAST_REACH, MOST_REACH = 0.3, 1000.0  # how far from zero rules may be about something, in the sensor's sd


@frozen
class FuzzyRules:
    """Sugeno rules over a residual r and its change Δr (m): the variance (m²/s⁴) of the acceleration noise.

    Rule i fires with hᵢ = exp(−½((r − cᵢ₁)/sᵢ₁)² − ½((Δr − cᵢ₂)/sᵢ₂)²);  q = Σ hᵢ wᵢ / Σ hᵢ, worked out in logarithms,
    so that far from every centre the nearest rule decides.

    centres, spreads (R, 2) in metres, variances w (R,) in (m/s²)²; tables in other units: :meth:`of`. trained says
    where the rules come from. Errors: ValueError for shapes that do not fit, spreads or variances that are not positive
    and finite. Source: Lee, Joo & Park 2003, eq. 12–14 and 19-5 (scatter-partitioned, zero-order consequents).
    """

    centres: Sequence[Sequence[float]]
    spreads: Sequence[Sequence[float]]
    variances: Sequence[float]
    trained: Trained | None = None

    def __post_init__(self) -> None:
        c, s, w = (numbers(f"FuzzyRules.{name}", getattr(self, name)) for name in ("centres", "spreads", "variances"))
        if w.ndim != 1 or not len(w) or c.shape != (len(w), 2) or s.shape != (len(w), 2):
            raise ValueError(
                "FuzzyRules: expected centres (R, 2), spreads (R, 2) and variances (R,) of at least one rule, "
                f"got {c.shape}, {s.shape} and {w.shape}"
            )
        if not np.isfinite(c).all():
            raise ValueError("FuzzyRules.centres: expected finite metres")
        if (s > 0).all() and s.min() < 1e-300:
            raise ValueError(f"FuzzyRules.spreads: expected at least 1e-300 m, got {s.min():g}")
        for name, value in (("spreads", s), ("variances", w)):
            if not (np.isfinite(value).all() and (value > 0).all()):
                raise ValueError(f"FuzzyRules.{name}: expected positive finite numbers, got {value.min():g}")
        for name, value in (("centres", c), ("spreads", s), ("variances", w)):
            object.__setattr__(self, name, _tuples(value.tolist()))

    @classmethod
    def of(cls, table: ArrayLike, *, unit: float = 1.0, trained: Trained | None = None) -> FuzzyRules:
        """Rules from rows c₁ s₁ c₂ s₂ w, as papers print them; ``unit`` is the table's length in metres (kilometres:
        1000).

        c and s are in that unit, w is the variance in (unit/s²)². Errors: ValueError for another number of columns.
        """
        if not 1e-100 < positive("unit", unit) < 1e100:
            raise ValueError(f"unit: expected a length in metres, got {unit:g}")
        rows = np.atleast_2d(numbers("table", table))
        if rows.ndim != 2 or rows.shape[1] != 5 or not len(rows):
            raise ValueError(f"table: expected rows of five numbers c1 s1 c2 s2 w, got shape {rows.shape}")
        try:
            return cls(rows[:, [0, 2]] * unit, rows[:, [1, 3]] * unit, rows[:, 4] * unit**2, trained)  # pyright: ignore[reportArgumentType]
        except ValueError as error:
            raise ValueError(f"table: {error}") from None

    @classmethod
    def constant(cls, acceleration_sd: float, spread: float) -> FuzzyRules:
        """One rule with the same answer everywhere; spread (m) is the size of the residuals it is made for."""
        sd, spread = positive("acceleration_sd", acceleration_sd), positive("spread", spread)
        if sd * sd < 1e-300:
            raise ValueError(f"acceleration_sd: expected at least 1e-150 m/s², got {sd:g}")
        if spread < 1e-300:
            raise ValueError(f"spread: expected at least 1e-300 m, got {spread:g}")
        return cls(((0.0, 0.0),), ((spread, spread),), (sd * sd,))

    def __len__(self) -> int:
        return len(self.variances)

    def table(self, unit: float = 1.0) -> Array:
        """Rows c₁ s₁ c₂ s₂ w in the given unit of length."""
        unit = positive("unit", unit)
        c, s, w = (np.asarray(a, dtype=float) for a in (self.centres, self.spreads, self.variances))
        return np.column_stack([c[:, 0] / unit, s[:, 0] / unit, c[:, 1] / unit, s[:, 1] / unit, w / unit**2])

    def variance(self, residual: ArrayLike, change: ArrayLike) -> Array:
        """q (m²/s⁴) for residuals and changes of any one shape, in metres; NaN where the residual is."""
        r, dr = np.broadcast_arrays(numbers("residual", residual), numbers("change", change))
        log_firing = self._log_firing(r, dr)
        firing = np.exp(log_firing - log_firing.max(axis=-1, keepdims=True))
        return firing @ np.asarray(self.variances) / firing.sum(axis=-1)

    def firing(self, residual: ArrayLike, change: ArrayLike) -> Array:
        """The share of each rule in the answer, (..., R); they sum to one."""
        log_firing = self._log_firing(numbers("residual", residual), numbers("change", change))
        share = np.exp(log_firing - log_firing.max(axis=-1, keepdims=True))
        return share / share.sum(axis=-1, keepdims=True)

    def _log_firing(self, r: Array, dr: Array) -> Array:
        c, s = np.asarray(self.centres), np.asarray(self.spreads)
        a, b = (r[..., None] - c[:, 0]) / s[:, 0], (dr[..., None] - c[:, 1]) / s[:, 1]
        return -0.5 * (a * a + b * b)

    def surface(self, reach: float, points: int = 41) -> tuple[Array, Array]:
        """A grid (points,) of metres from −reach to reach, and the noise's sd (m/s²) over it, [Δr, r]."""
        grid = np.linspace(-positive("reach", reach), reach, whole("points", points, 2, 10_000))
        return grid, np.sqrt(self.variance(grid[None, :], grid[:, None]))

    @property
    def readable(self) -> tuple[float, str]:
        """The unit of length to show these rules in, metres or kilometres: how many metres, and its name."""
        return (1000.0, "km") if max(abs(c) for c, _ in self.centres) > 1000.0 else (1.0, "m")

    def describe(self) -> list[str]:
        """Each rule as a sentence, lengths in m or km, noise in m/s²."""
        unit, name = self.readable
        return [
            f"if r is about {_signed(c1)} {name} (±{s1:.3g}) and Δr about {_signed(c2)} {name} (±{s2:.3g}), "
            f"then the acceleration noise has sd {unit * np.sqrt(w):.3g} m/s²"
            for c1, s1, c2, s2, w in self.table(unit)
        ]

    def check_units(self, sensor_sd: float) -> None:
        """Do these rules suit the residuals of such a sensor (sd in m)?

        The rules' reach is the largest |c₁| + 2 s₁. Errors: ValueError where it lies below a third or above a thousand
        of the sensor's sd, which is what a table in kilometres taken for metres looks like.
        """
        reach = max(abs(c[0]) + 2 * s[0] for c, s in zip(self.centres, self.spreads, strict=True))
        if not LEAST_REACH * sensor_sd <= reach <= MOST_REACH * sensor_sd:
            raise ValueError(
                f"FuzzyRules: the rules are about residuals up to {reach:.3g} m, but the sensor's sd is "
                f"{sensor_sd:.3g} m; "
                "expected metres and (m/s²)²; a table in kilometres is read by FuzzyRules.of(table, unit=1000)"
            )


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _signed(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


# Lee, Joo & Park 2003, tables 2.1–2.3: c1 s1 c2 s2 in km, w in (km/s²)², identified for inputs of 1, 10 and 100 m/s²
_LEE_1 = [
    (2.330, 0.376, 0.254, 2.591, 0.215e-5),
    (-0.934, 3.615, -1.994, 4.134, 0.399e-5),
    (1.273, 1.904, -1.660, 0.438, 0.400e-5),
    (2.453, 2.436, -0.915, 5.081, 0.395e-5),
    (2.626, 2.264, -0.413, 2.913, 0.398e-5),
    (2.445, 0.937, 2.659, 5.467, 0.388e-5),
    (1.440, 2.979, 0.491, 3.385, 0.400e-5),
    (0.541, 1.400, -0.120, 5.353, 0.400e-5),
    (1.281, 3.035, -0.194, 2.300, 0.397e-5),
]
_LEE_10 = [
    (0.290, 2.588, -0.311, 3.965, 0.120e-3),
    (-0.262, 0.128, -0.007, 0.732, 0.055e-3),
    (-0.246, 0.188, 1.302, 2.340, 0.056e-3),
    (-1.330, 0.634, -1.800, 1.737, 0.115e-3),
    (0.464, 0.568, -0.235, 0.486, 0.121e-3),
    (-1.903, 0.705, -0.399, 3.820, 0.100e-3),
    (-1.891, 0.140, -1.747, 0.494, 0.108e-3),
    (-0.976, 0.187, -1.366, 4.191, 0.039e-3),
]
_LEE_100 = [
    (-2.533, 0.568, -1.577, 3.607, 0.026e-1),
    (0.302, 1.327, 0.806, 0.039, 0.100e-1),
    (0.528, 0.265, -0.381, 2.963, 0.096e-1),
    (-0.895, 0.350, 0.722, 2.050, 0.040e-1),
    (-0.084, 0.204, 0.241, 2.091, 0.083e-1),
    (-1.883, 0.293, -2.276, 1.568, 0.058e-1),
    (-1.072, 0.314, -2.166, 0.692, 0.057e-1),
    (0.944, 0.118, 1.267, 2.539, 0.046e-1),
]

PUBLISHED: dict[str, tuple[FuzzyRules, ...]] = {
    "lee-2003": tuple(FuzzyRules.of(table, unit=1000.0) for table in (_LEE_1, _LEE_10, _LEE_100))
}
