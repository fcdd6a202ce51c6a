"""Mutated states and filter files against the engine's border: refused, equal, or taken; never a crash.

    python -m benchmarks.border [states] [files] [--mutations 1e6] [--seed 1] [--from 0] [--workers 2]

Mutations come in blocks of 10,000, each with its own random numbers: --from 300000 --mutations 1e5 runs the fourth
hundred thousand of a million, here or on another machine. Each block runs in a process of its own.

States: what ``save`` gave of every registered filter, with changed, lost, added and swapped bytes; one in eight of them
with other numbers and a true checksum, so that they reach the engine. Files: what a filter's ``save`` wrote, with
changed bytes, or with hostile values in place of its own. A filter that is made of such a file runs over a few rows.
Counted are:

    refused   a ValueError (or TypeError) that says why
    equal     the state, or the filter, is what it was before the change
    taken     another legal state, or another legal filter, which then ran
    other     any other exception, or a refused state that changed the tracks
    crashes   the process ended

The exit status is 1 where the last two are not 0.
"""

from __future__ import annotations

import argparse
import copy
import json
import multiprocessing
import sys
import time as clock
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.filters import loading
from jink.filters.plain import VERSION
from jink.models.outliers import Outliers
from jink.models.sensor import Position

HEADER, CHECKSUM = 48, 40
BLOCK = 10_000  # mutations that share random numbers
SEEDS = 10**9  # of one --seed: the number of a mutation is added
COUNTED = ("refused", "equal", "taken", "other", "crashes")
HOSTILE: tuple[Any, ...] = (
    *(None, True, "", "x", [], {}, [[]], -1, 0, 1, 2, 65, 513, 2**31, 2**63, 10**400),
    *(
        -1e-300,
        1e-300,
        5e-324,
        1e300,
        -1e300,
        float("nan"),
        float("inf"),
        float("-inf"),
        "Kalman",
        {"kind": "Position"},
    ),
)
Rng = np.random.Generator


def filters() -> dict[str, Any]:
    """Every registered filter for a target on a plane."""
    purpose = Purpose(sensor=Position(sd=10.0), sd=10.0, outliers=Outliers())
    return {name: make(purpose).filter for name, make in FILTERS.items()}


def whole(filter: Any) -> str:
    """The text of a filter's file."""
    return json.dumps({"jink": "filter", "version": VERSION, "units": "SI", **filter.described()})


def signed(state: bytearray) -> bytes:
    """The state with a true checksum of its numbers (FNV-1a)."""
    digest = 1469598103934665603
    for byte in state[HEADER:]:
        digest = (digest ^ byte) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    state[CHECKSUM:HEADER] = digest.to_bytes(8, "little")
    return bytes(state)


def bent(text: bytes, rng: Rng) -> bytearray:
    """One to four changes of bytes: another one, a turned bit, a cut, bytes more, a piece elsewhere."""
    out = bytearray(text)
    for _ in range(int(rng.integers(1, 5))):
        at, kind = int(rng.integers(0, max(1, len(out)))), int(rng.integers(10))
        if at >= len(out):
            continue
        if kind < 4:
            out[at] = int(rng.integers(256))
        elif kind < 7:
            out[at] ^= 1 << int(rng.integers(8))
        elif kind == 7:
            del out[at : at + int(rng.integers(1, 64))]
        elif kind == 8:
            out[at:at] = rng.bytes(int(rng.integers(1, 64)))
        else:
            size, to = int(rng.integers(1, 32)), int(rng.integers(0, len(out)))
            out[to : to + size] = out[at : at + size]
    return out


def numbers_of(state: bytes, rng: Rng) -> bytes:
    """The state with one to three other numbers, and a true checksum."""
    out = bytearray(state)
    count = (len(out) - HEADER) // 8
    for _ in range(int(rng.integers(1, 4))):
        at, to = (HEADER + 8 * int(k) for k in rng.integers(0, count, 2))
        strange = (np.nan, np.inf, -np.inf, 1e300, -1e300, -1.0, 0.5, 1e-310, 1e6, -0.0)
        value = out[at : at + 8] if rng.random() < 0.3 else np.float64(rng.choice(strange)).tobytes()
        out[to : to + 8] = value
    return signed(out)


def states(rng: Rng) -> Iterator[str]:
    """What became of one mutated state after the other, of all filters in turn."""
    held = []
    for filter in filters().values():
        live = filter.start()
        for k in range(5):
            live.update(float(k), [100.0 * k, 50.0 * k + 3.0 * rng.standard_normal()])
        held.append((live, live.save()))
    turn = 0
    while True:
        live, state = held[turn % len(held)]
        turn += 1
        true = rng.random() < 0.125
        changed = numbers_of(state, rng) if true else bytes(bent(state, rng))
        try:
            live.restore(changed)
        except (ValueError, TypeError):
            yield "refused" if turn % 50 or live.save() == state else "other"
            continue
        if changed == state:
            yield "equal"
            continue
        try:
            live.update(1e9, [1.0, 2.0])
            live.update(1e9 + 1.0, [np.nan, np.nan])
        except (ValueError, TypeError):
            pass
        live.restore(state)
        yield "taken"


def places(body: Any) -> Iterator[tuple[Any, Any]]:
    """Every (holder, key) of a JSON value."""
    keys = range(len(body)) if isinstance(body, list) else list(body) if isinstance(body, dict) else ()
    for key in keys:
        yield body, key
        yield from places(body[key])


def changed_body(text: str, rng: Rng) -> str:
    """The file with one to three of its values, or of its names, changed."""
    body = json.loads(text)
    for _ in range(int(rng.integers(1, 4))):
        all_of_it = list(places(body))
        if not all_of_it:
            break
        holder, key = all_of_it[int(rng.integers(len(all_of_it)))]
        other, place = all_of_it[int(rng.integers(len(all_of_it)))]
        kind, value = int(rng.integers(8)), holder[key]
        if kind == 0:
            del holder[key]
        elif kind == 1:
            holder[key] = json.loads(json.dumps(other[place]))
        elif kind == 2 and isinstance(value, list):
            holder[key] = value * int(rng.integers(0, 9))
        elif kind == 3 and isinstance(value, float):
            holder[key] = value * float(10.0 ** rng.uniform(-9, 9)) * float(rng.choice([-1.0, 1.0]))
        elif kind == 4 and isinstance(holder, dict):
            holder[str(rng.choice(["kind", "x", "motions", "sensor", str(key) + "s"]))] = value
        else:
            holder[key] = copy.deepcopy(HOSTILE[int(rng.integers(len(HOSTILE)))])
    return json.dumps(body)


def files(rng: Rng) -> Iterator[str]:
    """What became of one mutated filter file after the other, of all filters in turn."""
    texts = [whole(filter) for filter in filters().values()]
    t, z = np.arange(4.0), np.arange(8.0).reshape(4, 2) ** 2
    turn = 0
    while True:
        text = texts[turn % len(texts)]
        turn += 1
        if rng.random() < 0.5:
            changed = bent(text.encode(), rng).decode("utf-8", "replace")
        else:
            changed = changed_body(text, rng)
        try:
            filter = loading.read(changed, "mutated")
            sensor = filter.sensors[0]
            rows = z if len(sensor.components) == 2 else np.ones((4, len(sensor.components)))
            with np.errstate(all="ignore"):
                filter.filter(t, rows, threads=1)
        except (ValueError, TypeError):
            yield "refused"
        else:
            yield "equal" if changed == text or whole(filter) == text else "taken"


WHAT: dict[str, Callable[[Rng], Iterator[str]]] = {"states": states, "files": files}


def work(what: str, seed: int, count: int, shared: Any) -> None:
    """Counts into ``shared``, in the order of COUNTED; then what was counted last, and the first other exception."""
    running = WHAT[what](np.random.default_rng(seed))
    for _ in range(count):
        try:
            came = next(running)
        except Exception as error:
            print(f"{what}: {type(error).__name__}: {error}", flush=True)
            came, running = "other", WHAT[what](np.random.default_rng([seed, shared[len(COUNTED)]]))
        shared[COUNTED.index(came)] += 1
        shared[len(COUNTED)] += 1


def run(what: str, seed: int, count: int) -> Counter[str]:
    """So many mutations in processes of their own; one that ends before it is done is a crash, and the next goes on."""
    shared, context = multiprocessing.Array("q", len(COUNTED) + 1, lock=False), multiprocessing.get_context("fork")
    while shared[len(COUNTED)] < count:
        done = shared[len(COUNTED)]
        child = context.Process(target=work, args=(what, seed + done, count - done, shared))
        child.start()
        child.join()
        if shared[len(COUNTED)] < count:
            shared[COUNTED.index("crashes")] += 1
            shared[len(COUNTED)] += 1
            print(
                f"{what}: ended with {child.exitcode} at mutation {shared[len(COUNTED)] - done} of seed {seed + done}"
            )
    return Counter(dict(zip(COUNTED, shared[: len(COUNTED)], strict=True)))


def blocks(what: str, seed: int, first: int, count: int, workers: int) -> Counter[str]:
    """The mutations from ``first`` on, block by block, some blocks at a time."""
    starts = range(first, first + count, BLOCK)
    sizes = [min(BLOCK, first + count - start) for start in starts]
    seeds, what_of_each = [SEEDS * seed + start for start in starts], [what] * len(starts)
    with ProcessPoolExecutor(workers) as pool:
        return sum(pool.map(run, what_of_each, seeds, sizes), Counter[str]())


def main(arguments: list[str] | None = None) -> int:
    """Print a line of counts for states and for files."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.border", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("what", nargs="*", choices=[*WHAT, []], help="both where none is named")
    parser.add_argument("--mutations", type=float, default=1e6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=float, default=0, dest="first", help="number of the first mutation")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    options = parser.parse_args(arguments)
    first, count = int(options.first), int(options.mutations)
    if first % BLOCK:
        parser.error(f"--from: expected a multiple of {BLOCK}, got {first}")
    print(f"{'':8}{'mutations':>12}" + "".join(f"{name:>12}" for name in COUNTED) + f"{'s':>8}")
    bad = 0
    for what in options.what or list(WHAT):
        began = clock.perf_counter()
        counts = blocks(what, options.seed, first, count, options.workers)
        figures = "".join(f"{counts[name]:>12,}" for name in COUNTED)
        print(f"{what:8}{count:>12,}{figures}{clock.perf_counter() - began:>8.0f}", flush=True)
        bad += counts["other"] + counts["crashes"]
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
