"""FilterPy: the best known Kalman filter library in Python, NumPy on one track at a time."""

from functools import partial

import filterpy.kalman as library

from . import labbe

NAME = "FilterPy"
DISTRIBUTION = "filterpy"
CANNOT: dict[str, str] = {}

kalman = partial(labbe.kalman, library)
imm = partial(labbe.imm, library)
live = partial(labbe.live, library)
