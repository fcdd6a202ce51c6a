// Input estimation: from the innovations of a filter that knows of no manoeuvre, the constant acceleration that explains them.
//
// For each scan of the last W at which a manoeuvre may have begun: how the estimate depends on the acceleration since, M (n x axes),
// and what the innovations say of it, Y = sum Psi' S^-1 Psi and y = sum Psi' S^-1 nu, with Psi = H (F M + G) and M <- (I - K H)(F M + G).
// Where the likeliest onset's y' Y^-1 y exceeds the threshold, u = Y^-1 y is taken: x += M u, P += M Y^-1 M', and the watch starts anew.
// Chan, Hu & Plant, IEEE Trans. AES-15(2), 1979; over all onsets of a window: Bogler, IEEE Trans. AES-23(3), 1987.
#pragma once

#include "scan/propagate.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class InputEstimation {
  public:
    explicit InputEstimation(const Composition<T> &composition) : c(composition), window(c.declared.detect.window) {}
    bool active() const { return window > 0; }

    // After an update: `taken` lanes had one. The estimate in the track's arena is corrected where a manoeuvre is found.
    void operator()(TrackState<T> &s, const Propagate<T> &ahead, const SensorSpec &spec, const Measurement<T> &m, const Innovation<T> &v,
                    Mask<T> taken) const {
        const bool short_one = spec.rows == c.declared.axes();
        switch (c.declared.axes()) {
            case 1: return short_one ? watch<1, 1>(s, ahead, spec, m, v, taken) : watch<1, largest_measurement>(s, ahead, spec, m, v, taken);
            case 2: return short_one ? watch<2, 2>(s, ahead, spec, m, v, taken) : watch<2, largest_measurement>(s, ahead, spec, m, v, taken);
            default: return short_one ? watch<3, 3>(s, ahead, spec, m, v, taken) : watch<3, largest_measurement>(s, ahead, spec, m, v, taken);
        }
    }

  private:
    const Composition<T> &c;
    int window;

    // An onset in the track's memory: whether it is one, M (n by A), Y packed, y.
    template <int A> struct Onset {
        static constexpr int n = 2 * A, M = 1, Y = M + n * A, y = Y + packed_size(A), size = y + A;
    };

    // The update just made, the same for all onsets; rows that the sensor has not are zero.
    template <int A, int Rows> struct Update {
        static constexpr int n = 2 * A;
        T H[Rows * n], K[n * Rows], root[packed_size(Rows)], over[Rows], nu[Rows];  // S = root root', over = 1 / its diagonal

        Update(const SensorSpec &spec, const Measurement<T> &m, const Innovation<T> &v, const T *x, const T *P, Mask<T> taken) {
            const T zero = splat<T>(0.0);
            for (T &value : H) value = zero;
            for (T &value : root) value = zero;
            for (int r = 0; r < Rows; ++r) root[packed(r, r)] = over[r] = splat<T>(1.0), nu[r] = zero;
            observe_jacobian(spec, 2, n, x, H);
            cholesky<T>(spec.rows, v.joint, root);
            for (int r = 0; r < spec.rows; ++r) {
                for (int k = 0; k < n; ++k) H[r * n + k] = select<T>(m.present[r] & taken, H[r * n + k], zero);
                over[r] = reciprocal(root[packed(r, r)]), nu[r] = v.y[r];
            }
            for (int i = 0; i < n; ++i) gain(P, i);
            whiten(nu);
        }

        JINK_INLINE void whiten(T *y) const {  // root^-1 y
            JINK_UNROLL
            for (int r = 0; r < Rows; ++r) {
                JINK_UNROLL
                for (int k = 0; k < r; ++k) y[r] = y[r] - root[packed(r, k)] * y[k];
                y[r] = y[r] * over[r];
            }
        }

        void gain(const T *P, int i) {  // row i of K = P- H' S^-1
            T *row = &K[i * Rows];
            for (int r = 0; r < Rows; ++r) {
                row[r] = splat<T>(0.0);
                for (int k = 0; k < n; ++k) row[r] = row[r] + P[packed(i, k)] * H[r * n + k];
            }
            whiten(row);
            for (int r = Rows - 1; r >= 0; --r) {
                for (int k = r + 1; k < Rows; ++k) row[r] = row[r] - root[packed(k, r)] * row[k];
                row[r] = row[r] * over[r];
            }
        }
    };

    template <int A, int Rows>
    void watch(TrackState<T> &s, const Propagate<T> &ahead, const SensorSpec &spec, const Measurement<T> &m, const Innovation<T> &v,
               Mask<T> taken) const {
        using O = Onset<A>;
        const Mode<T> &mode = c.modes[0];
        const T zero = splat<T>(0.0), *dt = ahead.coefficient(0);  // and dt^2 / 2: the motion is one of constant velocity
        const T *x = &ahead.predicted[mode.place];
        const Update<A, Rows> update(spec, m, v, x, x + O::n, taken);
        T best = zero, which = zero, none[O::size];
        for (T &value : none) value = zero;
        none[0] = select<T>(s.running, splat<T>(1.0), zero);
        for (int e = window - 1; e >= 0; --e) {  // each a scan older; the youngest begins with the step just made
            T *at = &s.memory[e * O::size];
            advance<A, Rows>(e ? at - O::size : none, dt, update, at);
            if (e + 1 < c.declared.detect.shortest) continue;
            const T significance = select<T>(at[0] > zero, strength<A>(at), zero);
            // of onsets that explain the innovations equally well (one innovation does not tell them apart) the oldest
            const Mask<T> better = taken & (significance > best * (1.0 + 1e-9));
            best = select<T>(better, significance, best), which = select<T>(better, splat<T>(e), which);
        }
        const Mask<T> found = taken & (best > splat<T>(c.declared.detect.threshold));
        if (!any(found)) return;
        T chosen[O::size];
        for (int k = 0; k < O::size; ++k) {
            chosen[k] = s.memory[k];
            for (int e = 1; e < window; ++e) chosen[k] = select<T>(which == splat<T>(e), s.memory[e * O::size + k], chosen[k]);
        }
        correct<A>(chosen, found, &s.arena[mode.place]);
        for (auto &value : s.memory) value = select<T>(found, zero, value);
    }

    // M <- (I - K H)(F M + G), psi = H (F M + G) and nu whitened, Y += psi' psi, y += psi' nu.
    template <int A, int Rows> void advance(const T *from, const T *dt, const Update<A, Rows> &update, T *to) const {
        using O = Onset<A>;
        constexpr int n = O::n;
        T psi[A][Rows];
        to[0] = from[0];
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            T moved[n];
            JINK_UNROLL
            for (int i = 0; i < n; i += 2) {
                const T *M = from + O::M + i * A + a;
                moved[i] = M[0] + dt[0] * M[A], moved[i + 1] = M[A];
                if (i == 2 * a) moved[i] = moved[i] + dt[1], moved[i + 1] = moved[i + 1] + dt[0];
            }
            JINK_UNROLL
            for (int r = 0; r < Rows; ++r) {
                psi[a][r] = update.H[r * n] * moved[0];
                JINK_UNROLL
                for (int k = 1; k < n; ++k) psi[a][r] = psi[a][r] + update.H[r * n + k] * moved[k];
            }
            JINK_UNROLL
            for (int i = 0; i < n; ++i) {
                T sum = moved[i];
                JINK_UNROLL
                for (int r = 0; r < Rows; ++r) sum = sum - update.K[i * Rows + r] * psi[a][r];
                to[O::M + i * A + a] = sum;
            }
            update.whiten(psi[a]);
        }
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            to[O::y + a] = from[O::y + a];
            JINK_UNROLL
            for (int r = 0; r < Rows; ++r) to[O::y + a] = to[O::y + a] + psi[a][r] * update.nu[r];
            JINK_UNROLL
            for (int b = 0; b <= a; ++b) {
                const int k = O::Y + packed(a, b);
                to[k] = from[k];
                JINK_UNROLL
                for (int r = 0; r < Rows; ++r) to[k] = to[k] + psi[a][r] * psi[b][r];
            }
        }
    }

    // Y = L D L', over = 1 / D; 0 for an axis that the innovations do not determine, which is then not corrected.
    template <int A> JINK_INLINE static void factor(const T *Y, T (&L)[A][A], T *over) {
        T D[A];
        JINK_UNROLL
        for (int j = 0; j < A; ++j) {
            const T whole = larger<T>(Y[packed(j, j)] * (1.0 + 1e-12), splat<T>(1e-200));
            D[j] = whole;
            JINK_UNROLL
            for (int k = 0; k < j; ++k) D[j] = D[j] - L[j][k] * L[j][k] * D[k];
            // a pivot sums some 30 products (scans by components), each rounded to 1.1e-16 of `whole`: what is below 1e-14 is rounding
            const Mask<T> determined = D[j] > larger<T>(1e-14 * whole, splat<T>(1e-200));
            D[j] = larger<T>(D[j], 2.220446049250313e-16 * whole);
            over[j] = select<T>(determined, reciprocal(D[j]), splat<T>(0.0));
            JINK_UNROLL
            for (int i = j + 1; i < A; ++i) {
                L[i][j] = Y[packed(i, j)];
                JINK_UNROLL
                for (int k = 0; k < j; ++k) L[i][j] = L[i][j] - L[i][k] * L[j][k] * D[k];
                L[i][j] = L[i][j] * over[j];
            }
        }
    }

    // y' Y^-1 y
    template <int A> JINK_INLINE T strength(const T *at) const {
        using O = Onset<A>;
        T L[A][A] = {}, over[A], u[A], sum = splat<T>(0.0);
        factor<A>(at + O::Y, L, over);
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            u[a] = at[O::y + a];
            JINK_UNROLL
            for (int k = 0; k < a; ++k) u[a] = u[a] - L[a][k] * u[k];
            sum = sum + u[a] * u[a] * over[a];
        }
        return sum;
    }

    // x += M Y^-1 y, P += M Y^-1 M', with W = M L^-T: M Y^-1 M' = W D^-1 W'. A correction beyond all range is not made.
    template <int A> void correct(const T *at, Mask<T> found, T *x) const {
        using O = Onset<A>;
        T L[A][A] = {}, over[A], u[A], W[O::n * A], moved[O::n], more[packed_size(O::n)], *P = x + O::n;
        factor<A>(at + O::Y, L, over);
        const auto solve = [&](const T *from, T *to) {
            for (int a = 0; a < A; ++a) {
                to[a] = from[a];
                for (int k = 0; k < a; ++k) to[a] = to[a] - L[a][k] * to[k];
            }
        };
        solve(at + O::y, u);
        for (int i = 0; i < O::n; ++i) {
            solve(at + O::M + i * A, &W[i * A]);
            moved[i] = splat<T>(0.0);
            for (int a = 0; a < A; ++a) moved[i] = moved[i] + W[i * A + a] * u[a] * over[a];
            for (int k = 0; k <= i; ++k) {
                T sum = splat<T>(0.0);
                for (int a = 0; a < A; ++a) sum = sum + W[i * A + a] * W[k * A + a] * over[a];
                more[packed(i, k)] = sum;
            }
            // a comparison with NaN is false
            found = found & (magnitude(moved[i]) <= splat<T>(farthest)) & (more[packed(i, i)] <= splat<T>(farthest * farthest));
        }
        for (int i = 0; i < O::n; ++i) x[i] = select<T>(found, x[i] + moved[i], x[i]);
        for (int k = 0; k < packed_size(O::n); ++k) P[k] = select<T>(found, P[k] + more[k], P[k]);
    }
};

}  // namespace jink::inline JINK_LEVEL
