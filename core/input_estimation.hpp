// Input estimation: from the innovations of a filter that knows of no manoeuvre, the constant acceleration that explains them.
//
// For each scan of the last W at which a manoeuvre may have begun: how the estimate depends on the acceleration since, M (n x axes),
// and what the innovations say of it, Y = sum Psi' S^-1 Psi and y = sum Psi' S^-1 nu, with Psi = H (F M + G) and M <- (I - K H)(F M + G).
// Where the likeliest onset's y' Y^-1 y exceeds the threshold, u = Y^-1 y is taken: x += M u, P += M Y^-1 M', and the watch starts anew.
// Chan, Hu & Plant, IEEE Trans. AES-15(2), 1979; over all onsets of a window: Bogler, IEEE Trans. AES-23(3), 1987.
#pragma once

#include "propagate.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class InputEstimation {
  public:
    explicit InputEstimation(const Composition<T> &composition)
        : c(composition), window(c.declared.detect.window), A(c.declared.axes()), n(c.modes[0].shape.n) {}
    bool active() const { return window > 0; }

    // After an update: `taken` lanes had one. The estimate in the track's arena is corrected where a manoeuvre is found.
    void operator()(TrackState<T> &s, const Propagate<T> &ahead, const SensorSpec &spec, const Measurement<T> &m, const Innovation<T> &v,
                    Mask<T> taken) {
        const Mode<T> &mode = c.modes[0];
        const int size = c.declared.onset_entry(), rows = spec.rows;
        T *x = &s.arena[mode.place], *P = x + n;
        T H[largest_measurement * L], K[L * largest_measurement], F[L * L], G[L * 3], S_root[packed_size(largest_measurement)];
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        const T *predicted = &ahead.predicted[mode.place];
        observe_jacobian(spec, mode.shape.block, n, predicted, H);
        for (int r = 0; r < rows; ++r)
            for (int k = 0; k < n; ++k) H[r * n + k] = select<T>(m.present[r] & taken, H[r * n + k], zero);
        cholesky<T>(rows, v.joint, S_root);
        gains(predicted + n, H, S_root, rows, K);
        motion(x, ahead.coefficient(0), F, G);
        // the youngest entry: a manoeuvre that begins with the step just made
        for (int k = window * size - 1; k >= size; --k) s.memory[k] = select<T>(s.running, s.memory[k - size], s.memory[k]);
        for (int k = 0; k < size; ++k) s.memory[k] = select<T>(s.running, k ? zero : one, s.memory[k]);
        T best = zero;
        T chosen[1 + 3 * L + 9];
        for (T &value : chosen) value = zero;
        // the oldest first: of onsets that explain the innovations equally well (one innovation does not tell them apart) the oldest
        for (int e = window - 1; e >= 0; --e) {
            T *at = &s.memory[e * size];
            advance(at, F, G, H, K, S_root, v, rows);
            if (e + 1 < c.declared.detect.shortest) continue;
            const T significance = select<T>(at[0] > zero, strength(at), zero);
            const Mask<T> better = taken & (significance > best * (1.0 + 1e-9));
            best = select<T>(better, significance, best);
            for (int k = 0; k < size; ++k) chosen[k] = select<T>(better, at[k], chosen[k]);
        }
        const Mask<T> found = taken & (best > splat<T>(c.declared.detect.threshold));
        if (!any(found)) return;
        correct(chosen, found, x, P);
        for (auto &value : s.memory) value = select<T>(found, zero, value);
    }

  private:
    static constexpr int L = largest_state;
    const Composition<T> &c;
    int window, A, n;

    // K = P- H' S^-1
    void gains(const T *P, const T *H, const T *root, int rows, T *K) const {
        for (int i = 0; i < n; ++i) {
            T row[largest_measurement];
            for (int r = 0; r < rows; ++r) {
                row[r] = splat<T>(0.0);
                for (int k = 0; k < n; ++k) row[r] = row[r] + P[packed(i, k)] * H[r * n + k];
            }
            solve_lower<T>(rows, root, row);
            solve_upper<T>(rows, root, row);
            for (int r = 0; r < rows; ++r) K[i * rows + r] = row[r];
        }
    }

    void motion(const T *x, const T *coefficient, T *F, T *G) const {
        const Mode<T> &mode = c.modes[0];
        T Q[packed_size(L)], still[L], moved[L];
        mode.kernels.linearise(x, coefficient, nullptr, still, F, Q);
        for (int a = 0; a < A; ++a) {
            T unit[3] = {splat<T>(0.0), splat<T>(0.0), splat<T>(0.0)};
            unit[a] = splat<T>(1.0);
            T at[L], unused[L * L];
            for (int i = 0; i < n; ++i) at[i] = splat<T>(0.0);
            mode.kernels.linearise(at, coefficient, unit, moved, unused, Q);
            for (int i = 0; i < n; ++i) G[i * A + a] = moved[i];
        }
    }

    void advance(T *at, const T *F, const T *G, const T *H, const T *K, const T *root, const Innovation<T> &v, int rows) const {
        T *M = at + 1, *Y = M + n * A, *y = Y + packed_size(A);
        T moved[L * 3], psi[3][largest_measurement], nu[largest_measurement];
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < A; ++a) {
                T sum = G[i * A + a];
                for (int k = 0; k < n; ++k) sum = sum + F[i * n + k] * M[k * A + a];
                moved[i * A + a] = sum;
            }
        for (int r = 0; r < rows; ++r) nu[r] = v.y[r];
        solve_lower<T>(rows, root, nu);
        for (int a = 0; a < A; ++a) {
            for (int r = 0; r < rows; ++r) {
                psi[a][r] = splat<T>(0.0);
                for (int k = 0; k < n; ++k) psi[a][r] = psi[a][r] + H[r * n + k] * moved[k * A + a];
            }
            for (int i = 0; i < n; ++i) {
                T sum = moved[i * A + a];
                for (int r = 0; r < rows; ++r) sum = sum - K[i * rows + r] * psi[a][r];
                M[i * A + a] = sum;
            }
            solve_lower<T>(rows, root, psi[a]);
        }
        for (int a = 0; a < A; ++a) {
            for (int r = 0; r < rows; ++r) y[a] = y[a] + psi[a][r] * nu[r];
            for (int b = 0; b <= a; ++b)
                for (int r = 0; r < rows; ++r) Y[packed(a, b)] = Y[packed(a, b)] + psi[a][r] * psi[b][r];
        }
    }

    // The root of Y, its diagonal no smaller than what rounding leaves of it.
    void root_of(const T *Y, T *root) const {
        T kept[6];
        for (int k = 0; k < packed_size(A); ++k) kept[k] = Y[k];
        for (int a = 0; a < A; ++a) kept[packed(a, a)] = larger<T>(kept[packed(a, a)] * (1.0 + 1e-12), splat<T>(1e-200));
        cholesky<T>(A, kept, root);
    }

    T strength(const T *at) const {
        const T *Y = at + 1 + n * A, *y = Y + packed_size(A);
        T root[6], u[3], sum = splat<T>(0.0);
        root_of(Y, root);
        for (int a = 0; a < A; ++a) u[a] = y[a];
        solve_lower<T>(A, root, u);
        for (int a = 0; a < A; ++a) sum = sum + u[a] * u[a];
        return sum;
    }

    void correct(const T *at, Mask<T> found, T *x, T *P) const {
        const T *M = at + 1, *Y = M + n * A, *y = Y + packed_size(A);
        T root[6], u[3], W[L * 3];  // W = M root^-T, so that M Y^-1 M' = W W'
        root_of(Y, root);
        for (int a = 0; a < A; ++a) u[a] = y[a];
        solve_lower<T>(A, root, u);
        for (int i = 0; i < n; ++i) {
            T row[3];
            for (int a = 0; a < A; ++a) row[a] = M[i * A + a];
            solve_lower<T>(A, root, row);
            T moved = splat<T>(0.0);
            for (int a = 0; a < A; ++a) W[i * A + a] = row[a], moved = moved + row[a] * u[a];
            x[i] = select<T>(found, x[i] + moved, x[i]);
            for (int k = 0; k <= i; ++k) {
                T sum = splat<T>(0.0);
                for (int a = 0; a < A; ++a) sum = sum + W[i * A + a] * W[k * A + a];
                P[packed(i, k)] = select<T>(found, P[packed(i, k)] + sum, P[packed(i, k)]);
            }
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
