"""The frame that every page shares: template, style, scripts and data in one file that needs nothing else.

Charts and maps are drawn by hand on canvas: docs/page.md has the measurement behind that.
"""

import html
import json
import math
import os
from collections.abc import Mapping, Sequence
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from ..io.temporary import atomically
from .arrays import ArrayBlock

_SHARED_SCRIPTS = ("data.js", "format.js", "canvas.js", "table.js")
PLAN_AND_CHARTS = (
    "geometry.js",
    "world.js",
    "tiles.js",
    "measure.js",
    "plan_draw.js",
    "plan.js",
    "plan_input.js",
    "chart_draw.js",
    "panels.js",
    "charts.js",
    "charts_input.js",
)  # of pages that show tracks


def asset(name: str) -> str:
    """Text of a file in assets/."""
    return (resources.files("jink.report") / "assets" / name).read_text(encoding="utf-8")


def fill(name: str, **texts: str) -> str:
    """An HTML asset with its $slots filled; the texts must be HTML already."""
    return Template(asset(name)).substitute(texts)


def escape(value: object) -> str:
    """Text that is safe in HTML, in elements and in attributes."""
    return html.escape(str(value), quote=True)


def json_text(data: Any) -> str:
    """JSON that is safe inside a script element; NaN and infinities become null, NumPy arrays lists."""
    text = json.dumps(_plain(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _plain(data: Any) -> Any:
    if isinstance(data, np.ndarray):
        return _plain(data.tolist())
    if isinstance(data, np.generic):
        return _plain(data.item())
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def version() -> str:
    """Version of the installed package."""
    try:
        return metadata.version("jink")
    except metadata.PackageNotFoundError:
        return "(not installed)"


def page(
    *, title: str, body: str, scripts: Sequence[str], meta: Mapping[str, Any], block: ArrayBlock, images: str = ""
) -> str:
    """The HTML text: body (HTML), scripts (assets, after the shared ones), meta (JSON-able) and arrays.

    images: a server that the page may ask for pictures.
    """
    drawing = fill(
        "drawing.html",
        meta=json_text({**meta, "arrays": block.manifest}),
        block=block.base64(),
        scripts="\n".join(asset(name) for name in (*_SHARED_SCRIPTS, *scripts)),
    )
    allowed = "script-src 'unsafe-inline'; "
    return _shell(title, body, asset("style.css"), allowed=allowed, drawing=drawing, images=images and f" {images}")


def plain_page(*, title: str, body: str, style: str) -> str:
    """The same without scripts: body (HTML), style (an asset, after the shared one)."""
    return _shell(title, body, asset("style.css") + asset(style), allowed="", drawing="")


def _shell(title: str, body: str, style: str, **rest: str) -> str:
    return fill(
        "shell.html", title=escape(title), version=escape(version()), style=style, body=body, **{"images": "", **rest}
    )


def write_page(path: str | os.PathLike[str], text: str) -> None:
    """Write `text` to `path` at once or not at all."""
    with atomically(Path(path)) as (temporary,):
        temporary.write_text(text, encoding="utf-8", errors="replace", newline="\n")
