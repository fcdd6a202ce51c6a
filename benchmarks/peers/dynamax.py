"""dynamax: state-space models in JAX; its linear filter mapped over the tracks, compiled, in doubles."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from dynamax.linear_gaussian_ssm.inference import lgssm_filter, make_lgssm_params

from ..cases import Case
from ..race import Job

NAME = "dynamax"
DISTRIBUTION = "dynamax"
CANNOT = {"imm": "no IMM", "live": "no IMM"}


def kalman(case: Case) -> Job:
    """lgssm_filter under jit(vmap): the whole batch in one call; compiled in the warm-up."""
    jax.config.update("jax_enable_x64", True)
    F, Q, H, R = (jnp.asarray(a) for a in (case.F, case.Q[0], case.H, case.R))

    def one(x0: Any, P0: Any, z: Any) -> Any:
        return lgssm_filter(make_lgssm_params(x0, P0, F, Q, H, R), z).filtered_means

    filter_all = jax.jit(jax.vmap(one))
    x0, z = jnp.asarray(case.x0), jnp.asarray(case.measurements())
    P0 = jnp.asarray(np.tile(case.P0, (case.tracks, 1, 1)))
    return Job(lambda _: filter_all(x0, P0, z).block_until_ready(), case.updates)
