"""Many targets from plots without identity, scan by scan or a table at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._engine import native
from ..checks import Array, covariance, numbers, positive, probability, thread_count, whole
from ..estimate import Estimate
from ..filters.bank import Bank
from ..filters.rows import indices, row_noise
from ..models.radar import Radar
from ..times import Time, moment, seconds
from .batch import run_table
from .detection import Detections
from .extent import Extent
from .history import History
from .lagged import Laggards
from .picture import Picture
from .rules import association_called, check_filter, named_radars

F = TypeVar("F")  # a DataFrame of any library
SPEED_SD = 150.0  # m/s, of a target's velocity before anything is known of it
ABREAST = (
    16.0  # squared distance of velocities from which tracks part by themselves and own no plots against each other
)


class Tracker:
    """Tracks every target of a sky with ``filter``, from plots that do not say whose they are.

    sensors: a :class:`jink.Radar`, several, or several by name. new_per_hour: targets that come into view, and
    targets: how many are there at the start, both about; None: ten times the first scan's plots an hour, and a tenth of
    them. drop_after: seconds without a plot after which a track ends; None: existence alone decides. stay: mean seconds
    that a target stays in view. speed_sd (m/s): of a velocity before the second plot. association: marginal, gnn,
    nearest, pda or jpda. report: from this existence on, tracks that are not confirmed are in the picture too.
    history: a scan may be late by so many scans; it is then taken as if it had come in time. lag: ``picture.lagged``
    says where tracks were so many scans ago, by their most probable plots until now; not with history. threads: 1, or
    None for all cores.
    Method: docs/many-targets.md. Errors: ValueError or TypeError naming the argument.
    """

    def __init__(
        self,
        filter: Bank,
        sensors: Radar | Sequence[Radar] | Mapping[str, Radar] | None = None,
        *,
        new_per_hour: float | None = None,
        targets: float | None = None,
        drop_after: float | None = None,
        stay: float = 3600.0,
        speed_sd: float = SPEED_SD,
        association: str = "marginal",
        report: float = 0.5,
        history: int = 0,
        lag: int = 0,
        threads: int | None = 1,
    ) -> None:
        check_filter(filter)
        self.filter, self.association = filter, association
        self.radars = named_radars(Radar() if sensors is None else sensors)
        for name, value in (("new_per_hour", new_per_hour), ("targets", targets)):
            if value is not None:
                positive(name, value, zero=True)
        self.new_per_hour, self.targets = new_per_hour, targets
        self.history = whole("history", history, 0, 1000)
        self.lag = whole("lag", lag, 0, 1000)
        self.report = report if report == 0 else probability("report", report)
        rules = native.ManyRules()
        rules.association = association_called(association)
        rules.life = positive("stay", stay)
        rules.drop_after = np.inf if drop_after is None else positive("drop_after", drop_after)
        rules.threads, rules.abreast = thread_count(threads), ABREAST
        self.rules = rules
        self._declaration = self._declared(positive("speed_sd", speed_sd))
        self._engine = native.Engine(self._declaration)
        self._columns = [s.rows for s in self._sensors]
        self.reset()

    def _declared(self, speed_sd: float) -> native.Declaration:
        """The filter's declaration without what existence replaces: its gate, restart, coast and two-point start."""
        assert self.filter.declaration is not None  # check_filter looked
        d = native.Declaration(self.filter.declaration)
        own: list[Any] = list(self.filter.sensors)
        models = [radar.measures() for radar in self.radars.values()]
        if len(models) > len(own) and any(m is None for m in models):
            raise ValueError(
                "sensors: the filter has fewer sensors than there are radars; say what each radar measures"
            )
        given: list[Any] = [own[k] if model is None else model for k, model in enumerate(models)]
        for name, model in zip(self.radars, given, strict=True):
            if not hasattr(model, "native"):
                raise ValueError(f"sensors: {name} measures with a model of your own; expected one of jink's sensors")
            if not model.components or model.components[0] == "azimuth":
                raise ValueError(f"sensors: {name} measures no position; tracks begin at positions")
            if getattr(model, "axes", None) not in (None, self.filter.axes):
                raise ValueError(f"sensors: {name} has {model.axes} axes, the filter {self.filter.axes}")
        self._models, self._sensors = given, [model.native() for model in given]
        if self.lag and (self.history or any(model is not None for model in models)):
            raise ValueError(
                "lag: expected none beside history, or radars that measure otherwise than the filter's sensors"
            )
        self._spread = [float(np.sqrt(s.noise[0])) for s in self._sensors]
        d.sensors = self._sensors
        d.outlier_share, d.hindsight, d.restart_after, d.coast = 0.0, False, 0, 0.0
        d.coasting = native.Coasting()
        d.start, d.velocity_variance = native.Start.one_point, speed_sd**2
        return d

    def reset(self) -> None:
        """Forget all tracks, and what was learned of the clutter."""
        self._laggards = Laggards(self.filter, self.lag) if self.lag else None
        self._history = History(self.history)
        self._begin()

    def _begin(self) -> None:
        views = []
        for radar in self.radars.values():
            view = native.SensorView()
            (x0, x1, y0, y1), (x, y, reach) = radar.limits()
            view.within(x0, x1, y0, y1)
            view.around(x, y, reach)
            view.detection, view.scanning = radar.detection, radar.scanning
            view.learning = radar.learn_clutter
            views.append(view)
        self._many = self._engine.association(self.rules, views)
        self._extents = [Extent() for _ in views]
        self._detections = [Detections() for _ in views]

    def add(self, time: Time, x: ArrayLike, P: ArrayLike, existence: float = 0.999) -> int:
        """A target that is known to be there: mean x and covariance P in ``filter.components``. Returns its id."""
        n = len(self.filter.components)
        mean = np.ascontiguousarray(numbers("x", x).reshape(-1))
        if mean.shape != (n,):
            raise ValueError(f"x: expected {n} components, {' '.join(self.filter.components)}, got {mean.size}")
        return self._many.add(moment(time), mean, covariance("P", P, n), probability("existence", existence))

    def scan(
        self,
        time: Time,
        plots: ArrayLike,
        sensor: str | None = None,
        *,
        covariance: ArrayLike | None = None,
        code: ArrayLike | None = None,
        times: ArrayLike | None = None,
    ) -> Picture:
        """All plots (m, components) of one scan of a sensor; none is a scan too.

        times (m,) of each plot, where the scan takes time as a turning antenna's does: each track is then predicted to
        the time of the plot nearest to it; ``time`` is that of the middle of the scan, for tracks without one.
        time (s or a date) must not run back by more than ``history`` scans. covariance (m, k) variances or (m, k, k) of
        each plot, instead of the sensor's; code (m,) whole numbers from 0 where a plot says who it is (Mode S, MMSI),
        −1 where not.
        Errors: ValueError naming the argument.
        """
        t = moment(time)
        now = self._many.time
        scan = (t, plots, sensor, covariance, code, times)
        if t < now and not self.history:
            raise ValueError(
                f"time: {t:g} s lies before the last scan, at {now:g} s; scans must be in order, or history= some scans"
            )
        if not self.history:
            return self._scan(*scan)
        taken = self._history.take(t, scan, now, self.save, self._restore, self._scan)
        return self._picture(now, {"late": self._history.late}) if taken is None else taken

    def _scan(
        self,
        t: float,
        plots: ArrayLike,
        sensor: str | None,
        covariance: ArrayLike | None,
        code: ArrayLike | None,
        times: ArrayLike | None,
        sector: tuple[Any, ...] | None = None,
    ) -> Picture:
        which = self._index(sensor)
        z = self._plots(plots, which)
        self._prepare(which, z)
        noise = None if covariance is None else row_noise(covariance, len(z), z.shape[1])
        codes = None if code is None else _codes(code, len(z))
        own = None if times is None else _times(times, len(z))
        report = self._many.scan(t, which, z, noise, self._unit(which, z), codes, own, sector)
        picture = self._picture(t, report)
        self._learn_detection(which, report)
        if self._laggards is None:
            return picture
        return replace(picture, lagged=self._laggards.take(picture, z, which, noise))

    def _learn_detection(self, which: int, report: dict[str, Any]) -> None:
        radar = list(self.radars.values())[which]
        if not radar.learn_detection or not report["sure"]:
            return
        self._detections[which].take(report, radar.detection)
        view = self._many.view(which)
        found = self._detections[which].probability(radar.detection)
        if found != view.detection:
            view.detection = found
            self._many.set_view(which, view)

    def _index(self, sensor: str | None) -> int:
        if sensor is None and len(self.radars) == 1:
            return 0
        if not isinstance(sensor, str) or sensor not in self.radars:
            raise ValueError(f"sensor: {sensor!r} was not declared; expected one of {', '.join(self.radars)}")
        return list(self.radars).index(sensor)

    def _plots(self, plots: ArrayLike, which: int) -> Array:
        columns = self._columns[which]
        z = numbers("plots", plots)
        z = z.reshape(0, columns) if z.size == 0 else z
        if z.ndim != 2 or z.shape[1] != columns:
            names = ", ".join(self._models[which].components)
            raise ValueError(f"plots: expected (m, {columns}): {names}; got shape {z.shape}")
        if np.isinf(z).any():
            raise ValueError("plots: has infinite values; a missing component is NaN")
        return np.ascontiguousarray(z)

    def _prepare(self, which: int, z: Array) -> None:
        """What was not declared of a sensor, from its plots: densities at first, and the area as it grows."""
        radar, known = list(self.radars.values())[which], self._extents[which].count > 0
        if not len(z) or (known and radar.size() is not None):
            return
        points = self._models[which].positions(z)
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return
        extent = self._extents[which]
        extent.take(points)
        view = self._many.view(which)
        area = extent.area(radar, list(self.radars.values()), self._spread[which])
        if known:
            for name in ("clutter", "undetected", "arrivals"):
                setattr(view, name, getattr(view, name) * view.area / area)
        else:
            count = len(points)
            clutter = count if radar.clutter_per_scan is None else radar.clutter_per_scan
            view.clutter = max(clutter, 1e-3) / area
            view.undetected = (0.1 * count if self.targets is None else self.targets) / area
            view.arrivals = (10.0 * count if self.new_per_hour is None else self.new_per_hour) / 3600.0 / area
        view.area = area
        self._many.set_view(which, view)

    def _unit(self, which: int, z: Array) -> Array | None:
        """Density of plots in the space of the measurements over their density in the plane, of each plot."""
        model, radar = self._models[which], list(self.radars.values())[which]
        if getattr(model, "method", "") == "converted":
            return None if model.axes == 2 else np.full(len(z), 1.0 / radar.height)
        factors = {
            "azimuth": z[:, 0],
            "elevation": z[:, 0] / radar.height,
            "height": 1.0 / radar.height,
            "z": 1.0 / radar.height,
            **dict.fromkeys(("range_rate", "vx", "vy", "vz"), 0.5 / radar.fastest),
        }
        unit = np.ones(len(z))
        for column, name in enumerate(model.components):
            if name in factors:
                unit *= np.where(np.isnan(z[:, column]), 1.0, factors[name])
        return None if (unit == 1.0).all() else np.maximum(unit, 1e-300)

    def _picture(self, time: float, report: dict[str, Any]) -> Picture:
        found = self._many.tracks(self.report, True)
        results = {name: found[name] for name in ("x", "P", "mode_probability", "status")}
        f = self.filter
        return Picture(
            time=time,
            times=found["time"],
            ids=found["id"],
            existence=found["existence"],
            confirmed=found["confirmed"],
            age=found["age"],
            plot=found["plot"],
            due=found["due"],
            estimate=Estimate(f.components, f.modes, results, f.non_manoeuvring),
            lone=np.asarray(self._many.lone()),
            report=report,
        )

    def run(self, data: F, smooth: bool = False) -> F:
        """Every scan of a DataFrame with `time` and the sensor's components: see :func:`run_table` in ``batch.py``.

        smooth: every estimate uses its whole track, and all plots by their weights.
        """
        return run_table(self, data, smooth)

    def taken(self) -> dict[str, NDArray[Any]]:
        """Of the tracks of the last scan, in the picture's order, which plots they have taken, and how surely."""
        return self._many.taken(self.report)

    def components_of(self, sensor: str | None = None) -> tuple[str, ...]:
        """Names of the columns of a sensor's plots."""
        return tuple(self._models[self._index(sensor)].components)

    @property
    def clutter_per_scan(self) -> dict[str, float]:
        """The estimated number of false plots per scan of each sensor."""
        views = [self._many.view(k) for k in range(len(self.radars))]
        return {name: view.clutter * view.area for name, view in zip(self.radars, views, strict=True)}

    @property
    def detection(self) -> dict[str, float]:
        """The detection probability of each sensor, as declared or learned."""
        return {name: self._many.view(k).detection for k, name in enumerate(self.radars)}

    def save(self) -> bytes:
        """All tracks and what was learned, for :meth:`load` of a tracker with the same arguments."""
        views = [self._many.view(k) for k in range(len(self.radars))]
        learned = zip(self._extents, self._detections, views, strict=True)
        head = [[*e.numbers, d.hits, d.scans, view.area, view.detection] for e, d, view in learned]
        return np.array(head).tobytes() + self._many.save()

    def load(self, state: bytes) -> None:
        """Go on from a saved state; a lag looks back on later scans alone. Errors: ValueError where it is another's."""
        self._laggards = Laggards(self.filter, self.lag) if self.lag else None
        self._history = History(self.history)
        self._restore(state)

    def _restore(self, state: bytes) -> None:
        if not isinstance(state, bytes):
            raise TypeError(f"state: expected the bytes that save() gave, got {type(state).__name__}")
        size = 72 * len(self.radars)
        if len(state) < size:
            raise ValueError("state: is cut short, or was saved by another tracker")
        self._begin()
        self._many.restore(state[size:])
        for k, numbers_ in enumerate(np.frombuffer(state[:size]).reshape(-1, 9)):
            self._extents[k] = Extent.of(numbers_[:5].tolist())
            self._detections[k] = Detections(*numbers_[5:7].tolist())
            view = self._many.view(k)
            view.area, view.detection = numbers_[7:].tolist()
            self._many.set_view(k, view)


def _times(times: ArrayLike, rows: int) -> Array:
    own = np.ascontiguousarray(np.asarray(seconds(times), float).reshape(-1))
    if own.shape != (rows,) or not np.isfinite(own).all():
        raise ValueError(f"times: expected a time for each of {rows} plots")
    return own


def _codes(code: ArrayLike, rows: int) -> np.ndarray:
    codes = np.asarray(numbers("code", code) if isinstance(code, str | bytes) else indices("code", code))
    if codes.shape != (rows,) or not np.issubdtype(codes.dtype, np.integer):
        raise ValueError(f"code: expected a whole number for each of {rows} plots, -1 where it says none")
    return np.ascontiguousarray(codes, np.int64)
