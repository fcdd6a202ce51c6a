"""The compiled engine: of the installed instruction-set levels the best this processor runs; JINK_ISA=v2|v3|v4 asks for
one.
"""

import importlib
import importlib.util
import os
import sys
from typing import TYPE_CHECKING

from . import _processor

_LEVELS = ("baseline", "v2", "v3", "v4")
_OTHERS = 'make install LEVELS=all, or pip install ".[all]"'


def _installed() -> list[str]:
    return [level for level in _LEVELS if importlib.util.find_spec(f"jink._native_{level}")]


def _choose(installed: list[str], most: str, wanted: str | None) -> str:
    """One of the installed levels, none above `most`; `wanted` is what JINK_ISA says."""
    if not installed:
        raise ImportError(
            "jink's compiled engine is missing: install the package (make install, or pip install .) instead of "
            f"importing its sources; looked for jink._native_* beside {__file__} with Python {sys.version.split()[0]}"
        )
    usable = [level for level in installed if _LEVELS.index(level) <= _LEVELS.index(most)]
    if not usable:
        raise ImportError(
            f"jink was built for {' and '.join(installed)}, and this processor runs {most} at most; "
            f"build it here: {_OTHERS}"
        )
    if wanted is None:
        return usable[-1]
    if wanted not in usable:
        raise ImportError(
            f"JINK_ISA: expected one of {', '.join(usable)}, which are installed and run on this machine, "
            f"got {wanted!r}; for other levels: {_OTHERS}"
        )
    return wanted


installed = _installed()
level = _choose(installed, _processor.level(), os.environ.get("JINK_ISA"))
if TYPE_CHECKING:  # the stub of one level stands for all
    from . import _native_v4 as native
else:
    native = importlib.import_module(f"jink._native_{level}")
lanes: int = native.lanes
Engine = native.Engine
