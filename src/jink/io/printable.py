"""Text for a terminal: what would move its cursor, change its colours or turn the reading direction is spelled out."""

from __future__ import annotations

import re

# C0 without tab and line feed, DEL, C1, the marks that turn the direction of reading, and Unicode's own line ends
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def printable(text: str, *, one_line: bool = False) -> str:
    r"""The text with each control character as `\x1b` or `\u202e`. one_line: a line feed is written as `\n` too.

    Every message, table and note goes through it, since names of targets, columns and files come from outside.
    """
    if one_line:
        text = text.replace("\n", "\\n")
    return _CONTROL.sub(lambda found: _spelled(ord(found[0])), text)


def printable_json(text: str) -> str:
    r"""JSON text, whose strings may still hold DEL and C1 (`json` escapes C0): as `\u009b`, which JSON reads."""
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def _spelled(code: int) -> str:
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"
