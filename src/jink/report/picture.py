"""A map of how many rows lie where, as a PNG whose colour is the page's: darker where there are more."""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from ..checks import Array

_FAINTEST = 90  # of 255: a cell with one row can be seen


def shaded(counts: Array) -> NDArray[np.uint8]:
    """Opacity (R, C) of 0 to 255: none without rows, then the rank of a cell's count among all counts.

    Ranks, not counts: a few busy cells would leave all others pale.
    """
    filled = counts > 0
    levels, rank = np.unique(counts[filled], return_inverse=True)
    opacity = np.zeros(counts.shape, dtype=np.uint8)
    share = (rank + 1) / max(len(levels), 1)
    opacity[filled] = np.round(_FAINTEST + (255 - _FAINTEST) * share)
    return opacity


def mask(opacity: NDArray[np.uint8]) -> str:
    """A data URL of a PNG, white with this opacity (R, C), the first row at the top."""
    rows, columns = opacity.shape
    pixels = np.full((rows, columns, 2), 255, dtype=np.uint8)
    pixels[:, :, 1] = opacity
    lines = np.zeros((rows, 1 + 2 * columns), dtype=np.uint8)
    lines[:, 1:] = pixels.reshape(rows, -1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, 4, 0, 0, 0)
    body = _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(lines.tobytes(), 9)) + _chunk(b"IEND", b"")
    return "data:image/png;base64," + base64.b64encode(b"\x89PNG\r\n\x1a\n" + body).decode()


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
