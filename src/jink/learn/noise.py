"""NNVSMM's Kalman filter in NumPy, with its derivative: the process noise of every scan chosen by a network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import Array
from ..models.noise_network import LEAST_NIS, NoiseNetwork
from .data import Runs
from .mlp import Parameters, backward, forward, slope_of_inputs

Kernel = tuple[Array, Array, Array]  # P00 P01 P11 (B,), the same along every axis


@dataclass
class _Scan:
    """What one scan's derivative needs."""

    q: Array
    S_last: Array
    r: Array
    nis: Array
    layers: list[Array]
    slope: Array  # dq/dy
    S: Array
    before: Array  # P⁻00
    cross: Array  # P⁻01


class Rollout:
    """Both axes' constant-velocity filters (T the time between scans, two-point start) under a network's noise.

    forward gives the estimates of position (B, S, 2), NaN before the third scan, velocities and the chosen q (B, S);
    backward turns the loss's slope in the positions into slopes in the network's parameters, through the whole track:
    what the noise of one scan does to all later ones counts. Every run must be measured at every scan.
    """

    def __init__(self, model: NoiseNetwork, runs: Runs) -> None:
        if not np.isfinite(runs.z).all() or runs.axes != 2:
            raise ValueError("runs: expected two axes and a measurement at every scan")
        self.model, self.z, self.R = model, np.ascontiguousarray(np.moveaxis(runs.z, 1, 0)), runs.sd**2
        self.T = np.ascontiguousarray(np.diff(runs.time, axis=1).T)
        self.centre, self.scale = np.asarray(model.centre), np.asarray(model.scale)

    def forward(self, values: Parameters) -> tuple[Array, Array, Array]:
        """Position, velocity (B, S, 2) and q (B, S)."""
        z, R, T = self.z, self.R, self.T[0]
        S, B, _ = z.shape
        p, v = z[1], (z[1] - z[0]) / T[:, None]
        P: Kernel = (np.full(B, R), R / T, 2 * R / T**2)
        q = np.full(B, self.model.start)
        position, velocity = np.full((2, B, S, 2), np.nan)
        noise = np.full((B, S), np.nan)
        self.scans: list[_Scan] = []
        for k in range(2, S):
            p, v, P, q = self._step(values, p, v, P, q, z[k], self.T[k - 1])
            position[:, k], velocity[:, k], noise[:, k] = p, v, q
        return position, velocity, noise

    def _step(
        self, values: Parameters, p: Array, v: Array, P: Kernel, q: Array, z: Array, T: Array
    ) -> tuple[Array, Array, Kernel, Array]:
        A0, A1 = P[0] + T * (2 * P[1] + T * P[2]), P[1] + T * P[2]
        p = p + T[:, None] * v
        r, T2 = z - p, T * T
        S_last = A0 + 0.25 * T2 * T2 * q + self.R
        u, nis = self._features(q, r, S_last)
        y, layers = forward(values, u)
        chosen, slope = _noise_of(self.model, y[:, 0])
        before, cross, last = A0 + 0.25 * T2 * T2 * chosen, A1 + 0.5 * T * T2 * chosen, P[2] + T2 * chosen
        S = before + self.R
        self.scans.append(_Scan(q, S_last, r, nis, layers, slope, S, before, cross))
        gain, across = before / S, cross / S
        p, v = p + gain[:, None] * r, v + across[:, None] * r
        return p, v, (self.R * gain, self.R * across, last - cross * across), chosen

    def _features(self, q: Array, r: Array, S: Array) -> tuple[Array, Array]:
        """The network's inputs (B, 3), scaled, and NIS (B, 2); as :meth:`NoiseNetwork.features` has them."""
        nis = r * r / S[:, None]
        u = np.empty((len(q), 3))
        if self.model.inputs == "log-nis":
            np.log(q, out=u[:, 0])
            np.log(nis + LEAST_NIS, out=u[:, 1:])
        else:
            u[:, 0] = q
            u[:, 1:] = np.exp(-0.5 * nis) / np.sqrt(2 * np.pi * S)[:, None]
        return (u - self.centre) / self.scale, nis

    def backward(self, values: Parameters, slope: Array, velocity_slope: Array | None = None) -> Parameters:
        """Slopes in the parameters from those in the positions and velocities (B, S, 2) of the last forward."""
        B, R = len(slope), self.R
        gp, gv = np.zeros((2, B, 2))
        gP0, gP1, gP2 = np.zeros((3, B))
        gq = np.zeros(B)
        answers = []
        for k in range(len(self.z) - 1, 1, -1):
            T, s = self.T[k - 1], self.scans[k - 2]
            T2 = T * T
            gp = gp + slope[:, k]
            if velocity_slope is not None:
                gv = gv + velocity_slope[:, k]
            # the update
            gain, across = s.before / s.S, s.cross / s.S
            g_gain = (gp * s.r).sum(axis=1) + R * gP0
            g_across = (gv * s.r).sum(axis=1) + R * gP1
            g_before = (g_gain - gain * g_gain - across * (g_across - s.cross * gP2)) / s.S
            g_cross = g_across / s.S - 2 * across * gP2
            g_r = gain[:, None] * gp + across[:, None] * gv
            g_chosen = gq + 0.25 * T2 * T2 * g_before + 0.5 * T * T2 * g_cross + T2 * gP2
            # the network and its features
            answers.append((g_chosen * s.slope)[:, None])
            g_u = slope_of_inputs(values, s.layers, answers[-1])
            gq, g_r_u, g_S_last = self._features_back(s, g_u / self.scale)
            gq = gq + 0.25 * T2 * T2 * g_S_last
            gA0 = g_before + g_S_last
            # the prediction
            gp = gp - g_r - g_r_u
            gv = gv + T[:, None] * gp
            gP0, gP1, gP2 = gA0, g_cross + 2 * T * gA0, gP2 + T * (g_cross + T * gA0)
        layers = [np.concatenate(each) for each in zip(*(s.layers for s in self.scans), strict=True)]
        return backward(values, layers, np.concatenate(answers[::-1]))[0]

    def _features_back(self, s: _Scan, g: Array) -> tuple[Array, Array, Array]:
        """Slopes in the last q, the residuals (B, 2) and S, from those in the features (B, 3)."""
        S, nis = s.S_last[:, None], s.nis
        if self.model.inputs == "log-nis":
            g_nis = g[:, 1:] / (nis + LEAST_NIS)
            return g[:, 0] / s.q, g_nis * 2 * s.r / S, (-g_nis * nis / S).sum(axis=1)
        likelihood = np.exp(-0.5 * nis) / np.sqrt(2 * np.pi * S)
        g_log = g[:, 1:] * likelihood
        return g[:, 0], -g_log * s.r / S, (0.5 * g_log * (nis - 1) / S).sum(axis=1)


def _noise_of(model: NoiseNetwork, y: Array) -> tuple[Array, Array]:
    """q and dq/dy."""
    if model.output == "variance":
        q = model.output_centre + model.output_scale * y
        inside = (q > model.least) & (q < model.most)
        return np.clip(q, model.least, model.most), np.where(inside, model.output_scale, 0.0)
    share = 0.5 * (1 + np.tanh(0.5 * y))
    span = np.log(model.most / model.least)
    q = model.least * np.exp(span * share)
    return q, q * span * share * (1 - share)
