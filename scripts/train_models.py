"""Trains the models that come with the package again and writes their files.

python scripts/train_models.py [--check] [NAME ...]
"""

import argparse
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from jink.catalogue.shipped import file_name
from jink.papers.training.shipped import CHOI, SEEDS, TRAINERS, train

FOLDER = Path(__file__).parents[1] / "src" / "jink" / "catalogue" / "models"


def main() -> int:
    """With --check nothing is written: exit status 1 if a file is not what the training gives, bit for bit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"without: all of {', '.join(TRAINERS)}")
    parser.add_argument("--check", action="store_true", help="compare with the files that are there")
    options = parser.parse_args()
    different = 0
    for name in options.names or TRAINERS:
        for seed in SEEDS if name in CHOI else [None]:
            began = time.process_time()
            filter = train(name, seed or 0)
            seconds = time.process_time() - began
            there = FOLDER / file_name(name, seed)
            said = _written(filter, there) if not options.check else _compared(filter, there)
            different += said == "different"
            print(f"{there.name}: {seconds:.1f} s of CPU, {said}", flush=True)
    return 1 if different else 0


def _written(filter, file: Path) -> str:
    file.parent.mkdir(parents=True, exist_ok=True)
    filter.save(file)
    return "written"


def _compared(filter, file: Path) -> str:
    with TemporaryDirectory() as folder:
        filter.save(Path(folder) / file.name)
        same = file.exists() and (Path(folder) / file.name).read_bytes() == file.read_bytes()
    return "the same" if same else "different"


if __name__ == "__main__":
    sys.exit(main())
