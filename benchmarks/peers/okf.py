"""Optimized-Kalman-Filter: a Kalman filter whose Q and R are trained on the truth by gradient descent (torch).

It takes part in the race of `benchmarks.doppler` alone. Model and training are the package's, with its defaults: one
epoch, batches of ten targets, the squared error of the whole state. It brings torch, so give it an environment of its
own: `pip install Optimized-Kalman-Filter matplotlib seaborn pandas`, and jink beside it.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import okf
import torch

NAME = "OKF"
DISTRIBUTION = "Optimized-Kalman-Filter"


@dataclass(frozen=True)
class Trained:
    """Its Q (6, 6) and R (4, 4); s of processor time that the training took, and of one update by the package."""

    Q: np.ndarray
    R: np.ndarray
    seconds: float
    update: float


def line_of_sight(x: Any, z: Any) -> Any:
    """H (4, 6) of position and range rate; the line of sight is that of the measured position."""
    H = torch.zeros(4, 6, dtype=torch.double)
    H[:3, :3] = torch.eye(3, dtype=torch.double)
    H[3, 3:] = z[:3] / z[:3].norm()
    return H


def train(truth: list[np.ndarray], z: list[np.ndarray], Q: np.ndarray, R: np.ndarray, seed: int) -> Trained:
    """Train on targets' states (n, 6) and plots (n, 4) of x, y, z and range rate, from these Q and R."""
    torch.manual_seed(seed)
    np.random.seed(seed)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        model = okf.OKF(**model_of(folder, Q, R))
        begin = time.process_time()
        okf.train(model, z, truth, noise_estimation_initialization=False, verbose=0)
        seconds = time.process_time() - begin
        begin = time.process_time()
        okf.test_model(model, z[:20], truth[:20])
        update = (time.process_time() - begin) / sum(len(each) for each in z[:20])
    return Trained(model.get_Q(), model.get_R(), seconds, update)


def states(z: list[np.ndarray], Q: np.ndarray, R: np.ndarray) -> list[np.ndarray]:
    """The package's own estimates (n, 6) of each target with these Q and R."""
    model, out = okf.OKF(**model_of("", Q, R)), []
    with torch.no_grad():
        for each in z:
            model.init_state()
            rows = []
            for plot in each:
                model.predict()
                model.update(plot)
                rows.append(model.x.numpy().copy())
            out.append(np.array(rows))
    return out


def model_of(folder: str, Q: np.ndarray, R: np.ndarray) -> dict[str, Any]:
    """Arguments of the package's filter for this radar: constant velocity, a second between plots."""
    F = torch.eye(6, dtype=torch.double)
    F[:3, 3:] = torch.eye(3, dtype=torch.double)
    return {
        "dim_x": 6,
        "dim_z": 4,
        "F": F,
        "H": line_of_sight,
        "Q0": torch.tensor(Q),
        "R0": torch.tensor(R),
        "init_z2x": lambda plot: torch.cat([plot[:3], torch.zeros(3, dtype=torch.double)]),
        "model_files_path": folder,
    }
