# The engine's private face, the same at every level; written by: python -m nanobind.stubgen -m jink._native_v4
from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray

largest_own: int = 16

def mix(
    x: Sequence[Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)]],
    P: Sequence[Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)]],
    w: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def update(
    x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    y: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    H: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    R: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    present: Annotated[NDArray[numpy.bool_], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def root(
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    semidefinite: bool = False,
    least: float = 1e-300,
) -> NDArray[numpy.float64]: ...
def solve(
    L: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    X: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    transposed: bool = False,
) -> NDArray[numpy.float64]: ...
def linearise_motion(
    motion: tuple[int, int, int, int, Sequence[float], Sequence[float]],
    unscented: bool,
    dt: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    input: object | None,
) -> tuple: ...
def observe_sensor(
    sensor: tuple[
        int, int, int, int, bool, bool, bool, bool, Sequence[float], Sequence[float], Sequence[float]
    ],
    x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def position_of(
    sensor: tuple[
        int, int, int, int, bool, bool, bool, bool, Sequence[float], Sequence[float], Sequence[float]
    ],
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    R: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    present: Annotated[NDArray[numpy.bool_], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def transition_over(
    continuous: bool,
    matrix: Sequence[float],
    modes: int,
    dt: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]: ...

largest_population_modes: int = 5

def population_errors(
    tables: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    count: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    transition: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    probability: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    position: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    variance: float,
    result: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu")],
    threads: int,
) -> None: ...
lanes: int = 8

class Engine:
    def __init__(
        self,
        arg0: Sequence[
            tuple[
                int,
                int,
                int,
                int,
                Sequence[float],
                Sequence[float],
                tuple[int, Sequence[int], bool, Sequence[float]],
                Sequence[float],
                bool,
            ]
        ],
        arg1: Sequence[
            tuple[
                int, int, int, int, bool, bool, bool, bool, Sequence[float], Sequence[float], Sequence[float]
            ]
        ],
        arg2: bool,
        arg3: Sequence[float],
        arg4: Sequence[float],
        arg5: bool,
        arg6: bool,
        arg7: float,
        arg8: int,
        arg9: float,
        arg10: bool,
        arg11: float,
        arg12: int,
        arg13: Sequence[
            tuple[
                int,
                int,
                int,
                int,
                Sequence[float],
                Sequence[float],
                tuple[int, Sequence[int], bool, Sequence[float]],
                Sequence[float],
                bool,
            ]
        ],
        arg14: tuple[int, int, Sequence[float], Sequence[Sequence[int]], Sequence[float]],
        arg15: tuple[int, Sequence[int], bool, Sequence[float]],
        arg16: tuple[int, int, float],
        arg17: tuple[int, int, int, int, Sequence[int], Sequence[float]],
        /,
    ) -> None: ...
    def run(
        self,
        time: Annotated[NDArray[numpy.float64], dict(order="C", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", writable=False)],
        columns: int,
        offsets: Annotated[NDArray[numpy.int64], dict(order="C", writable=False)],
        sensor: object | None,
        noise: object | None,
        full_noise: bool,
        input: object | None,
        prior_x: object | None,
        prior_P: object | None,
        results: list,
        status: object | None,
        smooth: bool,
        threads: int,
    ) -> None: ...
    def one(self, arg: int, /) -> LiveOne: ...
    def many(self, arg0: int, arg1: int, /) -> LiveMany: ...

class Estimate:
    @property
    def time(self) -> float: ...
    @property
    def x(self) -> object: ...
    @property
    def P(self) -> object: ...
    @property
    def mode_probability(self) -> object: ...
    @property
    def log_likelihood(self) -> float: ...
    @property
    def nis(self) -> float: ...
    @property
    def nis_dof(self) -> float: ...
    @property
    def status(self) -> str: ...

class LiveOne:
    def update(
        self,
        t: object,
        z: object | None,
        sensor: int = 0,
        covariance: object | None = None,
        input: object | None = None,
    ) -> Estimate:
        """
        One measurement at time t; returns the estimate it leads to. A missing z is None, a missing component NaN or None.
        """

    def predict(self, t: object) -> Estimate:
        """The estimate expected at time t; the live state is not touched."""

    def begin(
        self,
        x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        time: float,
    ) -> None:
        """Start from a given state at a time."""

    def reset(self) -> None:
        """Forget the target; the next position starts a new one."""

    def save(self) -> bytes:
        """The state as bytes, the same on every machine."""

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""

    def __getstate__(self) -> bytes: ...

class LiveMany:
    def update(
        self,
        t: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        sensor: object | None,
        noise: object | None,
        input: object | None,
        results: list,
        predict_only: bool,
    ) -> None: ...
    def begin(
        self,
        arg0: int,
        arg1: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        arg2: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        arg3: float,
        /,
    ) -> None: ...
    def reset(self, arg: int, /) -> None: ...
    def time(self, arg: int, /) -> float: ...
    def save(self) -> bytes: ...
    def restore(self, arg: bytes, /) -> None: ...
