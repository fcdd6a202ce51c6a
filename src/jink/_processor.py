"""Which instruction-set level this processor runs: asked before any compiled module is loaded, and by CMake."""

import platform
import sys

# What each level adds to the one below, as Linux names it. Linux lists only what the system has switched on.
LEVELS = {
    "v2": {"cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"},
    "v3": {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"},
    "v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
}
_APPLE = {"avx1.0": "avx", "lahf": "lahf_lm", "lzcnt": "abm", "sse4.1": "sse4_1", "sse4.2": "sse4_2"}


def _flags() -> set[str]:
    if sys.platform == "darwin":
        # Imported here because it takes longer than all the rest.
        import subprocess

        names = ("features", "leaf7_features", "extfeatures")
        command = ["sysctl", "-n", *(f"machdep.cpu.{name}" for name in names)]
        said = subprocess.run(command, capture_output=True, text=True).stdout.lower().split()
        return {_APPLE.get(flag, flag) for flag in said}
    try:
        with open("/proc/cpuinfo") as lines:
            line = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return set()
    return set(line.partition(":")[2].split())


def level() -> str:
    """`v2`, `v3` or `v4` on x86-64 (`v2` where nothing is known), `baseline` elsewhere."""
    if platform.machine() not in ("x86_64", "AMD64", "amd64"):
        return "baseline"
    flags, best = _flags(), "v2"
    for name, needed in LEVELS.items():
        if not needed <= flags:
            break
        best = name
    return best


if __name__ == "__main__":
    print(level())
