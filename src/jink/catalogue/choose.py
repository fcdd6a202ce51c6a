"""Which filter a target gets: the user's, a named one, or the default of its kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..checks import unknown, with_attributes
from ..filters.axis_by_axis import of_one_axis, on_axes
from ..filters.imm import IMM
from ..io.errors import InputError
from ..models.outliers import Outliers
from ..models.sensor import Polar, Position, PositionVelocity, Sensor
from .interacting import imm
from .purpose import Named, Purpose, Unfit
from .targets import kind_of

if TYPE_CHECKING:
    from ..filters.loading import AnyFilter

VELOCITIES = ("vx", "vy", "vz")
# what a radar measures beside range and azimuth, and the sensor's argument for its noise
RADAR = {"altitude": "height_sd", "elevation": "elevation_sd", "range_rate": "range_rate_sd"}
DEFAULTS = ("imm", "imm-corrected")  # what targets get where no filter is named, by kind
PROVEN = ("aircraft", "fighter")  # kinds whose learned correction is on by default: see docs/corrector.md
EARTH_RADIUS = 6_371_008.8  # m, the mean; where the site is known its own is taken


def default_filter(
    kind: str, sensor: Sensor, axes: int | None = None, *, interval: float = 0.0, coast: float | None = None
) -> IMM:
    """The IMM for a kind of target (`jink.KINDS`) on a sensor of two or three axes, gated, starting from two points.

    interval (s): usual time between positions, if long: a track then waits ten of them, and outliers may lie as much
    farther off as a target gets meanwhile. coast (s): how long a track waits instead; 0: for ever.
    Errors: ValueError for an unknown kind, with the nearest and all, and for a sensor of one axis.
    """
    return kind_of(kind).filter(sensor, axes, interval=interval, coast=coast)


def choose_filter(
    components: Sequence[str],
    sd: Mapping[str, float],
    kind: str,
    filter: str | AnyFilter | None,
    gap: float = 0.0,
    interval: float = 1.0,
) -> AnyFilter:
    """A filter for measured `components` (x, y, altitude, ...) of typical `sd`s.

    `filter` is a filter, a name of `FILTERS`, or None for the kind's default; gap (s): the longest within a part of a
    track; interval (s): the usual time between two of its positions, which some filters have probabilities for. Errors:
    InputError.
    """
    return chosen(filter, purpose_of(components, sd, kind, gap, interval), components)


def purpose_of(
    components: Sequence[str],
    sd: Mapping[str, float],
    kind: str,
    gap: float,
    interval: float,
    earth_radius: float = EARTH_RADIUS,
) -> Purpose:
    """What a filter of these measurements is made for; the arguments are those of :func:`choose_filter`.

    earth_radius (m): of the sphere that a radar's altitudes are above.
    """
    if isinstance(components, str) or not isinstance(components, Sequence) or not components:
        raise InputError(f"components: expected the names of what is measured, got {components!r}")
    named = "range" if components[0] == "range" else "position"
    if not isinstance(sd, Mapping) or not isinstance(sd.get(named), int | float):
        raise InputError(f"sd: expected one of {named!r}, got {sd!r}")
    kind_of(kind)
    for name, value in (("gap", gap), ("interval", interval)):
        if not isinstance(value, int | float) or not value >= 0 or (isinstance(value, int) and value > 1e300):
            raise InputError(f"{name}: expected seconds, got {value!r}")
    level = sd[named]
    sensor = sensor_of(components, sd, earth_radius)
    return Purpose(sensor=sensor, kind=kind, sd=level, outliers=Outliers(), gap=gap, interval=interval)


def chosen(filter: Any, purpose: Purpose, components: Sequence[str], corrected: bool = True) -> Any:
    """The user's filter if it takes these components, or one made for the purpose. Errors: InputError.

    One of one axis runs along each axis of positions by itself. corrected: whether a learned correction of the kind is
    of use, as it is for filtered estimates of targets with names.
    """
    if filter is not None and not isinstance(filter, str):
        with_attributes("filter", filter, ("filter", "sensors"), "a filter or a name of jink.FILTERS")
        filter = on_axes(filter, purpose.sensor)
        _check(filter, components)
        return filter
    try:
        return (default_of(purpose, corrected) if filter is None else named_filter(filter))(purpose).filter
    except Unfit as reason:
        raise InputError(f"filter {filter or 'imm'} cannot track these data: {reason}") from None
    except ValueError as error:
        raise InputError(f"{error}, or a filter, such as jink.load(file) gives") from None


def default_of(purpose: Purpose, corrected: bool = True) -> Callable[[Purpose], Named]:
    """The kind's IMM; corrected: with its learned correction, where that has proven itself."""
    if not corrected or purpose.kind not in PROVEN:
        return imm
    from .corrected import imm_corrected  # its network is read for those who use it

    return imm_corrected


def named_filter(name: str) -> Callable[[Purpose], Named]:
    """What makes the filter of this name. Errors: ValueError naming the nearest and all."""
    from .registry import FILTERS, canonical  # every filter, while most runs need the default alone

    return FILTERS[canonical(name)]


def _check(chosen: Any, components: Sequence[str]) -> None:
    """InputError if the user's filter measures something else than what the data holds."""
    polar = components[0] == "range"
    data = tuple({"altitude": "height" if polar else "z"}.get(name, name) for name in components)
    expected = tuple(getattr(next(iter(getattr(chosen, "sensors", ())), None), "components", data))
    if expected != data:
        raise InputError(f"the filter's sensor measures {', '.join(expected)}; the data has {', '.join(components)}")


def load_filter(given: str | None) -> Any:
    """`--filter NAME|FILE`: a name stays one, a file is read."""
    if given is None:
        return None
    from ..filters.loading import load
    from .registry import FILTERS, SHORT

    if given in FILTERS or given in SHORT:
        return given
    path = Path(given)
    if not path.is_file():
        if path.suffix or len(path.parts) > 1:
            raise InputError(f"there is no filter file {given}")
        raise InputError(unknown("filter", given, FILTERS) + ", or a file written by save()")
    try:
        return load(path)
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"filter file {given} cannot be used: {error}") from None


def axes_of(chosen: Any) -> int | None:
    """Number of axes of a filter; None where none was given, or for one of one axis, which takes any number."""
    return None if of_one_axis(chosen) else getattr(chosen, "axes", None)


def sensor_of(
    components: Sequence[str], sd: Mapping[str, float], earth_radius: float = EARTH_RADIUS
) -> Position | PositionVelocity | Polar:
    """The sensor of measured `components` with these `sd`s: x, y, altitude, ..., perhaps vx, vy, vz; or range, azimuth,
    ..., perhaps range_rate.
    """
    if components[0] == "range":
        extra: dict[str, Any] = {RADAR[name]: sd.get(name) for name in components[2:]}
        if "altitude" in components:
            extra["earth_radius"] = earth_radius
        return Polar(range_sd=sd["range"], azimuth_sd=sd["azimuth"], **extra)
    velocities = [name for name in components if name in VELOCITIES]
    axes = len(components) - len(velocities)
    position = [sd["position"]] * 2 + ([sd["altitude"]] if axes > 2 else [])
    if velocities:
        velocity = [sd.get("velocity", 1.0)] * 2 + [sd.get("vertical_rate", 1.0)] * (axes - 2)
        return PositionVelocity(sd=position, velocity_sd=velocity, axes=axes)
    return Position(sd=position, axes=axes)
