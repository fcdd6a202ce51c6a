"""Tiles of a map server under the tracks, where one is named; without one a page asks no server for anything."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

from ..frozen import frozen
from ..io.errors import InputError

_HOST = re.compile(r"(?:[A-Za-z0-9.-]+|\[[0-9A-Fa-f:]+\])(?::\d+)?")
_PARTS = ("{z}", "{x}", "{y}")
EXAMPLE = "https://tile.example.org/{z}/{x}/{y}.png"


@frozen
class Tiles:
    """url: of a picture, with {z}, {x} and {y} for zoom, column and row (Web Mercator, as of OpenStreetMap)."""

    url: str

    def __post_init__(self) -> None:
        """Errors: InputError."""
        parts = urlsplit(self.url)
        named = all(self.url.count(part) == 1 for part in _PARTS)
        plain = not re.search(r"[\s\"'<>;,\\]", self.url) and not set(re.findall(r"{\w*}", self.url)) - set(_PARTS)
        if parts.scheme not in ("http", "https") or not _HOST.fullmatch(parts.netloc) or not named or not plain:
            raise InputError(f"tiles is {self.url!r}; expected an address such as {EXAMPLE}")

    @property
    def origin(self) -> str:
        """The one server that the page may ask for pictures."""
        parts = urlsplit(self.url)
        return f"{parts.scheme}://{parts.netloc}"
