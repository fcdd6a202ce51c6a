"""The default filters' coasting agrees with the textbook, through gaps and with heights that are not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import oracle.twin as tw
import pytest
from oracle.situations import BOUNDED, CA, CT, CV, LEADING, P2, P3, ROBUST, make_data
from oracle.twin import Twin

COASTING = {"after": 3.0, "manoeuvre": 4.0, "climb": 6.0}


@pytest.mark.parametrize("reverses", [True, False])
@pytest.mark.parametrize(("sensor", "axes"), [(P2, 2), (P3, 3)])
@pytest.mark.parametrize("seed", range(3))
def test_the_default_modes_coast_as_the_textbook_says(sensor, axes, reverses, seed):
    twin = Twin(
        [CV, CA, CT],
        [sensor],
        axes,
        LEADING,
        outliers=ROBUST,
        initial=BOUNDED,
        coasting=COASTING | {"reverses": reverses},
    )
    data = make_data(twin, N=60, seed=seed)
    # gaps, predicted in several rows, and heights that end
    for begin in (15, 32, 48):
        data.z[begin : begin + 5] = np.nan
        data.time[begin + 2 :] += 15.0
    if axes == 3:
        data.z[24:30, 2] = np.nan
    native, oracle = tw.run_native(twin, data), tw.run_oracle(twin, data)
    # covariances of condition c lose c² roundings where a long gap is filtered in two steps of elimination
    rounding = np.finfo(float).eps * tw.conditioning(oracle) ** 2
    assert max(tw.distances(native, oracle).values()) < max(1e-9, rounding) < 1e-7
    # it does something: without it the estimates are others
    plain = tw.run_native(replace(twin, coasting=None), data)
    assert np.nanmax(np.abs(plain.x - native.x)) > 1.0
