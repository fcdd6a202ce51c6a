"""An estimate as a DataFrame, and as a few lines of HTML."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

BACKENDS = ("polars", "pandas", "pyarrow")
SHOWN = 5  # rows of a table in a notebook
POINTS = 2000  # of a picture there


def columns_of(estimate: Any, statuses: Sequence[str]) -> dict[str, NDArray[Any]]:
    """What a table of an estimate holds, by name; statuses: the names of its numbers."""
    results, lengths = estimate.results, np.diff(estimate.offsets)
    out: dict[str, NDArray[Any]] = {"target": np.repeat(np.arange(len(lengths)), lengths), "time": estimate.time}
    for name in estimate.components:
        if "x" in results:
            out[name] = estimate[name]
        with suppress(AttributeError):  # neither P nor this variance is among the outputs
            out[f"{name}_sd"] = estimate.sd(name)
    if "mode_probability" in results:
        out |= {f"probability_{name}": results["mode_probability"][:, k] for k, name in enumerate(estimate.modes)}
        if any(estimate.non_manoeuvring):
            out["manoeuvring"] = estimate.manoeuvring
    out |= {name: results[name] for name in ("log_likelihood_scan", "nis", "nis_dof") if name in results}
    if "status" in results:
        out["status"] = np.array(statuses)[results["status"]]
    return out


def frame_of(estimate: Any, statuses: Sequence[str], backend: str) -> Any:
    """A DataFrame of that library. Errors: ValueError for another backend; ImportError naming what is missing."""
    if not isinstance(backend, str) or backend not in BACKENDS:
        raise ValueError(f"backend: expected one of {', '.join(BACKENDS)}, got {backend!r}")
    columns = columns_of(estimate, statuses)
    try:
        if backend == "polars":
            import polars as pl

            return pl.DataFrame(columns)
        if backend == "pandas":
            import pandas as pd  # pyright: ignore[reportMissingImports, reportMissingModuleSource]

            return pd.DataFrame(columns)
        import pyarrow as pa  # pyright: ignore[reportMissingImports]

        return pa.table({name: np.ascontiguousarray(value) for name, value in columns.items()})
    except ImportError:
        raise ImportError(f"to_frame: {backend} is not installed; pip install {backend}") from None


def html_of(estimate: Any, statuses: Sequence[str]) -> str:
    """What it is, its first rows, and the paths in the plane."""
    head = f"<p>{escape(repr(estimate))}</p>"
    if estimate.source is None or "x" not in estimate.results:
        return head
    columns = columns_of(estimate, statuses)
    names = ["target", "time", *estimate.components, *(["status"] if "status" in columns else [])]
    rows = [
        "".join(f"<td>{escape(_cell(columns[name][k]))}</td>" for name in names)
        for k in range(min(SHOWN, len(columns["time"])))
    ]
    table = "<tr>" + "".join(f"<th>{escape(name)}</th>" for name in names) + "</tr>"
    return head + _picture(estimate) + f"<table>{table}{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def _picture(estimate: Any) -> str:
    """Paths as lines of an SVG, north up, both axes to one scale."""
    if not {"px", "py"} <= set(estimate.components):
        return ""
    p = np.column_stack([estimate["px"], -estimate["py"]])
    known = np.asarray(np.isfinite(p).all(axis=1))
    if not known.any():
        return ""
    low, high = p[known].min(axis=0), p[known].max(axis=0)
    side = max(float((high - low).max()), 1e-9)
    lines = []
    every = max(1, len(p) // POINTS)
    for first, end in zip(estimate.offsets[:-1], estimate.offsets[1:], strict=True):
        path = ((p[first:end] - low) / side * 280.0 + 10.0)[known[first:end]][::every]
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in path)
        lines.append(f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1"/>')
    return f'<svg width="300" height="300" role="img" aria-label="paths in the plane">{"".join(lines)}</svg>'
