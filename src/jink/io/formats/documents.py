"""The JSON values of a file: one document, or one per line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from ..errors import InputError


def documents(file: str, content: bytes) -> Iterator[tuple[int, Any, str]]:
    """Line number (0 for a single document), value (None: not JSON) and text of each."""
    text = content.decode("utf-8", errors="replace").strip()
    whole = _value(text)
    if whole is not None:
        yield 0, whole, text
        return
    found = False
    for number, line in enumerate(text.splitlines()):
        if line.strip():
            value = _value(line)
            found = found or value is not None
            yield number, value, line
    if not found:
        raise InputError(f"{file} is JSON that cannot be read (truncated or damaged?)")


def _value(text: str) -> Any:
    try:
        return json.loads(text, parse_constant=lambda _: None)
    except (ValueError, RecursionError):
        return None
