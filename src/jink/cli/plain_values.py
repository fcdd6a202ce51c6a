"""Values of a command line that are taken as they stand: text, and defaults.

typer shows every value to pydantic, which takes .1 s to import and to set up. So only given numbers and choices go
that way.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import unwrap
from typing import Any, get_args, get_origin


class PlainValues:
    """Mixed into a command or a group of typer."""

    callback: Any

    def parse_args(self, context: Any, arguments: list[str]) -> list[str]:
        """Read the arguments."""
        kinds = getattr(unwrap(self.callback), "__annotations__", {})
        for parameter in self.get_params(context):  # type: ignore[attr-defined]
            text = _is_text(kinds.get(parameter.name))
            parameter.process_value = partial(_processed, parameter, parameter.process_value, text)
        return super().parse_args(context, arguments)  # type: ignore[misc]


def _processed(parameter: Any, careful: Callable[[Any, Any], Any], text: bool, context: Any, value: Any) -> Any:
    """A value as the command gets it; careful: typer's own way."""
    several = parameter.multiple or parameter.nargs == -1
    if (value is None or value is parameter.default) and not parameter.required:
        value = () if value is None and several else value
        return parameter.callback(context, parameter, value) if parameter.callback else value
    if text and parameter.callback is None:
        if several and isinstance(value, list | tuple) and value:
            return list(value)
        if not several and isinstance(value, str):
            return value
    return careful(context, value)


def _is_text(kind: Any) -> bool:
    """Whether a parameter's annotation says text, one or several, which may be missing."""
    if hasattr(kind, "__metadata__"):
        kind = get_args(kind)[0]
    kinds = [kind] if get_origin(kind) is list else get_args(kind) or (kind,)
    return all(one in (str, list[str], type(None)) for one in kinds) and kind is not type(None)
