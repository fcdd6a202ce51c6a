"""The fitted filters that come with the package; :mod:`jink.papers.training.shipped` trains them."""

from __future__ import annotations

from importlib import resources
from typing import Any

from ..checks import unknown
from ..filters.loading import read


def shipped(name: str, seed: int | None = None) -> Any:
    """The filter of this name; those of choi-2001 for seeds 0 to 4.

    Errors: ValueError for a name (or a seed) that does not come with the package.
    """
    file = file_name(name, seed)
    folder = resources.files("jink.catalogue") / "models"
    there = sorted(f.name.removesuffix(".json") for f in folder.iterdir() if f.name.endswith(".json"))
    if file.removesuffix(".json") not in there:
        raise ValueError(unknown("model", file.removesuffix(".json"), there))
    return read((folder / file).read_text(encoding="utf-8"), file)


def file_name(name: str, seed: int | None) -> str:
    """Of a model's file; the seed is in it where several are shipped."""
    return f"{name}.json" if seed is None else f"{name}-seed-{seed}.json"
