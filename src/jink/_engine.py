"""The compiled engine at the best instruction-set level this machine has; JINK_ISA=v2|v3|v4 asks for a lower one."""

import importlib
import os
import sys
from types import ModuleType


def _load(level: str) -> ModuleType:
    return importlib.import_module(f"jink._native_{level}")


def _best() -> tuple[str, ModuleType]:
    try:
        lowest = _load("v2")
    except ModuleNotFoundError:
        try:
            return "baseline", _load("baseline")
        except ModuleNotFoundError:
            raise ImportError(
                "jink's compiled engine is missing: install the package (make install, or pip install .) instead of "
                f"importing its sources; looked for jink._native_* beside {__file__} with Python {sys.version.split()[0]}"
            ) from None
    most = lowest.cpu_level()
    wanted = os.environ.get("JINK_ISA", f"v{most}")
    if wanted not in ("v2", "v3", "v4") or int(wanted[1]) > most:
        raise ImportError(f"JINK_ISA: expected v2 to v{most} on this machine, got {wanted!r}")
    return wanted, lowest if wanted == "v2" else _load(wanted)


level, native = _best()
lanes: int = native.lanes
Engine = native.Engine
