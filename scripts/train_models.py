"""Trains the models that come with the package again and writes their files: python scripts/train_models.py [NAME ...]"""

import sys
import time
from pathlib import Path

from jink.learn.models import CHOI, SEEDS, TRAINERS, train
from jink.models import file_name

FOLDER = Path(__file__).parents[1] / "src" / "jink" / "papers" / "models"


def main(names: list[str]) -> None:
    """All of them without names."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names or TRAINERS:
        for seed in SEEDS if name in CHOI else [None]:
            began = time.perf_counter()
            filter = train(name, seed or 0)
            filter.save(FOLDER / file_name(name, seed))
            print(f"{file_name(name, seed)}: {time.perf_counter() - began:.1f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
