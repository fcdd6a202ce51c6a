"""NNVSMM's Kalman filter in NumPy, with its derivative: the process noise of every scan chosen by a network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..noise_network import LEAST_NIS, NoiseNetwork
from .data import Runs
from .mlp import Parameters, backward, forward, parameters_of

Kernel = tuple[Array, Array, Array]  # P00 P01 P11 (B,), the same along every axis


@dataclass
class _Scan:
    """What one scan's derivative needs."""

    A: Kernel  # F P Fᵀ
    q: Array
    chosen: Array
    S_last: Array
    r: Array
    u: Array
    layers: list[Array]
    slope: Array  # dq/dy
    S: Array
    before: Array  # P⁻00
    cross: Array  # P⁻01


class Rollout:
    """Both axes' constant-velocity filters (T the time between scans, two-point start) under a network's noise.

    forward gives the estimates of position (B, S, 2), NaN before the third scan, velocities and the chosen q (B, S); backward
    turns the loss's slope in the positions into slopes in the network's parameters, through the whole track: what the
    noise of one scan does to all later ones counts. Every run must be measured at every scan.
    """

    def __init__(self, model: NoiseNetwork, runs: Runs) -> None:
        if not np.isfinite(runs.z).all() or runs.axes != 2:
            raise ValueError("runs: expected two axes and a measurement at every scan")
        self.model, self.z, self.R = model, runs.z, runs.sd**2
        self.T = np.diff(runs.time, axis=1)

    def forward(self, values: Parameters) -> tuple[Array, Array, Array]:
        """Position, velocity (B, S, 2) and q (B, S)."""
        z, R, T = self.z, self.R, self.T[:, 0]
        B, S, _ = z.shape
        p, v = z[:, 1], (z[:, 1] - z[:, 0]) / T[:, None]
        P: Kernel = (np.full(B, R), R / T, 2 * R / T**2)
        q = np.full(B, self.model.start)
        position, velocity = np.full((2, B, S, 2), np.nan)
        noise = np.full((B, S), np.nan)
        self.scans: list[_Scan] = []
        for k in range(2, S):
            p, v, P, q = self._step(values, p, v, P, q, z[:, k], self.T[:, k - 1])
            position[:, k], velocity[:, k], noise[:, k] = p, v, q
        return position, velocity, noise

    def _step(
        self, values: Parameters, p: Array, v: Array, P: Kernel, q: Array, z: Array, T: Array
    ) -> tuple[Array, Array, Kernel, Array]:
        m = self.model
        p = p + T[:, None] * v
        A = (P[0] + T * (2 * P[1] + T * P[2]), P[1] + T * P[2], P[2])
        r = z - p
        S_last = A[0] + T**4 / 4 * q + self.R
        u = (m.features(q, r, np.column_stack([S_last, S_last])) - np.asarray(m.centre)) / np.asarray(m.scale)
        y, layers = forward(values, u)
        chosen, slope = _noise_of(m, y[:, 0])
        before, cross, last = A[0] + T**4 / 4 * chosen, A[1] + T**3 / 2 * chosen, A[2] + T**2 * chosen
        S = before + self.R
        self.scans.append(_Scan(A, q, chosen, S_last, r, u, layers, slope, S, before, cross))
        p, v = p + (before / S)[:, None] * r, v + (cross / S)[:, None] * r
        return p, v, (self.R * before / S, self.R * cross / S, last - cross**2 / S), chosen

    def backward(self, values: Parameters, slope: Array) -> Parameters:
        """Slopes in the parameters from those in the positions (B, S, 2) of the last forward."""
        B = len(slope)
        gradients = [np.zeros_like(value) for value in values]
        gp, gv = np.zeros((2, B, 2))
        gP = [np.zeros(B) for _ in range(3)]
        gq = np.zeros(B)
        for k in range(self.z.shape[1] - 1, 1, -1):
            T, s = self.T[:, k - 1], self.scans[k - 2]
            gp = gp + slope[:, k]
            # the update
            along, across = (gp * s.r).sum(axis=1), (gv * s.r).sum(axis=1)
            g_before = (along + self.R * gP[0]) / s.S
            g_cross = (across + self.R * gP[1] - 2 * s.cross * gP[2]) / s.S
            g_S = (
                -(s.before * (along + self.R * gP[0]) + s.cross * (across + self.R * gP[1]))
                + s.cross**2 * gP[2]
            ) / s.S**2
            g_r = (s.before / s.S)[:, None] * gp + (s.cross / s.S)[:, None] * gv
            g_before = g_before + g_S
            g_chosen = gq + T**4 / 4 * g_before + T**3 / 2 * g_cross + T**2 * gP[2]
            gA = [g_before, g_cross, gP[2]]
            # the network and its features
            parameters, g_u = backward(values, s.layers, (g_chosen * s.slope)[:, None])
            for total, part in zip(gradients, parameters, strict=True):
                total += part
            gq, g_r_u, g_S_last = self._features_back(s, g_u / np.asarray(self.model.scale))
            g_r = g_r + g_r_u
            gq = gq + T**4 / 4 * g_S_last
            gA[0] = gA[0] + g_S_last
            # the prediction
            gp = gp - g_r
            gv = gv + T[:, None] * gp
            gP = [gA[0], gA[1] + 2 * T * gA[0], gA[2] + T * (gA[1] + T * gA[0])]
        return gradients

    def _features_back(self, s: _Scan, g: Array) -> tuple[Array, Array, Array]:
        """Slopes in the last q, the residuals (B, 2) and S, from those in the features (B, 3)."""
        S = s.S_last[:, None]
        nis = s.r**2 / S
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


def tracked(model: NoiseNetwork, runs: Runs) -> tuple[Array, Array, Array]:
    """Position, velocity (B, S, 2) and q (B, S) of NNVSMM on runs, NaN before the third scan."""
    return Rollout(model, runs).forward(parameters_of(model.network))


def position_rms(model: NoiseNetwork, runs: Runs, first: int = 2) -> float:
    """RMS of the distance (m) between estimate and truth over the runs and the scans from index ``first``."""
    error = tracked(model, runs)[0][:, first:] - runs.position[:, first:]
    return float(np.sqrt((error**2).sum(axis=2).mean()))
