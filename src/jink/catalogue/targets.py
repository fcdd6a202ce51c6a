"""Kinds of target: everything that is known of each, and the default filter that comes of it.

A kind is one entry of `KINDS`; the command line, tracking, fitting and comparisons read nothing else.

Noises are densities (psd) and switching is a chain in continuous time, so a filter means the same at any scan
period; vertical motion has its own figures. Reasons and figures: docs/default-filters.md.
"""

from __future__ import annotations

from dataclasses import fields, replace

from ..checks import positive, unknown, whole, with_attributes
from ..filters.imm import IMM
from ..frozen import frozen
from ..io.errors import InputError
from ..models.coasting import Coasting
from ..models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Motion
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import TwoPoint
from ..models.switching import Sojourn

RARE = 10  # usual steps without a position after which a track is given up, if that is longer than the kind's `coast`

SEVERAL = 3  # usual steps without a position after which a target coasts, if that is longer than its kind says


@frozen(kw_only=True)
class Kind:
    """What is known of targets of one kind.

    modes: motion models, a sequence in them being (x, y, z); seconds: mean time in each mode; to: which one follows,
    rows sum to one; speed (m/s): about the fastest, the velocity's sd until there is a second position; extent (m):
    where an outlier may lie, horizontally and vertically; coast (s): a track without a position for longer is given up,
    or cut in two; acceleration (m/s²): what a target pulls when it manoeuvres; position_sd (m): of a measurement, where
    the data do not tell; coasting: what a target does while nothing is measured. manoeuvre_g: a mean acceleration over
    manoeuvre_seconds that is larger is a manoeuvre, horizontally and vertically, in g. height (m): of a target above
    the radar, mean and sd, where nothing tells it. climbs: the sd of the climb rate (m/s), and how
    long it lasts (s).
    """

    summary: str
    modes: tuple[Motion, ...]
    seconds: tuple[float, ...]
    to: tuple[tuple[float, ...], ...]
    speed: float
    extent: tuple[float, float]
    coast: float
    acceleration: float
    position_sd: float
    coasting: Coasting
    manoeuvre_g: tuple[float, float]
    manoeuvre_seconds: float
    height: tuple[float, float] = (0.0, 0.0)
    climbs: tuple[float, float] = (1.0, 20.0)

    def gap(self, step: float) -> float:
        """Seconds without a position after which a track begins anew; step (s): the usual time between two."""
        return max(self.coast, RARE * step)

    def motions(self, axes: int) -> list[Motion]:
        """The motion models in two axes or three."""
        return [_in_axes(mode, axes) for mode in self.modes]

    def filter(
        self, sensor: Sensor, axes: int | None = None, *, interval: float = 0.0, coast: float | None = None
    ) -> IMM:
        """The default IMM, see :func:`jink.default_filter`."""
        with_attributes("sensor", sensor, ("axes", "extents"), "one of jink's sensors")
        n = sensor.axes or 2 if axes is None else whole("axes", axes, 1, 3)
        if n < 2:
            raise ValueError("default_filter: expected a sensor of 2 or 3 axes, got 1; the default filters model turns")
        if positive("interval", interval, zero=True) > 1e9:
            raise ValueError(f"interval: expected seconds between positions, got {interval:g}")
        rarer = max(1.0, RARE * interval / self.coast)
        wait = rarer * self.coast if coast is None else positive("coast", coast, zero=True)
        extent = sensor.extents(rarer * self.extent[0], rarer * self.extent[1], self.speed)
        return IMM(
            self.motions(n),
            sensor,
            Sojourn(self.seconds, self.to),
            outliers=Outliers(share=0.01, extent=extent, restart_after=2, hindsight=True),
            initial=TwoPoint(velocity_sd=positive("speed", self.speed), bounded=True),
            coast=wait or None,
            coasting=replace(self.coasting, after=max(self.coasting.after, SEVERAL * interval)),
        )


def _in_axes(mode: Motion, axes: int) -> Motion:
    cut = {f.name: getattr(mode, f.name)[:axes] for f in fields(mode) if isinstance(getattr(mode, f.name), tuple)}
    return replace(mode, **cut)


def three_modes(
    *,
    straight: tuple[float, float],
    jerk: tuple[float, float],
    acceleration: tuple[float, float],
    turn: tuple[float, float],
    turn_rate_psd: float,
    turn_rate: float,
) -> tuple[Motion, ...]:
    """Constant velocity, constant acceleration and coordinated turn; pairs are (horizontal, vertical).

    straight, turn: acceleration psd of the first and the last (m²/s³); jerk: psd (m²/s⁵); acceleration: sd on entering
    (m/s²).
    """

    def each(pair: tuple[float, float]) -> tuple[float, float, float]:
        return pair[0], pair[0], pair[1]

    return (
        ConstantVelocity(acceleration_psd=each(straight)),
        ConstantAcceleration(jerk_psd=each(jerk), acceleration_prior_sd=each(acceleration)),
        CoordinatedTurn(acceleration_psd=each(turn), turn_rate_psd=turn_rate_psd, turn_rate_prior_sd=turn_rate),
    )


EVEN = ((0.0, 0.5, 0.5), (0.9, 0.0, 0.1), (0.9, 0.1, 0.0))

AIRCRAFT = Kind(
    summary="airliners and light aircraft, below 1 g",
    modes=three_modes(
        straight=(0.02, 0.01),
        jerk=(0.1, 0.05),
        acceleration=(1.0, 0.35),
        turn=(4.0, 0.1),
        turn_rate_psd=3e-7,
        turn_rate=0.03,
    ),
    seconds=(60.0, 12.0, 40.0),
    to=((0.0, 0.9, 0.1), (0.8, 0.0, 0.2), (0.6, 0.4, 0.0)),
    speed=300.0,
    extent=(1e5, 1e4),
    coast=300.0,
    acceleration=3.0,
    position_sd=30.0,
    coasting=Coasting(after=20.0, manoeuvre=10.0, climb=30.0, reverses=False),
    manoeuvre_g=(0.05, 0.03),
    manoeuvre_seconds=8.0,
    height=(3000.0, 2500.0),
    climbs=(8.0, 100.0),
)

FIGHTER = Kind(
    summary="fast targets, up to 9 g",
    modes=(
        ConstantVelocity(acceleration_psd=0.0481),
        ConstantAcceleration(jerk_psd=0.608, acceleration_prior_sd=0.746),
        ConstantAcceleration(jerk_psd=(142.0, 142.0, 35.0), acceleration_prior_sd=(46.6, 46.6, 15.0)),
        CoordinatedTurn(acceleration_psd=(4.46, 4.46, 1.0), turn_rate_psd=3.13e-8, turn_rate_prior_sd=0.0579),
    ),
    seconds=(45.5, 11.0, 6.5, 15.4),
    to=(
        (0.0, 0.007, 0.297, 0.696),
        (0.973, 0.0, 0.019, 0.008),
        (0.013, 0.888, 0.0, 0.099),
        (0.454, 0.54, 0.006, 0.0),
    ),
    speed=1500.0,
    extent=(1e5, 2e4),
    coast=120.0,
    acceleration=40.0,
    position_sd=30.0,
    coasting=Coasting(after=20.0, manoeuvre=5.0, climb=20.0),
    manoeuvre_g=(0.5, 0.3),
    manoeuvre_seconds=4.0,
    height=(5000.0, 4000.0),
    climbs=(60.0, 20.0),
)

KINDS: dict[str, Kind] = {
    "aircraft": AIRCRAFT,
    "fighter": FIGHTER,
    "vessel": Kind(
        summary="ships and boats: below 0.05 g, turns of about 1 degree per second",
        modes=three_modes(
            straight=(1e-4, 1e-6),
            jerk=(1e-5, 1e-8),
            acceleration=(0.05, 0.001),
            turn=(1e-3, 1e-6),
            turn_rate_psd=1e-7,
            turn_rate=0.01,
        ),
        seconds=(300.0, 60.0, 60.0),
        to=EVEN,
        speed=25.0,
        extent=(5e4, 100.0),
        coast=1800.0,
        acceleration=0.2,
        position_sd=10.0,
        coasting=Coasting(after=120.0, manoeuvre=60.0, climb=60.0, reverses=False),
        manoeuvre_g=(0.003, 0.003),
        manoeuvre_seconds=30.0,
    ),
    "vehicle": Kind(
        summary="road vehicles: braking and cornering below 0.5 g",
        modes=three_modes(
            straight=(0.02, 1e-3),
            jerk=(0.3, 1e-3),
            acceleration=(2.0, 0.1),
            turn=(0.1, 1e-3),
            turn_rate_psd=1e-4,
            turn_rate=0.2,
        ),
        seconds=(20.0, 6.0, 6.0),
        to=EVEN,
        speed=50.0,
        extent=(2e4, 1e3),
        coast=300.0,
        acceleration=3.0,
        position_sd=5.0,
        coasting=Coasting(after=10.0, manoeuvre=4.0, climb=10.0, reverses=False),
        manoeuvre_g=(0.1, 0.05),
        manoeuvre_seconds=3.0,
    ),
    "drone": Kind(
        summary="multicopters and small fixed-wing drones: below 1 g, quick turns",
        modes=three_modes(
            straight=(0.05, 0.02),
            jerk=(3.0, 1.0),
            acceleration=(4.0, 2.0),
            turn=(0.3, 0.1),
            turn_rate_psd=1e-3,
            turn_rate=0.4,
        ),
        seconds=(15.0, 4.0, 5.0),
        to=EVEN,
        speed=40.0,
        extent=(1e4, 1e3),
        coast=60.0,
        acceleration=5.0,
        position_sd=3.0,
        coasting=Coasting(after=5.0, manoeuvre=2.0, climb=5.0),
        manoeuvre_g=(0.1, 0.1),
        manoeuvre_seconds=2.0,
        height=(100.0, 100.0),
        climbs=(3.0, 10.0),
    ),
    "person": Kind(
        summary="people on foot or by bicycle",
        modes=three_modes(
            straight=(0.01, 1e-3),
            jerk=(0.2, 1e-3),
            acceleration=(1.0, 0.05),
            turn=(0.05, 1e-3),
            turn_rate_psd=1e-2,
            turn_rate=0.5,
        ),
        seconds=(15.0, 3.0, 4.0),
        to=EVEN,
        speed=10.0,
        extent=(5e3, 500.0),
        coast=300.0,
        acceleration=1.0,
        position_sd=5.0,
        coasting=Coasting(after=10.0, manoeuvre=4.0, climb=10.0),
        manoeuvre_g=(0.05, 0.05),
        manoeuvre_seconds=3.0,
    ),
}


def kind_of(name: str) -> Kind:
    """The kind of this name. Errors: InputError with the nearest and all."""
    if not isinstance(name, str) or name not in KINDS:
        raise InputError(unknown("kind", str(name), KINDS))
    return KINDS[name]
