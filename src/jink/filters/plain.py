"""What a filter file holds: declarations as JSON, parameters in SI units, readable and diffable."""

import json
import os
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..io.temporary import atomically
from .own_models import described

VERSION = 1
# what filters have in common, in the order in which files hold it
COMMON = ("outliers", "initial", "coast")
LINEARISED = ("linearisation", *COMMON)
MODES = ("transition", "transition_step", "mode_probability", "mixing", *LINEARISED)


def write(body: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Write a JSON file, whole or not at all."""
    if not isinstance(path, str | os.PathLike) or os.fspath(path) in ("", b"") or "\0" in str(path):
        raise TypeError(f"path: expected the name of a file, got {path!r}")
    text = json.dumps(body, indent=2) + "\n"
    with atomically(Path(path)) as (temporary,):
        temporary.write_text(text, encoding="utf-8")


def plain(value: Any) -> Any:
    """A declaration as JSON can hold it. A model of your own is the module and name of its class.

    Errors: TypeError for other code, which JSON cannot hold."""
    if is_dataclass(value) and not isinstance(value, type) and type(value).__module__.startswith("jink."):
        given = {f.name: plain(getattr(value, f.name)) for f in fields(value)}
        return {"kind": type(value).__name__, **{k: v for k, v in given.items() if v is not None}}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    if value is None or isinstance(value, str | int | float | bool):
        return value
    if any(callable(getattr(value, verb, None)) for verb in ("f", "h", "step")):
        return described(value, plain)
    raise TypeError(f"{type(value).__name__}: a model of your own is code and cannot be saved to a file")
