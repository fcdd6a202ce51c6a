"""Test set-up: the oracle package importable from any working directory, and hypothesis profiles.

`--hypothesis-profile explore --hypothesis-seed 1` draws other examples than the fixed ones of every run.
"""

from __future__ import annotations

import gc
import sys
from pathlib import Path

from hypothesis import HealthCheck, settings

# the oracle package, and what several test files share
sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "support")]

settings.register_profile(
    "jink",
    derandomize=True,  # the same examples in every run
    deadline=None,
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.register_profile("explore", settings.get_profile("jink"), derandomize=False, database=None)
settings.load_profile("jink")


def pytest_unconfigure() -> None:
    """Takes hypothesis' callback from the garbage collector, which would keep all tests past the interpreter's end.

    With them stay the filters among their parameters, and nanobind reports those as leaked.
    """
    gc.callbacks[:] = [call for call in gc.callbacks if not call.__module__.startswith("hypothesis")]
