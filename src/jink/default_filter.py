"""Which filter a table gets: the user's, a named one, or the default of its kind of target."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .io.errors import InputError
from .kinds import RARE, default_filter

# m/s²: what a target of this kind pulls when it manoeuvres, for the filters with a single motion model
ACCELERATION = {"aircraft": 3.0, "fighter": 40.0, "vessel": 0.2, "vehicle": 3.0, "drone": 5.0, "person": 1.0}
NAMES = ("imm", "cv", "ca", "singer")


def choose_filter(
    components: Sequence[str], sd: Mapping[str, float], kind: str, chosen: Any, gap: float = 0.0
) -> Any:
    """A filter for measured `components` (x, y, altitude, ...) of typical `sd`s.

    `chosen` is a filter, a name, or None for the kind's default; gap (s): the longest within a part of a track.
    """
    axes = len(components)
    if chosen is not None and not isinstance(chosen, str):
        _check(chosen, components)
        return chosen
    sensor = _sensor(components, sd)
    if chosen in (None, "imm"):
        return default_filter(kind, sensor, axes, interval=gap / RARE, coast=0.0)  # parts end at gaps already
    if chosen in NAMES:
        return _single(chosen, sensor, ACCELERATION[kind])
    raise InputError(
        f"filter {chosen!r} is not known; expected {', '.join(NAMES)}, or a file written by save()"
    )


def _check(chosen: Any, components: Sequence[str]) -> None:
    """InputError if the user's filter measures something else than what the data holds."""
    polar = components[0] == "range"
    data = tuple({"altitude": "height" if polar else "z"}.get(name, name) for name in components)
    expected = tuple(getattr(next(iter(getattr(chosen, "sensors", ())), None), "components", data))
    if expected != data:
        raise InputError(
            f"the filter's sensor measures {', '.join(expected)}; the data has {', '.join(components)}"
        )


def _single(name: str, sensor: Any, acceleration: float) -> Any:
    """A Kalman filter with one motion model, loose enough for the kind's manoeuvres."""
    import jink

    motions = {
        "cv": jink.ConstantVelocity(acceleration_sd=acceleration),
        "ca": jink.ConstantAcceleration(jerk_psd=acceleration**2 / 10.0, acceleration_prior_sd=acceleration),
        "singer": jink.Singer(acceleration_sd=acceleration, time_constant=20.0),
    }
    return jink.Kalman(motions[name], sensor, outliers=jink.Outliers())


def load_filter(given: str | None) -> Any:
    """`--filter NAME|FILE`: a name stays one, a file is read."""
    if given is None or given in NAMES:
        return given
    path = Path(given)
    if not path.is_file():
        raise InputError(f"filter {given!r} is neither a file nor one of {', '.join(NAMES)}")
    import jink

    try:
        return jink.load(str(path))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"filter file {given} cannot be used: {error}") from None


def axes_of(chosen: Any) -> int | None:
    """Number of axes of a filter, None where none was given."""
    return getattr(chosen, "axes", None)


def _sensor(components: Sequence[str], sd: Mapping[str, float]) -> Any:
    import jink

    third = components[2] if len(components) > 2 else None
    if components[0] == "range":
        extra: dict[str, Any] = {
            "altitude": {"height_sd": sd.get("altitude")},
            "elevation": {"elevation_sd": sd.get("elevation")},
        }
        return jink.Polar(range_sd=sd["range"], azimuth_sd=sd["azimuth"], **extra.get(third or "", {}))
    return jink.Position(sd=[sd["position"]] * 2 + ([sd["altitude"]] if third else []), axes=len(components))
