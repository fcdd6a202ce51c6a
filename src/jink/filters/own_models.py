"""Models of your own in a filter file: the module and name of their class, and their numbers."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

KIND, CODE, VALUES = "own", "code", "values"
ARRAY, NAMED = "array", "dict"


def described(value: Any, plain: Callable[[Any], Any]) -> dict[str, Any]:
    """Class and numbers of a model of your own. Errors: TypeError where a file cannot hold them."""
    kind = type(value)
    module = _module_name(kind.__module__)
    if not module or "." in kind.__qualname__ or _found(sys.modules.get(kind.__module__), kind.__name__) is not kind:
        raise TypeError(
            f"{kind.__name__}: a model of your own is code and cannot be saved to a file, unless its class stands at "
            "the top level of a module"
        )
    given = {f.name: getattr(value, f.name) for f in fields(value)} if is_dataclass(value) else dict(vars(value))
    out: dict[str, Any] = {"kind": KIND, CODE: f"{module}:{kind.__name__}"}
    for name, each in given.items():
        if name in out:
            raise TypeError(f"{kind.__name__}: a field cannot be called {name} in a file; expected another name")
        try:
            out[name] = _held(each, plain)
        except TypeError as error:
            raise TypeError(
                f"{kind.__name__}.{name}: is code and cannot be saved to a file; expected numbers, text, arrays "
                f"or models ({error})"
            ) from None
    return out


def rebuilt(value: dict[str, Any], at: str, own: bool) -> Any:
    """The model of such a description. Errors: ValueError, above all where the caller did not agree to import code."""
    code = value.get(CODE)
    if not isinstance(code, str) or code.count(":") != 1:
        raise ValueError(f"{at}: {CODE} is {code!r}; expected module:name")
    if not own:
        raise ValueError(f"{at}: is a model of your own, {code}; jink.load(path, own=True) imports that module")
    module, name = code.split(":")
    kind = _found(_module(module, at), name)
    if not isinstance(kind, type):
        raise ValueError(f"{at}: module {module} has no class {name}")
    given = {k: v for k, v in value.items() if k not in ("kind", CODE)}
    try:
        if is_dataclass(kind):
            return kind(**{f.name: given.pop(f.name) for f in fields(kind) if f.init and f.name in given}, **given)
        made: Any = object.__new__(kind)
        vars(made).update(given)
        return made
    except TypeError as error:
        raise ValueError(f"{at}: {code}: {error}") from None


def _held(value: Any, plain: Callable[[Any], Any]) -> Any:
    """An array or a dict says so, so that it comes back as one."""
    if isinstance(value, np.ndarray):
        return {"kind": ARRAY, VALUES: value.tolist()}
    if isinstance(value, dict):
        return {"kind": NAMED, VALUES: [[str(name), _held(each, plain)] for name, each in value.items()]}
    return plain(value)


def read_back(value: dict[str, Any], declared: Callable[[Any], Any]) -> Any:
    """An array or a dict from a file."""
    values = declared(value[VALUES])
    return np.array(values) if value["kind"] == ARRAY else {name: each for name, each in values}


def _module_name(name: str) -> str:
    """Of a script that runs, the name of its file; "" in a session without one."""
    if name != "__main__":
        return name
    file = getattr(sys.modules["__main__"], "__file__", None)
    return Path(file).stem if file else ""


def _module(name: str, at: str) -> ModuleType:
    if name == _module_name("__main__"):
        return sys.modules["__main__"]
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ValueError(f"{at}: module {name} cannot be imported ({error})") from None


def _found(module: ModuleType | None, name: str) -> Any:
    return getattr(module, name, None)
