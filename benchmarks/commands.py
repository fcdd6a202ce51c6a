"""What a user waits for at the shell: `import jink`, `jink --help`, `jink track` on real flights, `jink compare`."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
import zipfile
from pathlib import Path

CACHE = Path(__file__).with_name(".cache")
WHEEL = "traffic==2.13"
COLLECTION = "quickstart.json.gz"
NAMED = ("kalman-cv", "kalman-ca", "singer", "imm", "imm-cv-ca", "imm-cv-ct")


def measure_start(repetitions: int) -> dict[str, list[float]]:
    """Wall seconds of whole processes, interleaved: `import numpy`, `import jink`, `jink --help`."""
    commands = {
        "numpy": [sys.executable, "-c", "import numpy"],
        "jink": [sys.executable, "-c", "import jink"],
        "help": [*_jink(), "--help"],
    }
    for command in commands.values():
        _run(command)
    seconds: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(repetitions):
        for name, command in commands.items():
            seconds[name].append(_run(command)[0])
    return seconds


def measure_track(repetitions: int) -> dict[str, list[float]]:
    """Wall and CPU seconds and peak bytes of `jink track --smooth` on `traffic`'s quickstart collection."""
    source = fetch_collection()
    out: dict[str, list[float]] = {"seconds": [], "cpu": [], "bytes": []}
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "tracks.parquet")
        for _ in range(repetitions + 1):
            once = _run([*_jink(), "track", str(source), "-o", str(target), "--smooth", "--quiet"])
            for name, value in zip(out, once, strict=True):
                out[name].append(value)
    return {name: values[1:] for name, values in out.items()}  # the first read the file from the disk


def measure_compare(repetitions: int, runs: int = 1000, scenario: str = "lee-2003") -> dict[str, list[float]]:
    """Wall and CPU seconds and peak bytes of `jink compare` with ten filters (and raw and clairvoyant on top)."""
    out: dict[str, list[float]] = {"seconds": [], "cpu": [], "bytes": []}
    with tempfile.TemporaryDirectory() as folder:
        filters = ",".join([*NAMED, *four_more(Path(folder))])
        command = [*_jink(), "compare", scenario, "--filters", filters, "--runs", str(runs), "--quiet"]
        for _ in range(repetitions):
            once = _run([*command, "--json", str(Path(folder, "out.json"))])
            for name, value in zip(out, once, strict=True):
                out[name].append(value)
    return out


def four_more(folder: Path) -> list[str]:
    """Files of four IMMs for lee-2003, to make ten filters with the named ones."""
    import jink

    cv = [jink.ConstantVelocity(acceleration_sd=sd) for sd in (1.0, 10.0, 60.0)]
    ca = jink.ConstantAcceleration(jerk_psd=4.0, acceleration_prior_sd=40.0)
    ct = jink.CoordinatedTurn(acceleration_psd=4.0, turn_rate_psd=1e-6, turn_rate_prior_sd=0.05)
    banks = {"2cv": cv[::2], "3cv": cv, "3cv-ca": [*cv, ca], "cv-ca-ct": [cv[0], ca, ct]}
    for name, motions in banks.items():
        jink.IMM(motions, jink.Position(sd=500.0, axes=2), 0.96).save(folder / f"{name}.json")
    return [str(folder / f"{name}.json") for name in banks]


def fetch_collection() -> Path:
    """The collection out of the wheel of `traffic` (28 MB, fetched once into benchmarks/.cache)."""
    path = CACHE / COLLECTION
    if path.exists():
        return path
    CACHE.mkdir(exist_ok=True)
    fetch = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(CACHE), WHEEL]
    done = subprocess.run(fetch, capture_output=True, text=True, check=False)
    wheels = sorted(CACHE.glob("traffic-*.whl"))
    if done.returncode or not wheels:
        raise RuntimeError(f"could not fetch {WHEEL} for its quickstart collection: {_last_line(done.stderr)}")
    with zipfile.ZipFile(wheels[0]) as wheel:
        name = next(name for name in wheel.namelist() if name.endswith(COLLECTION))
        partial = path.with_suffix(".part")
        with wheel.open(name) as source, partial.open("wb") as sink:
            shutil.copyfileobj(source, sink)
    partial.rename(path)
    wheels[0].unlink()
    return path


def _jink() -> list[str]:
    script = Path(sysconfig.get_path("scripts"), "jink")
    return [str(script)] if script.exists() else [sys.executable, "-m", "jink"]


def installed_environment() -> dict[str, str]:
    """The environment for jink as a user has it: modules are compiled once, even where this machine says they are not.

    `pip install` compiles them. Without that a start of `jink track` takes .2 s of processor time more (AMD EPYC).
    """
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def _run(command: list[str]) -> tuple[float, float, float]:
    """Wall seconds, CPU seconds and peak resident bytes of one process; raises with its last words."""
    with tempfile.TemporaryFile("w+") as errors:
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, env=installed_environment())
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            errors.seek(0)
            raise RuntimeError(f"{' '.join(command[:3])}: exit {process.returncode}: {_last_line(errors.read())}")
    return (
        seconds,
        usage.ru_utime + usage.ru_stime,
        usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    )


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["no message"])[-1]
