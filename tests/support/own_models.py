"""jink's motion models and radar written again as a user would, in NumPy."""

from __future__ import annotations

import numpy as np


class Straight:
    """Constant velocity in two axes under white acceleration; written for arrays of dt."""

    name = "constant_velocity"

    def __init__(self, psd):
        self.psd = psd

    def f(self, x, dt):
        return (self.jacobian(x, dt) @ x[:, :, None])[:, :, 0]

    def jacobian(self, x, dt):
        F = np.tile(np.eye(4), (len(dt), 1, 1))
        F[:, 0, 1] = F[:, 2, 3] = dt
        return F

    def Q(self, dt):
        Q = np.zeros((len(dt), 4, 4))
        for p in (0, 2):
            Q[:, p, p], Q[:, p + 1, p + 1] = self.psd * dt**3 / 3, self.psd * dt
            Q[:, p, p + 1] = Q[:, p + 1, p] = self.psd * dt**2 / 2
        return Q

    def G(self, dt):
        G = np.zeros((len(dt), 4, 2))
        G[:, 0, 0] = G[:, 2, 1] = dt**2 / 2
        G[:, 1, 0] = G[:, 3, 1] = dt
        return G


class StraightOneStep:
    """The same written for one elapsed time, with the components in another order."""

    components = ("px", "py", "vx", "vy")
    name = "constant_velocity"

    def __init__(self, psd):
        self.psd = psd

    def F(self, dt):
        return np.block([[np.eye(2), dt * np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])

    def f(self, x, dt):
        return x @ self.F(dt).T

    def Q(self, dt):
        return self.psd * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(2))

    def jacobian(self, x, dt):
        return self.F(dt)


class Accelerating:
    """Constant acceleration in two axes with white jerk."""

    components = ("px", "vx", "ax", "py", "vy", "ay")
    name = "constant_acceleration"

    def __init__(self, psd, prior_sd):
        self.psd, self.prior_variance = psd, {"ax": prior_sd**2, "ay": prior_sd**2}

    def jacobian(self, x, dt):
        one = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
        return np.kron(np.eye(2), one)

    def f(self, x, dt):
        return x @ self.jacobian(x, dt).T

    def Q(self, dt):
        t = [dt, dt**2 / 2, dt**3 / 6, dt**3 / 3, dt**4 / 8, dt**5 / 20]
        return self.psd * np.kron(np.eye(2), [[t[5], t[4], t[2]], [t[4], t[3], t[1]], [t[2], t[1], t[0]]])

    def G(self, dt):
        return np.kron(np.eye(2), [[dt**2 / 2], [dt], [0.0]])


class Turning:
    """Coordinated turn with an unknown rate; the Jacobian is left to differences."""

    components = ("px", "vx", "py", "vy", "turn_rate")
    name = "coordinated_turn"

    def __init__(self, psd, rate_psd, rate_prior_sd):
        self.psd, self.rate_psd, self.prior_variance = psd, rate_psd, {"turn_rate": rate_prior_sd**2}

    def f(self, x, dt):
        px, vx, py, vy, w = x.T
        a = w * dt
        near = np.abs(a) < 1e-3  # by series, where the quotients cancel
        safe = np.where(near, 1.0, a)
        s = np.where(near, 1 - a**2 / 6 + a**4 / 120, np.sin(safe) / safe)
        c = np.where(near, a / 2 - a**3 / 24, (1 - np.cos(safe)) / safe)
        moved = px + dt * (s * vx - c * vy), np.cos(a) * vx - np.sin(a) * vy
        return np.stack([*moved, py + dt * (c * vx + s * vy), np.sin(a) * vx + np.cos(a) * vy, w], axis=1)

    def Q(self, dt):
        Q = np.zeros((len(dt), 5, 5))
        Q[:, :4, :4] = Straight(self.psd).Q(dt)
        Q[:, 4, 4] = self.rate_psd * dt
        return Q

    def G(self, dt):
        return np.concatenate([Straight(0.0).G(dt), np.zeros((len(dt), 1, 2))], axis=1)


class TurningExactly(Turning):
    """The same with its Jacobian."""

    def jacobian(self, x, dt):
        _, vx, _, vy, w = x.T
        a = w * dt
        near = np.abs(a) < 0.1
        safe = np.where(near, 1.0, a)
        sine, cosine = np.sin(a), np.cos(a)
        s, c = np.sin(safe) / safe, (1 - np.cos(safe)) / safe
        s_near = 1 - a**2 / 6 + a**4 / 120 - a**6 / 5040 + a**8 / 362880
        c_near = a / 2 - a**3 / 24 + a**5 / 720 - a**7 / 40320
        ds_near = -a / 3 + a**3 / 30 - a**5 / 840 + a**7 / 45360
        dc_near = 0.5 - a**2 / 8 + a**4 / 144 - a**6 / 5760 + a**8 / 403200
        ds, dc = np.where(near, ds_near, (cosine - s) / safe), np.where(near, dc_near, (sine - c) / safe)
        s, c = np.where(near, s_near, s), np.where(near, c_near, c)
        F = np.tile(np.eye(5), (len(x), 1, 1))
        F[:, 0, 1], F[:, 0, 3], F[:, 2, 1], F[:, 2, 3] = dt * s, -dt * c, dt * c, dt * s
        F[:, 1, 1], F[:, 1, 3], F[:, 3, 1], F[:, 3, 3] = cosine, -sine, sine, cosine
        F[:, 0, 4], F[:, 2, 4] = dt**2 * (ds * vx - dc * vy), dt**2 * (dc * vx + ds * vy)
        F[:, 1, 4], F[:, 3, 4] = -dt * (sine * vx + cosine * vy), dt * (cosine * vx - sine * vy)
        return F


class Radar:
    """Range and azimuth from a site."""

    state = ("px", "vx", "py", "vy")
    extent = (1e5, 2 * np.pi)
    axes = 2

    def __init__(self, range_sd, azimuth_sd, site):
        self.R, self.site = np.array([range_sd**2, azimuth_sd**2]), site

    def h(self, x):
        dx, dy = x[:, 0] - self.site[0], x[:, 2] - self.site[1]
        return np.stack([np.hypot(dx, dy), np.arctan2(dx, dy)], axis=1)

    def residual(self, z, h):
        y = z - h
        y[:, 1] = (y[:, 1] + np.pi) % (2 * np.pi) - np.pi
        return y


class RadarExactly(Radar):
    """The same with its Jacobian."""

    def jacobian(self, x):
        dx, dy = x[:, 0] - self.site[0], x[:, 2] - self.site[1]
        r = np.hypot(dx, dy)
        H = np.zeros((len(x), 2, 4))
        H[:, 0, 0], H[:, 0, 2], H[:, 1, 0], H[:, 1, 2] = dx / r, dy / r, dy / r**2, -dx / r**2
        return H


class Gauge:
    """Position in two axes; it can start tracks."""

    axes = 2
    state = ("px", "py")
    extent = (1e5, 1e5)

    def __init__(self, sd):
        self.R = np.eye(2) * sd**2

    def h(self, x):
        return x

    def jacobian(self, x):
        return np.eye(2)

    def position(self, z, R):
        return z, R
