"""A bank of motion models on one sensor (or several): what Kalman and IMM are, run by the native engine."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._engine import native
from ..checks import Array, items, thread_count, whole
from ..estimate import Estimate
from ..io.stages import stage
from ..models.coasting import Coasting
from ..models.motion import AnyMotion, component_names, mode_names
from ..models.non_manoeuvring import non_manoeuvring_modes
from ..models.observed import Observed
from ..models.outliers import Outliers
from ..models.sensor import AnySensor
from ..models.start import OnePoint, Prior, TwoPoint
from .live import LiveBatch, LiveTarget
from .parts import Parts, is_fixed, native_mode
from .plain import VERSION, plain, write
from .results import allocate
from .row_noise import RowNoise
from .rows import Batch, prior_of_tracks
from .rules import declared_rules
from .slots import Slots
from .source import BatchSource

MOST_MODES = 512
MOST_TARGETS = 2**31 - 1  # live at once: the engine numbers them


class Bank:
    """Runs ``motions`` on ``sensor``; the named filters say how they interact."""

    motions: tuple[AnyMotion, ...]
    sensors: tuple[AnySensor, ...]
    outliers: Outliers | None
    initial: TwoPoint | OnePoint | Prior
    coast: float | None
    fitted: dict[str, object] = {}  # noqa: RUF012 # of a filter read from a file: what the file says it was fitted on
    not_smoothed: str = ""  # why there is no smoother, if there is none
    arguments: ClassVar[tuple[str, ...]]  # what a file holds of it beside motion models and sensors
    engine: Any  # runs it: native, or stepwise for models of your own
    declaration: native.Declaration | None = None  # what the native engine was made from

    _given: tuple[tuple[object, ...], dict[str, object]]  # what it was made of

    def __new__(cls, *args: object, **options: object) -> Self:
        """Keep the arguments: a copy or a pickle is made of them again."""
        made = super().__new__(cls)
        made._given = args, options
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as its arguments and what a file said of it; the engine is made again."""
        return _made_again, (type(self), *self._given, self.fitted)

    def __eq__(self, other: object) -> bool:
        """Equal where the class and every parameter are; filters on models of your own only where they are one."""
        if type(self) is not type(other) or not isinstance(other, Bank):
            return NotImplemented
        return self is other or (self._value is not None and self._value == other._value)

    def __hash__(self) -> int:
        return hash(self._value) if self._value is not None else id(self)

    @cached_property
    def _value(self) -> str | None:
        """Everything that a file would hold; None on models of your own."""
        if self.declaration is None:
            return None
        try:
            return json.dumps(self.described(), sort_keys=True)
        except TypeError:
            return None

    def _declare(
        self,
        motions: Sequence[Any],
        sensor: Any,
        outliers: Outliers | None,
        initial: TwoPoint | OnePoint | Prior | None,
        coast: float | None,
    ) -> None:
        """What every filter is given."""
        self.motions = items("motions", motions, "motion models")
        if not self.motions:
            raise ValueError("motions: expected at least one motion model")
        # the engine's limit, said before anything as large as the square of the number is computed
        if len(self.motions) > MOST_MODES:
            raise ValueError(f"motions: expected at most {MOST_MODES}, got {len(self.motions)}")
        for motion in self.motions:
            if _is_sensor(motion):
                name = type(motion).__name__
                raise TypeError(f"motion: got the sensor {name}; expected the motion model first, then the sensor")
            if not callable(getattr(motion, "native", None)) and not callable(getattr(motion, "f", None)):
                got = type(motion).__name__
                raise TypeError(f"motions: expected a motion model of jink or one with f(x, dt) and Q(dt), got {got}")
        self.sensors = as_sensors(sensor)
        self.outliers, self.coast = outliers, coast
        self.initial = initial if initial is not None else TwoPoint()

    def _prepare(
        self,
        *,
        transition: Any = 1.0,
        transition_step: float | None = None,
        mode_probability: ArrayLike | None = None,
        mixing: str = "prior",
        linearisation: str = "ekf",
        coast: float | None = None,
        coasting: Coasting | None = None,
        parts: Parts | None = None,
    ) -> None:
        self.not_smoothed = self.not_smoothed or next(filter(None, map(_unsmoothed, self.motions)), "")
        declaration = declared_rules(
            len(self.motions),
            self.initial,
            self.outliers,
            parts,
            transition=transition,
            transition_step=transition_step,
            mode_probability=mode_probability,
            mixing=mixing,
            linearisation=linearisation,
            coast=coast,
            coasting=coasting,
        )
        _check_units(self.motions, self.sensors)
        if all(hasattr(part, "native") for part in (*self.motions, *self.sensors)):
            self._run_natively(declaration, parts)
        elif parts is not None:
            raise TypeError(
                f"{type(self).__name__}: runs on jink's own motion and sensor models; models of your own work in "
                "Kalman and IMM"
            )
        else:
            self._run_stepwise(declaration)

    def _run_natively(self, declaration: native.Declaration, parts: Parts | None) -> None:
        modes = [native_mode(m, self.axes) for m in self.motions]
        if any(mode.around_side for mode in modes) and (parts is None or parts.side is None):
            raise ValueError(
                "motions: AccelerationLevel.estimated needs the estimate of a jink.AdaptiveIMM; "
                f"{type(self).__name__} has none; expected estimated=False"
            )
        declaration.modes = modes
        sensors: tuple[Any, ...] = self.sensors
        declaration.sensors = [s.native(self.outliers) for s in sensors]
        if parts is not None:
            parts.into(declaration, self.axes)
        self.declaration = declaration
        self.engine = native.Engine(declaration)

    def _run_stepwise(self, declaration: native.Declaration) -> None:
        from ..stepwise import Stepwise

        if getattr(self, "coasting", None) is not None:
            raise TypeError("coasting: works on jink's own motion and sensor models, not beside models of your own")
        if self.outliers is not None and self.outliers.hindsight:
            raise TypeError("outliers: expected hindsight=False beside motion and sensor models of your own")
        for motion in self.motions:
            if hasattr(motion, "native") and not is_fixed(native_mode(motion, self.axes)):
                raise TypeError(
                    f"motions: {type(motion).__name__} adapts its noise or adds an acceleration; beside models of your "
                    "own, expected motion models of fixed noise"
                )
        given_prior = isinstance(self.initial, Prior)
        self.engine = Stepwise(self.motions, self.sensors, self.axes, self.outliers, given_prior, declaration)

    @cached_property
    def axes(self) -> int:
        """Number of space axes: the sensors', or as many as your own model has positions."""
        for sensor in self.sensors:
            if axes := getattr(sensor, "axes", None):
                return int(axes)
        named = [set(getattr(m, "components", ())) & {"px", "py", "pz"} for m in self.motions]
        return max(map(len, named)) or 2

    @cached_property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of x: px, vx, (ax), ..., turn_rate, then your own names."""
        return getattr(self.engine, "components", None) or component_names(self.motions, self.axes)

    @cached_property
    def columns(self) -> int:
        """Number of columns of z: the components of the sensor that measures most."""
        return int(getattr(self.declaration or self.engine, "columns", 0))

    @property
    def counts_rows(self) -> bool:
        """Does a row without a measurement change more than the time?

        It does where detectors, the set of active modes or noise from residuals count rows.
        """
        d = self.declaration
        decides = d is not None and (d.proposal.kind != native.Propose.all or d.detection.window > 0)
        return decides or any(getattr(m, "remembers", False) for m in self.motions)

    @property
    def numbers(self) -> Array:
        """The parameters of the engine by which it can be differentiated; see :mod:`jink.fit.gradient`."""
        return np.asarray(native.numbers(self.engine))

    @cached_property
    def modes(self) -> tuple[str, ...]:
        """Names of the columns of mode_probability."""
        return mode_names(self.motions)

    @cached_property
    def non_manoeuvring(self) -> tuple[bool, ...]:
        """Whether a target in each mode flies straight: :mod:`jink.models.non_manoeuvring`."""
        return non_manoeuvring_modes(self.motions, self.axes)

    def filter(
        self,
        time: ArrayLike,
        z: ArrayLike,
        *,
        offsets: ArrayLike | None = None,
        sensor: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
        initial: Prior | None = None,
        threads: int | None = None,
        outputs: Sequence[str] | None = None,
        out: Estimate | None = None,
    ) -> Estimate:
        """Filter one track, or many laid end to end.

        time (N,) seconds or dates, not decreasing within a track; z (N, m), NaN or None where missing; offsets (B +
        1,), track b owning rows offsets[b] to offsets[b+1]; sensor (N,) index of each row's sensor; covariance (N, m,
        m), or (N, m) variances, of each row instead of the sensor's; input (N, axes) known acceleration (m/s²) since
        the row before; initial a :class:`jink.Prior` instead of the filter's own start; threads defaults to all cores;
        outputs names what to return, where ``P[px,vx]`` is one covariance by itself; out is an estimate of the same
        shapes to write into, which saves the system's clearing of new memory when filtering again and again. Errors:
        ValueError or TypeError naming the argument, and the row where there is one.
        """
        batch = self._batch(time, z, offsets, sensor, covariance, input, initial)
        return self._run(batch, threads, outputs, out)

    def smooth(
        self,
        time: ArrayLike,
        z: ArrayLike,
        *,
        lag: int | None = None,
        lag_seconds: float | None = None,
        offsets: ArrayLike | None = None,
        sensor: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        input: ArrayLike | None = None,
        initial: Prior | None = None,
        threads: int | None = None,
        outputs: Sequence[str] | None = None,
        out: Estimate | None = None,
    ) -> Estimate:
        """Filter, then smooth: every row's estimate uses its whole track. Arguments as in :meth:`filter`.

        With a ``lag`` it uses the rows up to so many scans after it, with ``lag_seconds`` those up to so many seconds
        after it: what live tracking with that lag gives. x, P and mode_probability are smoothed; log_likelihood, nis,
        pit and status are the filter's. Errors: ValueError for a filter that cannot be smoothed, with what to smooth
        instead. Method: docs/smoothing.md.
        """
        if self.not_smoothed:
            raise ValueError(f"smooth: cannot smooth {type(self).__name__}: {self.not_smoothed}")
        batch = self._batch(time, z, offsets, sensor, covariance, input, initial)
        return self._run(batch, threads, outputs, out, smooth=True, until=batch.until(lag, lag_seconds))

    @overload
    def start(
        self, n: None = None, *, lag: int = 0, state: bytes | None = None, outputs: Sequence[str] | None = None
    ) -> LiveTarget: ...
    @overload
    def start(
        self, n: int, *, lag: int = 0, state: bytes | None = None, outputs: Sequence[str] | None = None
    ) -> LiveBatch: ...
    def start(
        self,
        n: int | None = None,
        *,
        lag: int = 0,
        state: bytes | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Any:
        """Track live: one target, or n at once.

        ``live.update(t, z)`` returns the current estimate, ``live.predict(t)`` one at another time; with a ``lag`` of
        so many scans the estimate is that of the scan so long ago, smoothed by those since. ``live.save()`` gives the
        state as bytes, taken up again by ``state``.
        """
        lag = whole("lag", lag, 0, of=" of scans")
        if lag and self.not_smoothed:
            raise ValueError(f"lag: cannot smooth {type(self).__name__}: {self.not_smoothed}")
        n = None if n is None else whole("n", n, 1, MOST_TARGETS, of=" of targets")
        live: Any = self.engine.one(lag, self) if n is None else self._many(n, lag, outputs)
        if isinstance(self.initial, Prior):
            x, P = prior_of_tracks(self.initial, self.components, n or 1)
            for k in range(n or 1):
                begin = (x[k], P[k], np.nan) if n is None else (k, x[k], P[k], np.nan)
                live.begin(*begin)
        if state is not None:
            live.restore(state)
        return live

    def slots(self) -> Slots:
        """Track live targets that come and go. Errors: TypeError for models of your own."""
        if self.declaration is None:
            raise TypeError(f"{type(self).__name__}: slots are for jink's own motion and sensor models")
        live = self.engine.slots()
        if isinstance(self.initial, Prior):
            x, P = prior_of_tracks(self.initial, self.components, 1)
            live.begin_all(x[0], P[0])
        return Slots(
            live, self._estimate, components=len(self.components), modes=len(self.motions), columns=self.columns
        )

    def _many(self, n: int, lag: int, outputs: Sequence[str] | None) -> LiveBatch:
        return LiveBatch(
            self.engine.many(n, lag),
            n,
            self._estimate,
            again=(self, n, lag, outputs),
            components=len(self.components),
            modes=len(self.motions),
            columns=self.columns,
            sensors=len(self.sensors),
            axes=self.axes,
            outputs=outputs,
        )

    def _estimate(self, results: dict[str, Any]) -> Estimate:
        return Estimate(self.components, self.modes, results, self.non_manoeuvring)

    def described(self) -> dict[str, object]:
        """The filter as JSON holds it: its class, its models, and those of its ``arguments`` that are not None.

        Errors: TypeError for a model of your own whose class or fields a file cannot hold.
        """
        body: dict[str, object] = {"filter": type(self).__name__}
        body["motions"] = [plain(m) for m in self.motions]
        body["sensors"] = [plain(s) for s in self.sensors]
        given = {name: plain(getattr(self, name)) for name in self.arguments}
        return body | {name: value for name, value in given.items() if value is not None}

    def save(self, path: str | os.PathLike[str], **more: object) -> None:
        """Write the filter to a JSON file that :func:`jink.load` and ``jink track --filter`` read.

        ``more`` is kept in the file as well. Of a model of your own it holds the module and name of the class and its
        fields; ``jink.load(path, own=True)`` imports it. Errors: TypeError where a field is code.
        """
        write({"jink": "filter", "version": VERSION, "units": "SI", **self.described(), **more}, path)

    def _batch(
        self,
        time: ArrayLike,
        z: ArrayLike,
        offsets: ArrayLike | None = None,
        sensor: ArrayLike | None = None,
        covariance: ArrayLike | RowNoise | None = None,
        input: ArrayLike | None = None,
        initial: Prior | None = None,
    ) -> Batch:
        prior = initial if initial is not None else self.initial if isinstance(self.initial, Prior) else None
        if isinstance(covariance, RowNoise) and self.declaration is None:
            covariance = covariance[:]  # models of one's own run on arrays
        return Batch.of(
            time,
            z,
            offsets=offsets,
            sensor=sensor,
            covariance=covariance,
            input=input,
            prior=prior,
            columns=self.columns,
            sensors=len(self.sensors),
            axes=self.axes,
            components=self.components,
        )

    @stage("filter")
    def _run(
        self,
        batch: Batch,
        threads: int | None,
        outputs: Sequence[str] | None,
        out: Estimate | None,
        *,
        smooth: bool = False,
        until: NDArray[np.int64] | None = None,
    ) -> Estimate:
        slots = allocate(
            outputs,
            out,
            rows=batch.rows,
            tracks=batch.tracks,
            components=self.components,
            modes=len(self.motions),
            columns=self.columns,
        )
        self.engine.run(*batch.arguments(), *slots[1:], smooth, until, thread_count(threads))
        source = BatchSource(self, batch, smooth, tuple(slots.results), until is not None)
        return Estimate(self.components, self.modes, slots.results, self.non_manoeuvring, source=source)


def _made_again(kind: type[Bank], args: tuple[Any, ...], options: dict[str, Any], fitted: dict[str, object]) -> Bank:
    """A filter from its arguments."""
    filter = kind(*args, **options)
    if fitted:
        filter.fitted = fitted
    return filter


def _is_sensor(part: Any) -> bool:
    return isinstance(part, Observed) or (hasattr(part, "h") and not hasattr(part, "f"))


def _check_units(motions: tuple[Any, ...], sensors: tuple[Any, ...]) -> None:
    """Check that learned parts of the motions suit the residuals of these sensors."""
    for sd in {float(s.sd) for s in sensors if isinstance(getattr(s, "sd", None), int | float)}:
        for motion in motions:
            if hasattr(motion, "check_units"):
                motion.check_units(sd)


def _unsmoothed(motion: Any) -> str:
    """Why a mode cannot be smoothed, itself or the motion model that it wraps."""
    why = getattr(motion, "not_smoothed", "")
    return why or (_unsmoothed(motion.motion) if hasattr(motion, "motion") else "")


def as_sensors(sensor: Any) -> tuple[Any, ...]:
    """One sensor or several, all in the same axes."""
    sensors = tuple(sensor) if isinstance(sensor, Sequence) else (sensor,)
    if not sensors:
        raise ValueError("sensor: expected at least one")
    for s in sensors:
        if not isinstance(s, Observed) and (hasattr(s, "native") or not callable(getattr(s, "h", None))):
            raise TypeError(f"sensor: expected one of jink's sensors or one with h(x), got {type(s).__name__}")
    axes = [str(s.axes) for s in sensors if getattr(s, "axes", None)]
    if len(set(axes)) > 1:
        raise ValueError(f"sensor: all must have the same axes, got {', '.join(axes)}")
    return sensors
