"""Say in one sentence what is missing before anything is built: Python 3.11 and a C++20 compiler."""

import os
import shutil
import subprocess
import sys
import tempfile

SOURCE = "#include <version>\n#if __cplusplus < 202002L\n#error C++20\n#endif\nint main() {}\n"
WANTED = "install g++ 12 or later (Debian and Ubuntu: apt-get install g++) or clang 16 or later, or name one in CXX"


def compiler() -> str | None:
    """The C++ compiler a build would use."""
    return next((c for c in (os.environ.get("CXX"), "c++", "g++", "clang++") if c and shutil.which(c)), None)


def main() -> None:
    if sys.version_info < (3, 11):
        sys.exit(
            f"jink needs Python 3.11 or later, and {sys.executable} is {sys.version.split()[0]}; name another: "
            "make PYTHON=…"
        )
    found = compiler()
    if found is None:
        sys.exit(f"jink needs a C++20 compiler and found none: {WANTED}.")
    with tempfile.NamedTemporaryFile(suffix=".cpp", mode="w") as source:
        source.write(SOURCE)
        source.flush()
        done = subprocess.run([found, "-std=c++20", "-fsyntax-only", source.name], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"jink needs a C++20 compiler, and {found} is none: {WANTED}.")


if __name__ == "__main__":
    main()
