"""Fitted models as small JSON files; those shipped with the package are read by name."""

from __future__ import annotations

import json
import os
from importlib import resources
from pathlib import Path
from typing import Any

from .filters.files import plain, write
from .filters.loading import declared

VERSION = 1


def save_model(model: Any, path: str | os.PathLike[str]) -> None:
    """Write one model, or a sequence of them (the modes of a fuzzy IMM), with what each was trained on."""
    write({"jink": "model", "version": VERSION, "units": "SI", "model": plain(model)}, path)


def load_model(path: str | os.PathLike[str]) -> Any:
    """Read what :func:`save_model` wrote; a sequence comes back as a tuple.

    Errors: ValueError naming the file and what is wrong with it, other units than SI among it.
    """
    return _read(Path(path).read_text(encoding="utf-8"), str(path))


def shipped(name: str) -> Any:
    """The model of this name that comes with the package. Errors: ValueError naming those there are."""
    folder = resources.files("jink") / "papers" / "models"
    names = sorted(f.name.removesuffix(".json") for f in folder.iterdir() if f.name.endswith(".json"))
    if name not in names:
        raise ValueError(f"no model {name!r} comes with jink; there are {', '.join(names)}")
    return _read((folder / f"{name}.json").read_text(encoding="utf-8"), name)


def _read(text: str, where: str) -> Any:
    try:
        body = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{where}: is no JSON model file ({error})") from None
    if not isinstance(body, dict) or body.get("jink") != "model":
        raise ValueError(f'{where}: is no jink model file; expected an object with "jink": "model"')
    if body.get("version") != VERSION:
        raise ValueError(f"{where}: is of version {body.get('version')!r}; this jink reads version {VERSION}")
    if body.get("units") != "SI":
        raise ValueError(f"{where}: units {body.get('units')!r}; expected SI")
    try:
        model = declared(body["model"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{where}: {error}") from None
    return tuple(model) if isinstance(model, list) else model
