"""Python code of your own by name: "file.py:name" or "package.module:name"."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any

from .errors import InputError


def is_code(text: str) -> bool:
    """Does this name something in a Python file or module?"""
    where, colon, name = text.rpartition(":")
    return bool(colon) and name.isidentifier() and (where.endswith(".py") or _dotted(where))


def loaded(text: str) -> Any:
    """What the file or module has under the name. Errors: InputError naming the file, or what it has instead."""
    where, _, name = text.rpartition(":")
    module = _file(Path(where)) if where.endswith(".py") else _module(where)
    if not hasattr(module, name):
        there = [each for each in vars(module) if not each.startswith("_")]
        raise InputError(f"{where}: has no {name}; it has {', '.join(there) or 'nothing'}")
    return getattr(module, name)


def _dotted(where: str) -> bool:
    return bool(where) and all(part.isidentifier() for part in where.split("."))


def _file(path: Path) -> Any:
    """The module of a file, under the file's own name so that what it defines can be saved and pickled."""
    if not path.is_file():
        raise InputError(f"there is no file {path}")
    name, there = path.stem, path.resolve()
    known = sys.modules.get(name)
    if known is not None and getattr(known, "__file__", None) and Path(str(known.__file__)).resolve() == there:
        return known
    if known is not None or not name.isidentifier():
        raise InputError(f"{path}: {name} is the name of a module that is loaded already; expected another file name")
    spec = importlib.util.spec_from_file_location(name, there)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise InputError(f"{path}: {type(error).__name__}: {error}") from error
    return module


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError(f"{name}: {error}; expected a module that can be imported, or a file such as my.py") from error
