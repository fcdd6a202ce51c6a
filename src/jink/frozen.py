"""Frozen dataclasses that are quick to make.

``dataclass(frozen=True)`` compiles six functions for every class, and a run of ``jink track`` makes a hundred classes.
Here three of them, which are not called often, are the same for all classes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from reprlib import recursive_repr
from typing import Any, TypeVar, dataclass_transform, overload

C = TypeVar("C")


@overload
def frozen(cls: type[C], /) -> type[C]: ...
@overload
def frozen(*, kw_only: bool = False, eq: bool = True, repr: bool = True) -> Callable[[type[C]], type[C]]: ...
@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: Any = None, /, *, kw_only: bool = False, eq: bool = True, repr: bool = True) -> Any:
    """A class made what ``dataclass(frozen=True)`` makes it: with ``eq`` compared and hashed by its fields."""

    def made(cls: type[Any]) -> type[Any]:
        own = dict(vars(cls))
        for name, function in (("__repr__", _repr if repr else None), ("__eq__", _eq if eq else None)):
            if function is not None and name not in own:
                setattr(cls, name, function)
        if eq and own.get("__hash__") is None:
            cls.__hash__ = _hash  # type: ignore[assignment]
        return dataclass(frozen=True, eq=False, repr=False, kw_only=kw_only)(cls)

    return made if cls is None else made(cls)


@recursive_repr()
def _repr(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _compared(self: Any) -> tuple[Any, ...]:
    return tuple(getattr(self, f.name) for f in fields(self) if f.compare)


def _eq(self: Any, other: object) -> bool:
    return _compared(self) == _compared(other) if type(self) is type(other) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_compared(self))
