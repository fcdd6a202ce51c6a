"""bayesian-filters: a maintained fork of FilterPy."""

from functools import partial

import bayesian_filters.kalman as library

from . import labbe

NAME = "bayesian-filters"
DISTRIBUTION = "bayesian-filters"
CANNOT: dict[str, str] = {}

kalman = partial(labbe.kalman, library)
imm = partial(labbe.imm, library)
live = partial(labbe.live, library)
