"""Packages that an adapter needs and that may not be there."""

from __future__ import annotations

import importlib
from typing import Any


def needed(module: str, extra: str = "interop") -> Any:
    """A module of another package. Errors: ImportError that says which extra brings it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise ImportError(f"{package} cannot be imported ({error}); pip install 'jink[{extra}]'") from error
