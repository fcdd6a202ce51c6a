// Sensor models: what a state looks like to a sensor, h(x), and its Jacobian.
#pragma once

#include "elementary.hpp"
#include "matrix.hpp"

namespace jink::inline JINK_LEVEL {

enum class SensorKind { position, position_velocity, bearing, polar };
enum class Vertical { none, elevation, height };

// What does not depend on the number type. Measurement columns: position (axes); position then velocity (2 axes);
// azimuth; range, azimuth, (elevation or height), (range rate).
struct SensorSpec {
    SensorKind kind;
    int axes, rows;           // of the state's axes, and measured components
    Vertical vertical;        // polar
    bool range_rate;          // polar
    bool from_north;          // azimuth clockwise from +y, else counter-clockwise from +x
    bool correlated;          // the measurement noise is a full matrix
    double site[3];

    bool linear() const { return kind == SensorKind::position || kind == SensorKind::position_velocity; }
    bool is_angle(int row) const {
        if (kind == SensorKind::bearing) return true;
        return kind == SensorKind::polar && (row == 1 || (row == 2 && vertical == Vertical::elevation));
    }
};

// One scan's measurement of a pack. R is the noise: variances, or a packed covariance if `full`.
template <class T> struct Measurement {
    T z[largest_measurement];
    Mask<T> present[largest_measurement];
    T R[packed_size(largest_measurement)];
    bool full;
};

// h(x) for a state whose axes are `block` components apart.
template <class T> JINK_INLINE void observe(const SensorSpec &s, int block, int n, const T *x, T *h) {
    if (s.linear()) {
        for (int r = 0; r < s.rows; ++r) h[r] = x[(r % s.axes) * block + r / s.axes];
        return;
    }
    if (n < 2 * block) return;  // such a sensor needs two axes
    const T dx = x[0] - s.site[0], dy = x[block] - s.site[1];
    const T azimuth = s.from_north ? arc_tangent(dx, dy) : arc_tangent(dy, dx);
    if (s.kind == SensorKind::bearing) {
        h[0] = azimuth;
        return;
    }
    const T dz = s.axes == 3 && n > 2 * block + 1 ? x[2 * block] - s.site[2] : splat<T>(0.0);
    const T ground = square_root(dx * dx + dy * dy), range = square_root(dx * dx + dy * dy + dz * dz);
    int r = 2;
    h[0] = range, h[1] = azimuth;
    if (s.vertical == Vertical::elevation) h[r++] = arc_tangent(dz, ground);
    if (s.vertical == Vertical::height && n > 2 * block + 1) h[r++] = x[2 * block];
    if (s.range_rate) {
        T closing = dx * x[1] + dy * x[block + 1];
        if (s.axes == 3 && n > 2 * block + 1) closing = closing + dz * x[2 * block + 1];
        h[r] = closing / range;
    }
}

// H = dh/dx, row by row, n columns each.
template <class T> JINK_INLINE void observe_jacobian(const SensorSpec &s, int block, int n, const T *x, T *H) {
    const T zero = splat<T>(0.0), one = splat<T>(1.0);
    for (int k = 0; k < s.rows * n; ++k) H[k] = zero;
    if (s.linear()) {
        for (int r = 0; r < s.rows; ++r) H[r * n + (r % s.axes) * block + r / s.axes] = one;
        return;
    }
    if (n < 2 * block) return;
    const T dx = x[0] - s.site[0], dy = x[block] - s.site[1];
    const T tiny = splat<T>(1e-12);  // overhead the azimuth is undefined: its slope is bounded there
    const T ground2 = larger<T>(dx * dx + dy * dy, tiny), ground = square_root(ground2);
    const T sign = splat<T>(s.from_north ? 1.0 : -1.0);
    T *azimuth = s.kind == SensorKind::bearing ? H : H + n;
    azimuth[0] = sign * dy / ground2, azimuth[block] = -(sign * dx / ground2);
    if (s.kind == SensorKind::bearing) return;
    const T dz = s.axes == 3 && n > 2 * block + 1 ? x[2 * block] - s.site[2] : zero;
    const T range2 = larger<T>(ground2 + dz * dz, tiny), range = square_root(range2);
    const T unit[3] = {dx / range, dy / range, dz / range};
    for (int a = 0; a < s.axes; ++a) H[a * block] = unit[a];
    int r = 2;
    if (s.vertical == Vertical::elevation) {
        T *row = H + n * r++;
        row[0] = -(dx * dz) / (ground * range2), row[block] = -(dy * dz) / (ground * range2), row[2 * block] = ground / range2;
    }
    if (s.vertical == Vertical::height) H[n * r++ + 2 * block] = one;
    if (s.range_rate) {
        T *row = H + n * r;
        T rate = zero;
        for (int a = 0; a < s.axes; ++a) rate = rate + unit[a] * x[a * block + 1];
        for (int a = 0; a < s.axes; ++a) {
            row[a * block] = (x[a * block + 1] - rate * unit[a]) / range;
            row[a * block + 1] = unit[a];
        }
    }
}

// z - h, angles to the nearest turn.
template <class T> inline void residual(const SensorSpec &s, const T *z, const T *h, T *y) {
    for (int r = 0; r < s.rows; ++r) y[r] = s.is_angle(r) ? wrapped<T>(z[r] - h[r]) : z[r] - h[r];
}

// A position (and velocity, where measured) to start a track from, with the covariance of the position.
template <class T> struct Fix {
    Mask<T> position, velocity;    // which lanes have one
    T p[3], v[3], P[6], V[6];      // covariances packed; V only where the velocity was measured
};

// The measured position in Cartesian coordinates. Polar measurements by the unbiased conversion: the mean is divided by
// exp(-var/2) of each angle and the covariance conditioned on the measurement.
// Longbin, Xiaoquan, Yizu, Kang & Bar-Shalom, IEEE Trans. AES-34(3), 1998.
template <class T> inline void unbiased_polar(const SensorSpec &s, const Measurement<T> &m, Fix<T> &fix) {
    const auto variance = [&](int r) { return m.full ? m.R[packed(r, r)] : m.R[r]; };
    const bool spatial = s.vertical == Vertical::elevation;
    T range = m.z[0], range_variance = variance(0);
    const T azimuth_variance = variance(1);
    if (s.vertical == Vertical::height) {  // ground range from slant range and height
        const T dz = m.z[2] - s.site[2], ground2 = larger<T>(range * range - dz * dz, splat<T>(1.0));
        range_variance = (range * range * range_variance + dz * dz * variance(2)) / ground2;
        range = square_root(ground2);
    }
    const T elevation = spatial ? m.z[2] : splat<T>(0.0), elevation_variance = spatial ? variance(2) : splat<T>(0.0);
    T sa, ca, se, ce;
    sine_cosine(m.z[1], sa, ca);
    sine_cosine(elevation, se, ce);
    const T la = exponential<T>(-0.5 * azimuth_variance), le = exponential<T>(-0.5 * elevation_variance);
    const T la4 = la * la * la * la, le4 = le * le * le * le;
    const T square = range * range + range_variance, r2 = range * range;
    const T c2a = ca * ca - sa * sa, s2a = 2.0 * sa * ca, c2e = ce * ce - se * se, s2e = 2.0 * se * ce;
    // E[cos^2 e] and so on, given the measured elevation; in two dimensions le = 1, ce = 1, se = 0
    const T cos2 = 0.5 * (1.0 + le4 * c2e), sin2 = 0.5 * (1.0 - le4 * c2e);
    const T bias = 1.0 / (la * le);
    const T east2 = 0.5 * (1.0 + la4 * c2a), north2 = 0.5 * (1.0 - la4 * c2a), cross = 0.5 * la4 * s2a;
    const T half = range * ce;
    // components along the azimuth's reference (c) and a quarter turn on (s)
    const T pc = bias * half * ca, ps = bias * half * sa, pz = range * se / le;
    const T over2 = bias * bias - 2.0;
    const T Pcc = over2 * (half * ca) * (half * ca) + square * east2 * cos2;
    const T Pss = over2 * (half * sa) * (half * sa) + square * north2 * cos2;
    const T Pcs = over2 * (half * ca) * (half * sa) + square * cross * cos2;
    const T Pzz = (1.0 / (le * le) - 2.0) * (r2 * se * se) + square * sin2;
    const T vertical = 0.5 * square * la * le4 * s2e + r2 * se * ce * (bias / le - 1.0 / la - la);
    const int c = s.from_north ? 1 : 0, n = 1 - c;
    fix.p[c] = pc + s.site[c], fix.p[n] = ps + s.site[n];
    fix.P[packed(c, c)] = Pcc, fix.P[packed(n, n)] = Pss, fix.P[packed(1, 0)] = Pcs;
    if (s.axes == 3) {
        fix.P[packed(2, c)] = ca * vertical, fix.P[packed(2, n)] = sa * vertical;
        fix.p[2] = spatial ? pz + s.site[2] : m.z[2];
        fix.P[packed(2, 2)] = spatial ? Pzz : variance(2);
    }
}

template <class T> inline Fix<T> position_fix(const SensorSpec &s, const Measurement<T> &m) {
    Fix<T> fix;
    const T zero = splat<T>(0.0);
    for (int k = 0; k < 6; ++k) fix.P[k] = fix.V[k] = zero;
    for (int a = 0; a < 3; ++a) fix.p[a] = fix.v[a] = zero;
    fix.position = splat_mask<T>(s.kind != SensorKind::bearing);
    fix.velocity = splat_mask<T>(s.kind == SensorKind::position_velocity);
    if (s.kind == SensorKind::polar) {
        const int needed = s.vertical == Vertical::none ? 2 : 3;
        if (s.axes == 3 && needed == 2) fix.position = splat_mask<T>(false);
        for (int r = 0; r < needed; ++r) fix.position = fix.position & m.present[r];
        unbiased_polar(s, m, fix);
    } else if (s.linear()) {
        for (int a = 0; a < s.axes; ++a) {
            fix.position = fix.position & m.present[a];
            fix.p[a] = m.z[a];
            for (int b = 0; b <= a; ++b)
                fix.P[packed(a, b)] = m.full ? m.R[packed(a, b)] : (a == b ? m.R[a] : zero);
        }
        if (s.kind == SensorKind::position_velocity)
            for (int a = 0; a < s.axes; ++a) {
                const int r = s.axes + a;
                fix.velocity = fix.velocity & m.present[r];
                fix.v[a] = m.z[r];
                for (int b = 0; b <= a; ++b)
                    fix.V[packed(a, b)] = m.full ? m.R[packed(r, s.axes + b)] : (a == b ? m.R[r] : zero);
            }
    }
    return fix;
}

}  // namespace jink::inline JINK_LEVEL
