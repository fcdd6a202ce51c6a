"""Parameters used to simulate come back: the truth lies within three standard errors of what is fitted to the
measurements.
"""

from __future__ import annotations

import numpy as np
from oracle import motion as om

import jink
from jink.fit.objectives import Likelihood
from jink.fit.optimise import Search
from jink.fit.parameters import Parameters
from jink.fit.uncertainty import standard_errors
from jink.models.tracks import Tracks

TRACKS, SCANS, SD, FINE = 500, 60, 15.0, 0.5


def as_tracks(z, time):
    B, S = z.shape[:2]
    return Tracks(np.tile(time, B), z.reshape(B * S, -1), np.arange(B + 1) * S)


def assert_recovered(start, truth, tracks, free=("*",), fixed=()):
    """From a start a factor of two or so away; each parameter's error in standard errors."""
    parameters = Parameters(start, free=free, fixed=fixed)
    found = Search(parameters, Likelihood(), tracks, starts=1, seed=0).run()
    sd = standard_errors(parameters, Likelihood(), found.u, tracks).sd
    true = Parameters(truth, free=free, fixed=fixed)
    assert true.names == parameters.names
    assert np.isfinite(sd).all()
    assert (sd < 0.25).all(), dict(zip(parameters.names, sd, strict=True))
    off = (found.u - true.start) / sd
    assert (np.abs(off) < 3.0).all(), dict(zip(parameters.names, off, strict=True))
    assert np.abs(parameters.start - true.start).max() > 5 * sd.min()


def test_singer():
    """Manoeuvre frequency, acceleration and measurement noise of 500 tracks."""
    rng = np.random.default_rng(7)
    time, sd, tau = np.arange(SCANS) * 2.0, 4.0, 12.0
    P0 = np.diag([100.0**2, 50.0**2, sd**2])
    model = om.Singer(1, sd, tau)
    F, Q = model.F(None, 2.0), model.Q(2.0)
    x = rng.multivariate_normal(np.zeros(3), P0, TRACKS)
    z = np.empty((TRACKS, SCANS, 1))
    for k in range(SCANS):
        if k:
            x = x @ F.T + rng.multivariate_normal(np.zeros(3), Q, TRACKS)
        z[:, k, 0] = x[:, 0] + rng.normal(0, SD, TRACKS)

    def filter(sd, tau, noise):
        motion = jink.Singer(acceleration_sd=sd, time_constant=tau)
        return jink.Kalman(motion, jink.Position(sd=noise, axes=1), initial=jink.Prior(np.zeros(3), P0))

    assert_recovered(filter(8.0, 5.0, 25.0), filter(sd, tau, SD), as_tracks(z, time))


def test_imm_of_two_modes():
    """Both noises and both transition rows of 500 tracks whose modes switch.

    Seen finely, velocity too: an IMM's likelihood is the true one only where the state is known whatever the modes were
    before. Seen with 15 m the merging of modes biases a fit by tens of its small standard errors: it fits the filter,
    not the target.
    """
    rng = np.random.default_rng(8)
    time, sds = np.arange(SCANS) * 1.0, np.array([6.0, 40.0])
    chain = np.array([[0.95, 0.05], [0.1, 0.9]])
    P0 = np.diag([100.0**2, 20.0**2] * 2)
    F, G = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([0.5, 1.0])
    x = rng.multivariate_normal(np.zeros(4), P0, TRACKS).reshape(TRACKS, 2, 2)
    mode = (rng.random(TRACKS) < 1 / 3).astype(int)  # the chain's stationary distribution
    z = np.empty((TRACKS, SCANS, 4))
    for k in range(SCANS):
        if k:
            mode = (rng.random(TRACKS) < chain[mode, 1]).astype(int)
            x = x @ F.T + sds[mode][:, None, None] * rng.normal(size=(TRACKS, 2, 1)) * G
        z[:, k] = np.c_[x[:, :, 0], x[:, :, 1]] + rng.normal(0, FINE, (TRACKS, 4))

    def filter(sds, chain):
        modes = [jink.ConstantVelocity(acceleration_sd=sd) for sd in sds]
        sensor = jink.PositionVelocity(sd=FINE, velocity_sd=FINE)
        return jink.IMM(modes, sensor, chain, initial=jink.Prior(np.zeros(4), P0))

    start = filter([12.0, 20.0], [[0.8, 0.2], [0.3, 0.7]])
    assert_recovered(start, filter(sds, chain), as_tracks(z, time), free=(), fixed=("sensor.*",))
