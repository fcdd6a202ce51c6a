"""Coverage-guided fuzzing of every reader and of what else takes bytes from outside (Atheris, libFuzzer).

    python -m benchmarks.fuzz [TARGET ...] [--minutes 5] [--corpus FOLDER]

Targets: ``read`` (a file of any format), ``asterix`` and ``ais`` (their decoders), ``lines`` (what ``jink track -``
is given), ``filter`` (a filter file, which then runs), ``state`` (numbers of a saved live state under a true checksum,
then updates). Where an input leads to new code it is kept and changed further. Counted are refusals (errors that say
why), answers, and faults: any other exception, a row that is lost, an estimate that is not finite, more than 20 s. The
first input of each fault is printed and kept in FOLDER/faults. The exit status is 1 where there is one.

It needs Atheris (``pip install atheris``, Apache 2.0), which builds on Linux and macOS.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time as clock
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SLOW = 20.0
LARGEST = 6_000  # bytes of an input


class Lost(AssertionError):
    """What must not happen happened without an exception."""


def read(content: bytes, folder: Path) -> bool:
    """A file: all its rows are measurements or rejected. True: read; False: refused."""
    from jink.io.errors import InputError
    from jink.io.loading import Reading, load_files

    path = folder / "input.dat"
    path.write_bytes(content)
    try:
        loaded = load_files([path], Reading())
    except InputError:
        return False
    measured = loaded.measurements
    rejected = sum(frame.height for frame in measured.rejected)
    if loaded.count != measured.rows.height + rejected:
        raise Lost(f"{loaded.count} rows are {measured.rows.height} measurements and {rejected} rejected ones")
    return True


def _decoder(name: str) -> Callable[[bytes, Path], bool]:
    def run(content: bytes, folder: Path) -> bool:
        from importlib import import_module

        from jink.io.errors import InputError

        try:
            import_module(f"jink.io.formats.{name}").read("input", content)
        except InputError:
            return False
        return True

    return run


def lines(content: bytes, folder: Path) -> bool:
    """Lines of a stream: each is an estimate, waits, or is rejected."""
    from jink.io.errors import InputError
    from jink.io.loading import Reading
    from jink.tracking.live import LiveTracks
    from jink.tracking.prepare import Settings

    tracks = LiveTracks(Reading(), Settings())
    try:
        estimates, _ = tracks.take(content.split(b"\n"))
    except InputError:
        return False
    if "NaN" in estimates or "Infinity" in estimates:
        raise Lost("an estimate is not finite")
    return bool(estimates)


def filter(content: bytes, folder: Path) -> bool:
    """A filter file; what it holds runs over a few rows."""
    from jink.filters import loading

    try:
        made = loading.read(content.decode("utf-8", "replace"), "fuzzed")
        columns = max(len(sensor.components) for sensor in made.sensors)
        rows = np.arange(4.0 * columns).reshape(4, columns) ** 2 + 1.0
        with np.errstate(all="ignore"):
            made.filter(np.arange(4.0), rows, threads=1)
    except (ValueError, TypeError):
        return False
    return True


def state(content: bytes, folder: Path) -> bool:
    """The first byte chooses a filter; the others are numbers of its state. Estimates after it are finite."""
    from . import border

    if not _STATES:
        for made in border.filters().values():
            live = made.start()
            for k in range(5):
                live.update(float(k), [100.0 * k, 50.0 * k])
            _STATES.append((made, live.save()))
    made, whole = _STATES[content[0] % len(_STATES) if content else 0]
    changed = bytearray(whole)
    given = content[1:]
    for k in range(0, len(given) - 9, 10):  # a place, and a number for it
        place = border.HEADER + 8 * (int.from_bytes(given[k : k + 2], "little") % ((len(whole) - border.HEADER) // 8))
        changed[place : place + 8] = given[k + 2 : k + 10]
    try:
        live = made.start(state=border.signed(changed))
        for k in range(3):
            estimate = live.update(6.0 + k, [500.0, 250.0])
            if not (np.isfinite(estimate.x).all() and np.isfinite(estimate.P).all()):
                raise Lost("an estimate is not finite")
    except (ValueError, TypeError):
        return False
    return True


_STATES: list = []
TARGETS: dict[str, Callable[[bytes, Path], bool]] = {
    "read": read,
    "asterix": _decoder("asterix"),
    "ais": _decoder("ais"),
    "lines": lines,
    "filter": filter,
    "state": state,
}


def seeds(target: str) -> list[bytes]:
    """What fuzzing begins with."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from formats_written import everything

    from . import border

    if target == "state":
        places = [(3 * k).to_bytes(2, "little") + np.float64(k).tobytes() for k in range(3)]
        return [bytes([k]) + b"".join(places) for k in range(28)]
    if target == "filter":
        return [border.whole(made).encode() for made in border.filters().values()]
    if target == "lines":
        row = {"id": "a", "time": 1.7e9, "lat": 50.0, "lon": 8.0}
        rows = [row | {"time": 1.7e9 + k, "lat": 50.0 + 0.001 * k} for k in range(8)]
        plane = [{"id": "b", "time": k, "x": 10.0 * k, "y": 3.0 * k} for k in range(8)]
        return ["\n".join(map(json.dumps, table)).encode() for table in (rows, plane)]
    found = {name: _shortened(content) for name, content in everything().items()}
    alone = {"asterix": "ASTERIX", "ais": "AIS"}
    return [content for name, content in found.items() if name.startswith(alone.get(target, ""))]


def _shortened(content: bytes) -> bytes:
    """The first lines of a text; other content as it is."""
    lines = content.split(b"\n")
    return b"\n".join(lines[:16]) if len(content) > LARGEST and len(lines) > 20 else content


def work(target: str, folder: Path, seconds: int) -> None:
    """In a process of its own: fuzz, and write the counts before the end."""
    import atheris

    call, counts, known = TARGETS[target], Counter[str](), dict[str, str]()
    with atheris.instrument_imports(include=["jink"], enable_loader_override=False):
        import jink.filters.loading
        import jink.io.loading
        import jink.tracking.live  # noqa: F401

    def one(content: bytes) -> None:
        began = clock.monotonic()
        try:
            counts["answers" if call(content, folder) else "refused"] += 1
            if clock.monotonic() - began > SLOW:
                raise Lost(f"took {clock.monotonic() - began:.0f} s")
        except Exception as error:
            counts["faults"] += 1
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{type(error).__name__} at {Path(place.filename).name}:{place.lineno}"
            if where not in known:
                known[where] = str(error)[:200]
                name = hashlib.sha256(content).hexdigest()[:12]
                (folder / "faults").mkdir(exist_ok=True)
                (folder / "faults" / f"{target}-{name}").write_bytes(content)
        if sum(counts.values()) % 200 == 0 or counts["faults"]:
            (folder / "counts.json").write_text(json.dumps([counts, known]))

    corpus = folder / f"corpus-{target}"
    corpus.mkdir(exist_ok=True)
    for number, content in enumerate(seeds(target)):
        (corpus / f"seed-{number}").write_bytes(content)
    options = [f"-max_total_time={seconds}", f"-max_len={LARGEST}", "-timeout=60", "-rss_limit_mb=3000", "-verbosity=0"]
    atheris.Setup(["fuzz", str(corpus), *options, f"-artifact_prefix={folder}/"], one)
    atheris.Fuzz()


def main(arguments: list[str] | None = None) -> int:
    """A line for each target, and one for each fault."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("targets", nargs="*", choices=[*TARGETS, []])
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--corpus", type=Path, help="kept there; default: a temporary folder")
    parser.add_argument("--work", choices=TARGETS, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    folder = options.corpus or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    if options.work:
        work(options.work, folder, round(60 * options.minutes))
        return 0
    print(f"{'':8}{'inputs':>10}{'refused':>10}{'answers':>10}{'faults':>8}{'kept':>7}{'ended':>7}")
    bad = 0
    for target in options.targets or TARGETS:
        (folder / "counts.json").write_text("[{}, {}]")
        command = [sys.executable, "-m", "benchmarks.fuzz", "--work", target, "--minutes", str(options.minutes)]
        done = subprocess.run([*command, "--corpus", folder], capture_output=True, check=False, cwd=ROOT)
        counts, known = json.loads((folder / "counts.json").read_text())
        kept = len(list((folder / f"corpus-{target}").iterdir()))
        figures = [counts.get(name, 0) for name in ("refused", "answers", "faults")]
        print(
            f"{target:8}{sum(figures):>10,}{figures[0]:>10,}{figures[1]:>10,}{figures[2]:>8}{kept:>7}{done.returncode:>7}",
            flush=True,
        )
        for where, message in known.items():
            print(f"    {where}: {message}")
        if done.returncode:
            print(done.stderr.decode(errors="replace")[-2000:])
        bad += figures[2] + (done.returncode != 0)
    print(f"kept in {folder}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
