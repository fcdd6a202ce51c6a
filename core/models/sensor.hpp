// Sensor models: what a state looks like to a sensor, h(x), and its Jacobian.
#pragma once

#include "number/elementary.hpp"
#include "number/matrix.hpp"

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
    double radius;            // polar: of the sphere that heights are above, touching the plane z = 0 at the origin; 0: the plane

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

// At the site itself azimuth and range rate are undefined. Their slopes are bounded as if the target were this far, in metres.
inline constexpr double nearest = 1e-6;

// How high a point is above that sphere: sqrt(x² + y² + (R + z)²) - R, written without the difference of two large numbers.
template <class T> JINK_INLINE T height_above(const SensorSpec &s, T x, T y, T z) {
    if (!(s.radius > 0.0)) return z;
    const T excess = x * x + y * y + z * (z + 2.0 * s.radius);
    return excess / (square_root(excess + s.radius * s.radius) + s.radius);
}

// The way back: z of a point at x, y that is so high.
template <class T> JINK_INLINE T below_height(const SensorSpec &s, T x, T y, T height) {
    if (!(s.radius > 0.0)) return height;
    const T excess = height * (height + 2.0 * s.radius) - x * x - y * y;
    return excess / (square_root(larger<T>(excess + s.radius * s.radius, splat<T>(0.0))) + s.radius);
}

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
    const T far = larger<T>(range, splat<T>(nearest));
    int r = 2;
    h[0] = range, h[1] = azimuth;
    if (s.vertical == Vertical::elevation) h[r++] = arc_tangent(dz, ground);
    if (s.vertical == Vertical::height && n > 2 * block + 1) h[r++] = height_above<T>(s, x[0], x[block], x[2 * block]);
    if (s.range_rate) {
        T closing = dx * x[1] + dy * x[block + 1];
        if (s.axes == 3 && n > 2 * block + 1) closing = closing + dz * x[2 * block + 1];
        h[r] = closing / far;
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
    const T tiny = splat<T>(nearest * nearest);
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
    if (s.vertical == Vertical::height) {
        T *row = H + n * r++;
        row[2 * block] = one;
        if (s.radius > 0.0) {  // the direction away from the sphere's centre
            const T px = x[0], py = x[block], up = x[2 * block] + s.radius;
            const T over = 1.0 / square_root(px * px + py * py + up * up);
            row[0] = px * over, row[block] = py * over, row[2 * block] = up * over;
        }
    }
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

// No position is farther from the origin, in metres, and none is less certain: squares of such numbers, over the shortest steps
// and the longest, stay within the range of numbers. The visible universe is 1e27 m across.
inline constexpr double farthest = 1e30;

// A position (and velocity, where measured) to start a track from, with the covariance of the position.
template <class T> struct Fix {
    Mask<T> position, velocity;    // which lanes have one
    T p[3], v[3], P[6], V[6];      // covariances packed; V only where the velocity was measured
};

// z of a slant range, azimuth and height: over a sphere the place decides it, and it decides the place.
template <class T> inline T sphere_under(const SensorSpec &s, const Measurement<T> &m, T sine, T cosine) {
    T z = m.z[2];
    if (!(s.radius > 0.0)) return z;
    const T east = s.from_north ? sine : cosine, north = s.from_north ? cosine : sine;
    for (int k = 0; k < 4; ++k) {  // each step is (range / radius)² closer
        const T dz = z - s.site[2], ground = square_root(larger<T>(m.z[0] * m.z[0] - dz * dz, splat<T>(0.0)));
        z = below_height<T>(s, ground * east + s.site[0], ground * north + s.site[1], m.z[2]);
    }
    return z;
}

// The measured position in Cartesian coordinates, without bias: the mean is divided by exp(-var/2) of each angle, the covariance
// conditioned on the measurement. Written along and across the measured azimuth with expm1, so that the squares of the range,
// which the covariance does not depend on in the first order, never meet.
// Longbin, Xiaoquan, Yizu, Kang & Bar-Shalom, IEEE Trans. AES-34(3), 1998.
template <class T> inline void unbiased_polar(const SensorSpec &s, const Measurement<T> &m, Fix<T> &fix) {
    const auto variance = [&](int r) { return m.full ? m.R[packed(r, r)] : m.R[r]; };
    const bool spatial = s.vertical == Vertical::elevation;
    T range = m.z[0], range_variance = variance(0), sheared = splat<T>(0.0), up_to = splat<T>(0.0);
    const T v = variance(1), w = spatial ? variance(2) : splat<T>(0.0);
    T sa, ca;
    sine_cosine(m.z[1], sa, ca);
    if (s.vertical == Vertical::height) {  // ground range from slant range and height; an error of the height shears it
        up_to = sphere_under(s, m, sa, ca);
        const T dz = up_to - s.site[2], ground2 = larger<T>(range * range - dz * dz, splat<T>(1.0));
        range_variance = (range * range * range_variance + dz * dz * variance(2)) / ground2;
        range = square_root(ground2);
        sheared = -(dz / range) * variance(2);
    }
    const T la = exponential<T>(-0.5 * v), a = 0.5 * exponential_less_one<T>(-2.0 * v), r2 = range * range;
    T se = splat<T>(0.0), ce = splat<T>(1.0), le = ce, b = se, rise = se, fallen = se, e2 = ce;  // of an elevation that is zero and exact
    if (spatial) {
        sine_cosine(m.z[2], se, ce);
        le = exponential<T>(-0.5 * w), e2 = exponential<T>(-2.0 * w);
        rise = exponential_less_one<T>(w), fallen = exponential_less_one<T>(-2.0 * w);
        b = 0.5 * fallen * (ce * ce - se * se);
    }
    const T level = ce * ce + b;
    const T along = r2 * (ce * ce * (exponential_less_one<T>(v + w) + a) + b * (1.0 + a)) + range_variance * (1.0 + a) * level;
    const T across = -((r2 + range_variance) * a * level);
    const T up = r2 * (rise * se * se - b) + range_variance * (se * se - b);
    const T slope = se * ce * (r2 * (rise / la + la * fallen) + range_variance * la * e2) + la * sheared;
    const int c = s.from_north ? 1 : 0, n = 1 - c;  // the axis the azimuth counts from, and the other
    const T half = range * ce / (la * le);
    fix.p[c] = half * ca + s.site[c], fix.p[n] = half * sa + s.site[n];
    fix.P[packed(c, c)] = along * ca * ca + across * sa * sa;
    fix.P[packed(n, n)] = along * sa * sa + across * ca * ca;
    fix.P[packed(1, 0)] = (along - across) * sa * ca;
    if (s.axes == 3) {
        fix.p[2] = spatial ? range * se / le + s.site[2] : up_to;
        fix.P[packed(2, c)] = slope * ca, fix.P[packed(2, n)] = slope * sa;
        fix.P[packed(2, 2)] = spatial ? up : variance(2);
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
        make_definite<T>(s.axes, fix.P);
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
    for (int a = 0; a < s.axes; ++a) {  // a comparison with NaN is false
        fix.position = fix.position & (magnitude(fix.p[a]) <= splat<T>(farthest)) & (fix.P[packed(a, a)] <= splat<T>(farthest * farthest));
        fix.velocity = fix.velocity & (magnitude(fix.v[a]) <= splat<T>(farthest)) & (fix.V[packed(a, a)] <= splat<T>(farthest * farthest));
    }
    return fix;
}

}  // namespace jink::inline JINK_LEVEL
