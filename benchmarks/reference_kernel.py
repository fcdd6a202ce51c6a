"""The hand-written kernel of one case (reference_kernel.cpp): compiled here, checked against jink, timed beside it."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from .cases import ACCELERATION_SD, POSITION_SD, STEP, Case
from .race import Job, difference
from .targets import SAME

SOURCE = Path(__file__).with_name("reference_kernel.cpp")
OPTIONS = (
    "-std=c++17",
    "-O3",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-Wno-psabi",
    "-shared",
    "-fPIC",
)
LEVEL = os.environ.get("JINK_ISA")
MARCH = f"-march=x86-64-{LEVEL}" if LEVEL in ("v2", "v3", "v4") else "-march=native"  # the instructions that jink uses


def job(case: Case) -> Job:
    """The kernel over all tracks of the case, into the same arrays each time.

    Errors: RuntimeError without a C++ compiler, or with what it says.
    """
    run, x, _ = _kernel(case)
    return Job(lambda _: (run(), x)[1], case.updates)


def check(case: Case, states: Any, log_likelihood: Any) -> None:
    """Both filters give the same. Errors: RuntimeError naming the largest difference."""
    run, x, likelihood = _kernel(case)
    run()
    worst = max(difference(states, x), float(np.abs(np.asarray(log_likelihood) / likelihood - 1).max()))
    if not worst <= SAME:
        raise RuntimeError(f"reference kernel: differs from jink by {worst:.0e}; expected at most {SAME:.0e}")


def _kernel(case: Case) -> tuple[Callable[[], None], np.ndarray, np.ndarray]:
    """What runs it, and the arrays it writes: states (tracks × scans, 4) and log-likelihoods (tracks,)."""
    built = library()
    x, likelihood = np.empty((case.updates, 4)), np.empty(case.tracks)
    q = np.square(ACCELERATION_SD)
    given = [q, POSITION_SD**2, case.transition, case.x0, case.P0[np.tril_indices(4)], case.z]
    arrays = [np.ascontiguousarray(value, dtype=float) if isinstance(value, np.ndarray) else value for value in given]
    arguments = [ctypes.c_double(a) if isinstance(a, float) else a.ctypes.data_as(ctypes.c_void_p) for a in arrays]
    results = [value.ctypes.data_as(ctypes.c_void_p) for value in (x, likelihood)]
    sizes = ctypes.c_long(case.tracks), ctypes.c_long(case.scans), ctypes.c_double(STEP)

    def run(_keep: list[Any] = arrays) -> None:
        built.reference_imm(*sizes, *arguments, *results)

    return run, x, likelihood


@cache
def library() -> ctypes.CDLL:
    """The kernel, compiled. Errors: RuntimeError without a C++ compiler, or with what it says."""
    compiler = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        raise RuntimeError("reference kernel: found no C++ compiler (c++ or g++, or one named in CXX)")
    with tempfile.TemporaryDirectory() as folder:
        built = Path(folder) / "reference_kernel.so"
        command = [compiler, MARCH, *OPTIONS, str(SOURCE), "-o", str(built)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"reference kernel: {compiler} says {done.stderr.strip()[:300]}")
        kernel = ctypes.CDLL(str(built))
    kernel.reference_imm.restype = None
    return kernel
