"""MOTChallenge: boxes in images, one per line: frame, identity, left, top, width, height, confidence, …"""

from __future__ import annotations

import re
from typing import Any

from ..errors import InputError
from .records import Format, Records, Refused

LINE = re.compile(rb"^\d+,-?\d+(?:,-?\d+(?:\.\d+)?(?:e[-+]?\d+)?){5,8},?\s*$")


def recognises(head: bytes) -> bool:
    """Lines of seven to ten numbers that begin with a frame and an identity."""
    lines = [line for line in head[:8000].splitlines()[:20] if line.strip()]
    return len(lines) > 1 and all(LINE.match(line) for line in lines[:-1])


def read(file: str, content: bytes) -> Records:
    """One row per box: the middle of its lower edge, in pixels. Errors: InputError for boxes without identity."""
    rows: list[dict[str, Any]] = []
    refused = Refused()
    nameless = 0
    for number, line in enumerate(content.decode("utf-8", errors="replace").splitlines()):
        fields = line.strip().rstrip(",").split(",")
        try:
            frame, identity, left, top, width, height = (float(field) for field in fields[:6])
        except ValueError:
            if line.strip():
                refused.add(number, "not a box of MOTChallenge", line)
            continue
        nameless += identity < 0
        row = {"row": number, "target": str(int(identity)), "time": frame}
        rows.append(row | {"x": left + width / 2.0, "y": -(top + height)})
    if not rows or nameless > len(rows) / 2:
        raise InputError(
            f"{file} holds detections of MOTChallenge (frame, -1, left, top, width, height, …) without identity; "
            "jink track needs a target for each row. Tracks and ground truth (gt.txt) of that format are read"
        )
    note = (
        "boxes of MOTChallenge: x and y are pixels, y upwards, and times are frames, not seconds; speeds are per frame"
    )
    return Records.of(rows, refused, [note], {"time_s": "time", "x_m": "x", "y_m": "y"})


FORMAT = Format(
    "MOTChallenge gt.txt",
    recognises,
    read,
    "a box",
    "identity, the middle of the lower edge (pixels, y upwards)",
    "the frame's number",
)
