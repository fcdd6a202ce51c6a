"""Known faults of what is installed here, by pip-audit; it says clearly where its service cannot be reached.

python scripts/known_faults.py
"""

from __future__ import annotations

import subprocess
import sys

# what pip-audit says where it did not get an answer
UNREACHED = ("ConnectionError", "ServiceError", "Max retries", "timed out", "Could not connect", "HTTPError")


def main() -> int:
    """0: asked, and none is known; 1: some are known; 2: could not ask."""
    command = [sys.executable, "-m", "pip_audit", "--skip-editable", "--progress-spinner", "off", "--timeout", "20"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "No module named pip_audit" in done.stderr:
        print("NOT AUDITED: pip-audit is not installed here, and make audit could not install it")
        return 2
    if done.returncode and any(word in done.stderr for word in UNREACHED):
        last = (done.stderr.strip().splitlines() or ["no answer"])[-1]
        print(f"NOT AUDITED: the service that knows faults of packages cannot be reached ({last})")
        return 2
    print(done.stdout + done.stderr, end="")
    return int(done.returncode != 0)


if __name__ == "__main__":
    sys.exit(main())
