"""Filters of your own in a race: by the name you give them, or from your Python file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from ..catalogue.purpose import Named, Purpose, Unfit
from ..catalogue.registry import SHORT
from ..filters.kalman import Kalman
from ..filters.loading import AnyFilter
from ..filters.own import OwnFilter, Steps
from ..io.errors import InputError
from ..io.own_code import is_code, loaded
from ..models.motion import OwnMotion
from .entrants import ENTRANTS, SUFFIX
from .filter_files import suits

Maker = Callable[[Purpose], Named]
Own = AnyFilter | OwnMotion | Steps | Callable[[Purpose], AnyFilter | Named]
Entry = Own | None
EXPECTED = (
    "a filter, a function of the purpose that returns one, a motion model with f(x, dt) and Q(dt), "
    "an object with begin(z, R) and step(state, dt, z, R), or None for jink's filter of that name"
)


def own_filters(filters: Any) -> tuple[list[str], dict[str, Maker]]:
    """Names of jink's filters or files among those asked for, and makers of the others by name.

    filters: a name, names, or a mapping of name to filter; "file.py:name" stands for what the file has under that name,
    which may be such a mapping itself. Errors: InputError.
    """
    if isinstance(filters, Mapping):
        return _named(filters)
    names: list[str] = []
    makers: dict[str, Maker] = {}
    for name in [filters] if isinstance(filters, str) else list(filters):
        if not isinstance(name, str):
            raise InputError(f'filters: expected names, or a mapping such as {{"mine": filter}}; got {name!r}')
        if not is_code(name):
            names.append(name)
            continue
        found = loaded(name)
        if isinstance(found, Mapping):
            others, more = _named(found)
            names, makers = names + others, makers | more
        else:
            makers[name] = _maker(name, found)
    return names, makers


def _named(filters: Mapping[str, Any]) -> tuple[list[str], dict[str, Maker]]:
    names: list[str] = []
    makers: dict[str, Maker] = {}
    for name, given in filters.items():
        if not isinstance(name, str) or not name:
            raise InputError(f"filters: {name!r} is not a name; expected text")
        if given is None:
            names.append(name)
        elif name in ENTRANTS or name in SHORT or name == "all" or name.endswith(SUFFIX):
            raise InputError(f"filters: {name} is the name of a filter of jink; expected another name for your own")
        elif isinstance(given, str):
            raise InputError(f"filters: {name} is given as {given!r}; expected {EXPECTED}")
        else:
            makers[name] = _maker(name, given)
    return names, makers


def _maker(name: str, given: Any) -> Maker:
    return partial(made, name, given)


def made(name: str, given: Any, purpose: Purpose) -> Named:
    """A filter of your own for a purpose. Errors: InputError for what is none, or does not suit the sensor."""
    found: Any
    if inspect.isclass(given) and _is_filter(given) and not _needs_purpose(given):
        found = _called(name, lambda _: given(), purpose)
    elif callable(given) and (inspect.isclass(given) or not _is_filter(given)):
        found = _called(name, given, purpose)
    else:
        found = given
    if isinstance(found, Named):
        return found
    try:
        if callable(getattr(found, "begin", None)) and callable(getattr(found, "step", None)):
            found = OwnFilter(found, purpose.sensor)
        elif callable(getattr(found, "f", None)) and callable(getattr(found, "Q", None)):
            found = Kalman(found, purpose.sensor)
    except (ValueError, TypeError) as error:
        raise InputError(f"filters: {name}: {error}") from error
    if not callable(getattr(found, "filter", None)) or not hasattr(found, "components"):
        raise InputError(f"filters: {name} is {found!r}; expected {EXPECTED}")
    note = suits(found, purpose, name)
    return Named(filter=found, words=f"own filter: {_in_words(found)}", note=note)


def _is_filter(given: Any) -> bool:
    return any(callable(getattr(given, verb, None)) for verb in ("filter", "step", "f"))


def _needs_purpose(kind: Callable[..., Any]) -> bool:
    """Does a class need an argument, which is then the purpose?"""
    arguments = inspect.signature(kind).parameters.values()
    return any(a.default is a.empty and a.kind in (a.POSITIONAL_ONLY, a.POSITIONAL_OR_KEYWORD) for a in arguments)


def _called(name: str, function: Callable[[Purpose], Any], purpose: Purpose) -> Any:
    try:
        return function(purpose)
    except Unfit:
        raise
    except Exception as error:
        raise InputError(f"filters: {name} failed for {purpose.name}: {type(error).__name__}: {error}") from error


def _in_words(filter: Any) -> str:
    if isinstance(filter, OwnFilter):
        return type(filter.steps).__name__
    return f"{type(filter).__name__} of {', '.join(filter.modes)}"
