"""Sensors: z = h(position, velocity) + e, e ~ N(0, R). Azimuth is clockwise from +y (north): atan2(dx, dy).

Each sensor gives h, its Jacobian with respect to position and velocity, which components are angles, what
`kinds` they are of (p position, v velocity, a angle), and a position fix (for initialisation). `measured(z,
R)` is what the update works on: (z, R, sensor) of the equivalent measurement.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def wrap(angle):
    """The equal angle in [-pi, pi)."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


class Position:
    angles: tuple[int, ...] = ()

    def __init__(self, axes=2, sd=None, covariance=None):
        self.axes = self.m = axes
        self.kinds = "p" * axes
        if covariance is None:
            covariance = np.diag(np.broadcast_to(np.asarray(sd, float), (axes,)) ** 2)
        self.R = np.asarray(covariance, float)

    def h(self, position, velocity):
        return position[: self.axes].copy()

    def H(self, position, velocity):
        by_position = np.eye(self.axes, len(position))
        return by_position, np.zeros((self.axes, len(position)))

    def measured(self, z, R):
        return z, R, self

    def fix(self, z, R):
        return z[: self.axes], R[: self.axes, : self.axes]


class PositionVelocity:
    """z = [positions, velocities]."""

    angles: tuple[int, ...] = ()

    def __init__(self, axes=2, sd=None, velocity_sd=None):
        self.axes, self.m = axes, 2 * axes
        self.kinds = "p" * axes + "v" * axes
        sd = np.broadcast_to(np.asarray(sd, float), (axes,))
        velocity_sd = np.broadcast_to(np.asarray(velocity_sd, float), (axes,))
        self.R = np.diag(np.r_[sd, velocity_sd] ** 2)

    def h(self, position, velocity):
        return np.r_[position[: self.axes], velocity[: self.axes]]

    def H(self, position, velocity):
        unit, zero = np.eye(self.axes, len(position)), np.zeros((self.axes, len(position)))
        return np.vstack([unit, zero]), np.vstack([zero, unit])

    def measured(self, z, R):
        return z, R, self

    def fix(self, z, R):
        return z[: self.axes], R[: self.axes, : self.axes]


class Bearing:
    """Azimuth from a site."""

    angles = (0,)
    m = 1
    kinds = "a"

    def __init__(self, sd, site=(0.0, 0.0)):
        self.R = np.array([[float(sd) ** 2]])
        self.site = np.asarray(site, float)

    def h(self, position, velocity):
        dx, dy = position[:2] - self.site[:2]
        return np.array([np.arctan2(dx, dy)])

    def H(self, position, velocity):
        dx, dy = position[:2] - self.site[:2]
        by_position = np.zeros((1, len(position)))
        by_position[0, :2] = np.array([dy, -dx]) / (dx**2 + dy**2)
        return by_position, np.zeros((1, len(position)))

    def measured(self, z, R):
        return z, R, self

    def fix(self, z, R):
        return None


class Polar:
    """z = [range, azimuth, (elevation | height), (range rate)] from a site; range is the slant range in three
    axes.
    """

    angles: tuple[int, ...] = (1,)

    def __init__(
        self,
        range_sd,
        azimuth_sd,
        elevation_sd=None,
        height_sd=None,
        range_rate_sd=None,
        site=None,
        method="ekf",
        axes=None,
        earth_radius=None,
    ):
        self.radius = earth_radius
        self.third = "elevation" if elevation_sd is not None else "height" if height_sd is not None else None
        self.rate = range_rate_sd is not None
        third_sd = elevation_sd if elevation_sd is not None else height_sd
        sds = [s for s in (range_sd, azimuth_sd, third_sd, range_rate_sd) if s is not None]
        self.m = len(sds)
        self.R = np.diag(np.square(np.asarray(sds, float)))
        self.axes = axes or (3 if self.third else 2)
        self.site = np.zeros(3)
        if site is not None:
            self.site[: len(site)] = site
        self.method = method
        self.angles = (1, 2) if self.third == "elevation" else (1,)
        self.kinds = "pa" + {"elevation": "a", "height": "p", None: ""}[self.third] + "v" * self.rate

    def height(self, position):
        """Above the plane z = 0, or above a sphere that touches it at the origin."""
        if not self.radius:
            return position[2]
        return float(np.linalg.norm(np.longdouble(position) + np.array([0.0, 0.0, self.radius])) - self.radius)

    def relative(self, position):
        return position - self.site[: len(position)]

    def h(self, position, velocity):
        d = self.relative(position)
        r, ground = np.linalg.norm(d), np.hypot(d[0], d[1])
        z = [r, np.arctan2(d[0], d[1])]
        if self.third == "elevation":
            z.append(np.arctan2(d[2], ground))
        if self.third == "height":
            z.append(self.height(position))  # of the same frame as the state, not above the site
        if self.rate:
            z.append(d @ velocity / r)
        return np.array(z)

    def H(self, position, velocity):
        d = self.relative(position)
        n = len(d)
        r, ground2 = np.linalg.norm(d), d[0] ** 2 + d[1] ** 2
        azimuth = np.zeros(n)
        azimuth[:2] = np.array([d[1], -d[0]]) / ground2
        rows, zero = [d / r, azimuth], np.zeros(n)
        if self.third == "elevation":
            ground = np.sqrt(ground2)
            rows.append(np.array([-d[0] * d[2] / ground, -d[1] * d[2] / ground, ground]) / r**2)
        if self.third == "height":
            up = np.array([0.0, 0.0, self.radius or 1.0])
            away = position + up if self.radius else up
            rows.append(away / np.linalg.norm(away))
        by_velocity = [zero] * len(rows)
        if self.rate:
            rows.append(velocity / r - d * (d @ velocity) / r**3)
            by_velocity.append(d / r)
        return np.array(rows), np.array(by_velocity)

    def measured(self, z, R):
        if self.method == "ekf":
            return z, R, self
        position, covariance = self.fix(z, R)
        return position, covariance, Position(axes=len(position), covariance=covariance)

    def fix(self, z, R):
        """The unbiased converted position and its mean-square error given the measurement."""
        if self.third == "height":
            return self.fix_by_height(z, R)
        position, covariance = unbiased_conversion(z, R, elevation=self.third == "elevation")
        return position + self.site[: len(position)], covariance

    def fix_by_height(self, z, R):
        """Ground range g = sqrt(r^2 - h^2) to first order; its error and the height's are correlated."""
        up = self.z_of_height(z)
        h = up - self.site[2]
        g = np.sqrt(max(z[0] ** 2 - h**2, 1.0))
        by = np.array([z[0], -h]) / g  # dg/dr, dg/dh
        R_ground = np.diag([by[0] ** 2 * R[0, 0] + by[1] ** 2 * R[2, 2], R[1, 1]])
        level, P = unbiased_conversion(np.array([g, z[1]]), R_ground, elevation=False)
        covariance = np.zeros((3, 3))
        covariance[:2, :2], covariance[2, 2] = P, R[2, 2]
        direction = np.exp(-R[1, 1] / 2) * np.array([np.sin(z[1]), np.cos(z[1])])
        covariance[2, :2] = covariance[:2, 2] = by[1] * R[2, 2] * direction
        return np.r_[level + self.site[:2], up], covariance

    def z_of_height(self, z):
        """By bisection: of the points at this slant range and azimuth the one that is so high."""
        if not self.radius:
            return z[2]
        low, high = -z[0], z[0]
        for _ in range(200):
            up = (low + high) / 2
            ground = np.sqrt(max(z[0] ** 2 - up**2, 0.0))
            place = np.array([ground * np.sin(z[1]), ground * np.cos(z[1]), up]) + self.site
            low, high = (up, high) if self.height(place) < z[2] else (low, up)
        return up + self.site[2]


def unbiased_conversion(z: Array, R: Array, elevation: bool) -> tuple[Array, Array]:
    """Unbiased converted measurement (Longbin, Xiaoquan, Yizu, Kang, Bar-Shalom, IEEE T-AES 34(3), 1998).

    Position divided by lambda = exp(-sd^2/2) per angle: unbiased given the truth. Covariance: E[(x_u - x)(x_u
    - x)' | z], the truth x being the measurement less its noise: x_u x_u' - x_u E[x|z]' - E[x|z] x_u' + E[x
    x'|z]. In extended precision, since it takes r^2 from r^2 and leaves sd^2.
    """
    z, R = np.asarray(z, np.longdouble), np.asarray(R, np.longdouble)
    r, azimuth = z[0], z[1]
    rr = r**2 + R[0, 0]  # E[range^2 | z]
    a1, a2 = np.exp(-R[1, 1] / 2), np.exp(-2 * R[1, 1])
    s, c = np.sin(azimuth), np.cos(azimuth)  # x = r s, y = r c: azimuth from north
    ss, cc, sc = (
        (1 - a2 * np.cos(2 * azimuth)) / 2,
        (1 + a2 * np.cos(2 * azimuth)) / 2,
        a2 * np.sin(2 * azimuth) / 2,
    )
    if not elevation:
        mean = a1 * r * np.array([s, c])
        second = rr * np.array([[ss, sc], [sc, cc]])
        unbiased = r * np.array([s, c]) / a1
    else:
        e1, e2, e = np.exp(-R[2, 2] / 2), np.exp(-2 * R[2, 2]), z[2]
        level2, up2 = (1 + e2 * np.cos(2 * e)) / 2, (1 - e2 * np.cos(2 * e)) / 2
        level_up = e2 * np.sin(2 * e) / 2
        mean = e1 * r * np.array([a1 * s * np.cos(e), a1 * c * np.cos(e), np.sin(e)])
        second = rr * np.array(
            [
                [ss * level2, sc * level2, a1 * s * level_up],
                [sc * level2, cc * level2, a1 * c * level_up],
                [a1 * s * level_up, a1 * c * level_up, up2],
            ]
        )
        unbiased = r * np.array([s * np.cos(e) / a1, c * np.cos(e) / a1, np.sin(e)]) / e1
    outer = np.outer(unbiased, mean)
    covariance = np.outer(unbiased, unbiased) - outer - outer.T + second
    return unbiased.astype(float), covariance.astype(float)
