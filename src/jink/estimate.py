"""What a filter returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Literal, Protocol, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .checks import numbers
from .frame_of import frame_of, html_of
from .times import duration

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingModuleSource]
    import polars
    import pyarrow  # pyright: ignore[reportMissingImports]


class Status(IntEnum):
    """What became of a row; the engine has the same numbers under the same names."""

    none = 0  # the track has not started
    updated = 1
    predicted = 2  # nothing was measured
    gated = 3  # what was measured was not believed
    restarted = 4
    initialised = 5


STATUS = tuple(Status.__members__)  # the names, in the order of their numbers


class UnknownComponent(KeyError, ValueError):
    """A component that an estimate does not have."""


def component_index(components: tuple[str, ...], name: str) -> int:
    """Where a component stands in x. Errors: KeyError (a ValueError too) naming those that there are."""
    if not isinstance(name, str) or name not in components:
        raise UnknownComponent(f"component {name!r}: expected one of {', '.join(components)}")
    return components.index(name)


def covariance_name(first: str, second: str) -> str:
    """The output that holds the covariance of two components alone: P[px,vx]."""
    return f"P[{first},{second}]"


def covariance_pair(name: str, components: tuple[str, ...]) -> tuple[int, int] | None:
    """Row and column of P that such an output names; None for another name."""
    if not name.startswith("P[") or not name.endswith("]"):
        return None
    first, _, second = name[2:-1].partition(",")
    if first not in components or second not in components:
        return None
    return components.index(first), components.index(second)


class Source(Protocol):
    """The rows that an estimate was made of, and how it was made."""

    @property
    def time(self) -> NDArray[np.float64]:
        """Of each row, s."""
        ...

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Where tracks begin, and the end: (B + 1,)."""
        ...

    def part(self, first: int, end: int) -> Source:
        """Some of the tracks."""
        ...

    def at(self, times: list[NDArray[np.float64]]) -> Estimate:
        """Estimates of every track at its own times."""
        ...


@dataclass(repr=False, eq=False)
class Estimate:
    """Estimates row by row, for the outputs that were asked for; the others raise AttributeError when looked at.

    x (N, n) and P (N, n, n): mean and covariance in ``components``, or P[px,py] (N,), one covariance by itself;
    mode_probability (N, M) of ``modes``; log_likelihood (B,) per track and log_likelihood_scan (N,) per row; nis (N,)
    of the moment-matched innovation with nis_dof components (for several modes not exactly χ²: pit (N, m), the
    probability integral transform of each measured component given those before it, is uniform for a consistent
    filter); status (N,) of :class:`Status`. NaN before a track starts. non_manoeuvring: of each mode whether a target
    in it does not manoeuvre (:mod:`jink.models.non_manoeuvring`).

    ``est["vx"]`` is a component, ``est.sd("vx")`` its standard deviation. ``len(est)`` counts targets, ``est[0]`` is
    the first one's estimate, ``est[2:5]`` that of three.
    """

    components: tuple[str, ...]
    modes: tuple[str, ...]
    results: dict[str, NDArray[Any]]
    non_manoeuvring: tuple[bool, ...] = ()
    source: Source | None = field(default=None, kw_only=True)

    @property
    def manoeuvring(self) -> NDArray[np.float64]:
        """Probability (N,) of the modes in which a target manoeuvres; NaN for a filter whose modes do not tell
        manoeuvres apart.
        """
        mu = self.mode_probability
        if not any(self.non_manoeuvring):
            return np.full(mu.shape[:-1], np.nan)
        return np.clip(1.0 - mu[..., np.array(self.non_manoeuvring)].sum(axis=-1), 0.0, 1.0)

    @property
    def scored(self) -> NDArray[np.bool_]:
        """Rows (N,) whose measurement met a prediction, believed or not: those that have a likelihood and a NIS to
        compare.
        """
        return np.isin(self.status, (Status.updated, Status.gated))

    @property
    def time(self) -> NDArray[np.float64]:
        """Of each row (N,), s."""
        if "time" in self.results:
            return self.results["time"]
        return self._rows().time

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Where targets begin, and the end: (B + 1,). Live, each target has one row."""
        if self.source is not None:
            return self.source.offsets
        if "time" in self.results and "status" in self.results:
            return np.arange(len(self.results["status"]) + 1)
        return self._rows().offsets

    def at(self, times: ArrayLike) -> Estimate:
        """Every target at other times (s): predicted from what is known there, smoothed where the estimate is smoothed.

        times (T,) for all targets, in any order. At a row's time it is that row's estimate, between two rows the
        prediction from the one before, and before the first row NaN. A smoothed estimate is smoothed anew with a row
        without a measurement at each time, so that both sides count. Of the outputs x, P, mode_probability and status
        come back. Errors: ValueError for an estimate that does not know its rows, or was smoothed with a lag.
        """
        wanted = np.atleast_1d(numbers("times", times))
        if wanted.ndim != 1 or not np.isfinite(wanted).all():
            raise ValueError("times: expected finite numbers of seconds (T,)")
        return self._rows().at([wanted] * len(self))

    def resample(self, step: float | str) -> Estimate:
        """Every target at a fixed step of time, 0.5 or ``"500ms"``, from its first row to its last; see :meth:`at`."""
        source, every = self._rows(), _step(step)
        bounds = zip(source.offsets[:-1], source.offsets[1:], strict=True)
        return source.at([_grid(source.time[first:end], every) for first, end in bounds])

    @overload
    def to_frame(self, backend: Literal["polars"] = "polars") -> polars.DataFrame: ...
    @overload
    def to_frame(self, backend: Literal["pandas"]) -> pandas.DataFrame: ...
    @overload
    def to_frame(self, backend: Literal["pyarrow"]) -> pyarrow.Table: ...
    def to_frame(self, backend: Literal["polars", "pandas", "pyarrow"] = "polars") -> Any:
        """A DataFrame: target, time, each component and its sd, mode probabilities, manoeuvring, NIS and status.

        Errors: ImportError naming the package that is missing; ValueError for another backend.
        """
        return frame_of(self, STATUS, backend)

    def __getattr__(self, name: str) -> NDArray[Any]:
        results = self.__dict__.get("results", {})
        if name in results:
            return results[name]
        raise AttributeError(f"{name}: not among the outputs asked for, {', '.join(results)}")

    @overload
    def __getitem__(self, which: str) -> NDArray[np.float64]: ...
    @overload
    def __getitem__(self, which: int | slice) -> Estimate: ...
    def __getitem__(self, which: str | int | slice) -> Any:
        """A component's estimates by name, or the estimate of one target, or of several that follow each other."""
        if isinstance(which, str):
            return self.x[..., component_index(self.components, which)]
        count = len(self)
        if isinstance(which, slice):
            first, end, step = which.indices(count)
            if step != 1:
                raise ValueError(f"targets: expected a step of 1, got {step}")
            return self._part(first, max(first, end))
        if not -count <= which < count:
            raise IndexError(f"target {which}: there are {count}")
        return self._part(which % count, which % count + 1)

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __iter__(self) -> Iterator[Estimate]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other) or not isinstance(other, Estimate):
            return NotImplemented
        named = (self.components, self.modes, self.non_manoeuvring, self.results.keys())
        same = named == (other.components, other.modes, other.non_manoeuvring, other.results.keys())
        return same and all(
            np.array_equal(value, other.results[name], equal_nan=value.dtype.kind == "f")
            for name, value in self.results.items()
        )

    __hash__ = None  # type: ignore[assignment] # its arrays can change

    def covariance(self, first: str, second: str) -> NDArray[np.float64]:
        """Two components' covariance, by name: of P, or an output by itself."""
        i, j = component_index(self.components, first), component_index(self.components, second)
        for name in (covariance_name(first, second), covariance_name(second, first)):
            if name in self.results:
                return self.results[name]
        return self.P[..., i, j]

    def sd(self, component: str) -> NDArray[np.float64]:
        """One component's standard deviation, by name."""
        return np.sqrt(self.covariance(component, component))

    def _rows(self) -> Source:
        if self.source is None:
            raise ValueError(
                "this estimate does not know the rows it was made of; expected one of filter() or smooth()"
            )
        return self.source

    def _part(self, first: int, end: int) -> Estimate:
        rows = slice(int(self.offsets[first]), int(self.offsets[end]))
        cut = {
            name: value[first:end] if name == "log_likelihood" and self.source is not None else value[rows]
            for name, value in self.results.items()
        }
        return replace(self, results=cut, source=None if self.source is None else self.source.part(first, end))

    def __repr__(self) -> str:
        rows = len(next(iter(self.results.values()), ()))
        said = [f"components {' '.join(self.components)}", f"modes {' '.join(self.modes)}"]
        head = f"{rows:,} rows"
        if self.source is not None and rows and "x" in self.results:
            t = self.source.time
            head = f"{len(self):,} target{'' if len(self) == 1 else 's'}, {rows:,} rows, {t.min():g} to {t.max():g} s"
        return f"Estimate({head}; {'; '.join(said)}; {', '.join(self.results)})"

    def _repr_html_(self) -> str:
        """A small table, and a picture of the plane, for notebooks."""
        return html_of(self, STATUS)


MOST_ROWS = 10**9  # of one target: 8 GB of times alone
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "m": 60.0, "h": 3600.0}


def _step(step: float | str) -> float:
    """Seconds of 0.5, "500ms", "1s", "5m" or "1h"."""
    value = duration(step, UNITS)
    if np.isnan(value):
        raise ValueError(f"step: expected seconds above 0, or text such as '500ms', '1s' or '5m', got {step!r}")
    return value


def _grid(time: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    if not len(time):
        return np.empty(0)
    steps = float((time[-1] - time[0]) / step * (1 + 1e-12))
    if not steps < MOST_ROWS:
        raise ValueError(f"step: expected fewer than {MOST_ROWS:,} rows of a target, got {steps:.3g} at {step:g} s")
    count = int(np.floor(steps)) + 1
    return time[0] + step * np.arange(count)
