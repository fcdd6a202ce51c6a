"""What the trainers of shipped models have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Trainer = Callable[[int, bool], Any]  # seed, quick → the trained filter


def test_runs(quick: bool) -> int:
    """How many unseen runs a model is judged on."""
    return 200 if quick else 2000
