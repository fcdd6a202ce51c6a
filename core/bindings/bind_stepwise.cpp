// The Python face of stepwise.hpp: every function takes and gives arrays over a batch of tracks.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "run/stepwise.hpp"
#include "scan/composition.hpp"
#include "scan/transition.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace jink;

namespace {

using In = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using InMask = nb::ndarray<const bool, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<nb::numpy, double>;
using Vector = std::vector<double>;

// A new array for Python, and its data.
struct Result {
    double *data;
    Out array;
    template <class... Sizes> explicit Result(Sizes... sizes) {
        const std::size_t shape[] = {std::size_t(sizes)...};
        std::size_t total = 1;
        for (auto s : shape) total *= s;
        data = new double[total ? total : 1];
        array = Out(data, sizeof...(Sizes), shape, nb::capsule(data, [](void *p) noexcept { delete[] static_cast<double *>(p); }));
    }
    template <class... Sizes> explicit Result(const In &from, Sizes... sizes) : Result(sizes...) {
        std::copy(from.data(), from.data() + from.size(), data);
    }
};

void expect(bool right, const char *what) {
    if (!right) throw nb::value_error(what);
}

nb::tuple mix_tracks(const std::vector<In> &x, const std::vector<In> &P, In w) {
    const int modes = int(x.size()), tracks = int(w.shape(0)), n = int(x[0].shape(1));
    expect(int(w.shape(1)) == modes && int(P.size()) == modes, "mix: as many means as covariances and weights");
    for (int i = 0; i < modes; ++i)
        expect(x[i].size() == std::size_t(tracks) * n && P[i].size() == x[i].size() * n, "mix: x (B, n) and P (B, n, n) of each mode");
    Result x0(tracks, n), P0(tracks, n, n);
    std::vector<const double *> xs(modes), Ps(modes);
    for (int b = 0; b < tracks; ++b) {
        for (int i = 0; i < modes; ++i) xs[i] = x[i].data() + b * n, Ps[i] = P[i].data() + b * n * n;
        mix_estimates(modes, n, xs.data(), Ps.data(), w.data() + b * modes, x0.data + b * n, P0.data + b * n * n);
    }
    return nb::make_tuple(x0.array, P0.array);
}

nb::tuple update(In x, In P, In y, In H, In R, InMask present) {
    const int tracks = int(x.shape(0)), n = int(x.shape(1)), m = int(y.shape(1));
    expect(n <= largest_own && m <= largest_own, "update: too many components");
    expect(int(P.size()) == tracks * n * n && int(H.size()) == tracks * m * n && int(R.size()) == tracks * m * m &&
               int(y.size()) == tracks * m && int(present.size()) == tracks * m, "update: shapes do not fit");
    Result x1(x, tracks, n), P1(P, tracks, n, n), nis(tracks), det(tracks), e(tracks, m), S(tracks, m), joint(tracks, m, m);
    Vector own_y(y.data(), y.data() + y.size()), own_H(H.data(), H.data() + H.size()), own_R(R.data(), R.data() + R.size());
    for (int b = 0; b < tracks; ++b) {
        OwnInnovation v{0.0, 1.0, e.data + b * m, S.data + b * m, joint.data + b * m * m};
        update_own(n, m, present.data() + b * m, &own_y[b * m], &own_H[b * m * n], &own_R[b * m * m], x1.data + b * n, P1.data + b * n * n, v);
        nis.data[b] = v.nis, det.data[b] = v.det;
    }
    return nb::make_tuple(x1.array, P1.array, nis.array, det.array, e.array, S.array, joint.array);
}

Out root(In P, bool semidefinite, double least) {
    const int tracks = int(P.shape(0)), n = int(P.shape(1));
    Result L(tracks, n, n);
    for (int b = 0; b < tracks; ++b) root_of(n, P.data() + b * n * n, semidefinite, least, L.data + b * n * n);
    return L.array;
}

Out solve(In L, In X, bool transposed) {
    const int tracks = int(L.shape(0)), n = int(L.shape(1)), k = int(X.shape(2));
    expect(int(X.size()) == tracks * n * k, "solve: shapes do not fit");
    Result out(X, tracks, n, k);
    for (int b = 0; b < tracks; ++b) solve_own(n, k, L.data() + b * n * n, transposed, out.data + b * n * k);
    return out.array;
}

// x-, F and Q of one of the library's motion models.
nb::tuple linearise_motion(const ModeDeclaration &mode, bool unscented, In dt, In x, In P, nb::object input) {
    const MotionSpec &spec = mode.motion;
    const MotionKernels<double> kernels = motion_kernels<double>(spec, unscented);
    const int tracks = int(x.shape(0)), n = int(x.shape(1));
    expect(n == mode.shape.n && int(dt.size()) == tracks && int(P.size()) == tracks * n * n, "linearise_motion: shapes do not fit");
    In known;
    if (!input.is_none()) known = nb::cast<In>(input);
    Result ahead(tracks, n), F(tracks, n, n), Q(tracks, n, n);
    double c[largest_coefficients], in[largest_state + packed_size(largest_state)], q[packed_size(largest_state)];
    for (int b = 0; b < tracks; ++b) {
        std::copy(x.data() + b * n, x.data() + (b + 1) * n, in);
        for (int r = 0; r < n; ++r)
            for (int k = 0; k <= r; ++k) in[n + packed(r, k)] = P.data()[(b * n + r) * n + k];
        if (b == 0 || dt.data()[b] != dt.data()[b - 1]) kernels.prepare(spec, dt.data()[b], mode.parameters.data(), c);
        const double *u = input.is_none() ? nullptr : known.data() + b * spec.axes;
        kernels.linearise(in, c, u, ahead.data + b * n, F.data + b * n * n, q);
        for (int r = 0; r < n; ++r)
            for (int k = 0; k < n; ++k) Q.data[(b * n + r) * n + k] = q[packed(r, k)];
    }
    return nb::make_tuple(ahead.array, F.array, Q.array);
}

// h(x) and its Jacobian of one of the library's sensors, for states of position and velocity per axis.
nb::tuple observe_sensor(const SensorDeclaration &sensor, In x) {
    const SensorSpec &spec = sensor.spec;
    const int tracks = int(x.shape(0)), n = int(x.shape(1));
    expect(n == 2 * spec.axes, "observe_sensor: x holds position and velocity per axis");
    Result h(tracks, spec.rows), H(tracks, spec.rows, n);
    for (int b = 0; b < tracks; ++b) {
        observe(spec, 2, n, x.data() + b * n, h.data + b * spec.rows);
        observe_jacobian(spec, 2, n, x.data() + b * n, H.data + b * spec.rows * n);
    }
    return nb::make_tuple(h.array, H.array);
}

// The position (and velocity) a track starts from: found, velocity found (1 or 0), p, v, their covariances.
nb::tuple position_of(const SensorDeclaration &sensor, In z, In R, InMask present) {
    const SensorSpec &spec = sensor.spec;
    const int tracks = int(z.shape(0)), m = spec.rows, axes = spec.axes;
    expect(int(z.shape(1)) == m && int(R.size()) == tracks * m * m && int(present.size()) == tracks * m, "position_of: shapes do not fit");
    Result found(tracks), moving(tracks), p(tracks, axes), v(tracks, axes), P(tracks, axes, axes), V(tracks, axes, axes);
    for (int b = 0; b < tracks; ++b) {
        Measurement<double> one;
        one.full = true;
        for (int r = 0; r < m; ++r) {
            one.z[r] = z.data()[b * m + r], one.present[r] = present.data()[b * m + r];
            for (int q = 0; q <= r; ++q) one.R[packed(r, q)] = R.data()[(b * m + r) * m + q];
        }
        const Fix<double> fix = position_fix(spec, one);
        found.data[b] = fix.position, moving.data[b] = fix.velocity;
        for (int a = 0; a < axes; ++a) {
            p.data[b * axes + a] = fix.p[a], v.data[b * axes + a] = fix.v[a];
            for (int k = 0; k < axes; ++k) {
                P.data[(b * axes + a) * axes + k] = fix.P[packed(a, k)];
                V.data[(b * axes + a) * axes + k] = fix.V[packed(a, k)];
            }
        }
    }
    return nb::make_tuple(found.array, moving.array, p.array, v.array, P.array, V.array);
}

Out transition_over(bool continuous, const Vector &matrix, int modes, In dt) {
    const Transition<double> transition(modes, continuous, matrix);
    const int tracks = int(dt.size());
    Result pi(tracks, modes, modes);
    Vector scratch(modes * modes);
    for (int b = 0; b < tracks; ++b) {
        double *to = pi.data + b * modes * modes;
        if (b && dt.data()[b] == dt.data()[b - 1]) std::copy(to - modes * modes, to, to);
        else transition.over(dt.data()[b], to, scratch.data());
    }
    return pi.array;
}

}  // namespace

void bind_stepwise(nb::module_ &module) {
    module.attr("largest_own") = largest_own;
    module.def("mix", mix_tracks, "x"_a, "P"_a, "w"_a);
    module.def("update", update, "x"_a, "P"_a, "y"_a, "H"_a, "R"_a, "present"_a);
    module.def("root", root, "P"_a, "semidefinite"_a = false, "least"_a = 1e-300);
    module.def("solve", solve, "L"_a, "X"_a, "transposed"_a = false);
    module.def("linearise_motion", linearise_motion, "motion"_a, "unscented"_a, "dt"_a, "x"_a, "P"_a, "input"_a.none());
    module.def("observe_sensor", observe_sensor, "sensor"_a, "x"_a);
    module.def("position_of", position_of, "sensor"_a, "z"_a, "R"_a, "present"_a);
    module.def("transition_over", transition_over, "continuous"_a, "matrix"_a, "modes"_a, "dt"_a);
}
