"""Filters by name (:mod:`jink.catalogue.registry`) and kinds of target (:mod:`jink.catalogue.targets`).

The names of the registry are read when they are first asked for: kinds alone need no filter but the IMM.
"""

from typing import Any

_REGISTRY = ("FILTERS", "SHORT", "Named", "Purpose", "Unfit", "canonical")


def __getattr__(name: str) -> Any:
    if name not in _REGISTRY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import registry

    return getattr(registry, name)
