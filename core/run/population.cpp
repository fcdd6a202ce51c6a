#include "run/population.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

namespace jink::inline JINK_LEVEL {

namespace {

// One individual per lane. All lanes see the same runs, so what depends on the data alone is a scalar.
template <int M> class Population {
  public:
    explicit Population(const PopulationInput &input) : in(input), sums(2 * input.scans) {
        for (auto &table : tables) table.resize(in.rules * fuzzy_fields);
    }

    void run(const std::int64_t *individuals, int used, double *errors) {
        for (int l = 0; l < lanes; ++l) take(individuals[std::min(l, used - 1)], l);
        for (int j = 0; j < M; ++j) {
            most[j] = 1;
            for (int l = 0; l < used; ++l) most[j] = std::max(most[j], int(in.count[individuals[l] * M + j]));
        }
        std::fill(sums.begin(), sums.end(), splat<Pack>(0.0));
        for (std::int64_t r = 0; r < in.runs; ++r) one_run(r * in.scans);
        for (int l = 0; l < used; ++l)
            for (std::size_t k = 0; k < sums.size(); ++k) errors[individuals[l] * sums.size() + k] = sums[k][l];
    }

  private:
    const PopulationInput &in;
    std::vector<Pack> tables[M], sums;
    int most[M];
    Pack transition[M][M], initial[M];
    Pack x[M][2], P[M][3], mu[M], weight[M], last_q[M], last_r[M];
    bool has_last;

    void take(std::int64_t i, int l) {
        for (int j = 0; j < M; ++j) {
            initial[j][l] = in.probability[i * M + j];
            for (int t = 0; t < M; ++t) transition[j][t][l] = in.transition[(i * M + j) * M + t];
            for (std::int64_t k = 0; k < in.rules; ++k) {
                const bool valid = k < in.count[i * M + j];
                const double *from = in.tables + ((i * M + j) * in.rules + k) * fuzzy_fields;
                for (int f = 0; f < fuzzy_fields; ++f) {
                    const double value = f == 1 || f == 3 ? 1.0 / from[f] : from[f];
                    tables[j][k * fuzzy_fields + f][l] = valid ? value : nowhere[f];
                }
            }
        }
    }

    void one_run(std::int64_t from) {
        std::int64_t first = -1, k = 0;
        for (; k < in.scans; ++k)
            if (!std::isnan(in.z[from + k])) {
                if (first >= 0) break;
                first = k;
            }
        if (k >= in.scans) return;
        begin(in.z[from + first], in.z[from + k], in.time[from + k] - in.time[from + first]);
        for (++k; k < in.scans; ++k) {
            const std::int64_t row = from + k;
            step(in.z[row], in.time[row] - in.time[row - 1]);
            if (std::isnan(in.position[row])) continue;
            Pack p = splat<Pack>(0.0), v = p;
            for (int j = 0; j < M; ++j) p = p + mu[j] * x[j][0], v = v + mu[j] * x[j][1];
            p = p - in.position[row], v = v - in.velocity[row];
            sums[2 * k] = sums[2 * k] + p * p;
            sums[2 * k + 1] = sums[2 * k + 1] + v * v;
        }
    }

    // Two-point differencing: v = (z2 - z1)/T, P = [R, R/T; R/T, 2R/T^2].
    void begin(double z1, double z2, double dt) {
        for (int j = 0; j < M; ++j) {
            x[j][0] = splat<Pack>(z2), x[j][1] = splat<Pack>((z2 - z1) / dt);
            P[j][0] = splat<Pack>(in.variance), P[j][1] = P[j][0] / dt, P[j][2] = 2.0 * P[j][1] / dt;
            mu[j] = initial[j];
            last_q[j] = fuzzy_variance<Pack>(most[j], tables[j].data(), splat<Pack>(0.0), splat<Pack>(0.0));
        }
        has_last = false;
    }

    void step(double z, double dt) {
        if constexpr (M > 1) {
            if (dt > 0.0) mix();
        }
        const bool measured = !std::isnan(z);
        Pack log_weight[M];
        for (int j = 0; j < M; ++j) {
            x[j][0] = x[j][0] + dt * x[j][1];
            P[j][0] = P[j][0] + dt * (2.0 * P[j][1] + dt * P[j][2]);
            P[j][1] = P[j][1] + dt * P[j][2];
            const Pack r = z - x[j][0];
            if (measured) {
                const Pack change = has_last ? r - last_r[j] : splat<Pack>(0.0);
                last_q[j] = fuzzy_variance<Pack>(most[j], tables[j].data(), r, change);
                last_r[j] = r;
            }
            const double g = 0.5 * dt * dt;
            P[j][0] = P[j][0] + g * g * last_q[j], P[j][1] = P[j][1] + g * dt * last_q[j], P[j][2] = P[j][2] + dt * dt * last_q[j];
            if (measured) log_weight[j] = update(j, r);
        }
        has_last = measured;
        if constexpr (M > 1) {
            if (measured) weigh(log_weight);
        }
    }

    Pack update(int j, Pack r) {
        const Pack S = P[j][0] + in.variance, over = reciprocal(S), gain = P[j][0] * over, gain_v = P[j][1] * over;
        x[j][0] = x[j][0] + gain * r, x[j][1] = x[j][1] + gain_v * r;
        P[j][2] = P[j][2] - gain_v * P[j][1];
        const Pack kept = in.variance * over;
        P[j][0] = P[j][0] * kept, P[j][1] = P[j][1] * kept;
        if constexpr (M > 1) return -0.5 * (logarithm<Pack>(S) + r * r * over);
        else return S;
    }

    void mix() {
        Pack x0[M][2], P0[M][3], predicted[M];
        for (int j = 0; j < M; ++j) {
            predicted[j] = splat<Pack>(1e-100);
            for (int i = 0; i < M; ++i) predicted[j] = predicted[j] + transition[i][j] * mu[i];
            const Pack over = 1.0 / predicted[j];
            x0[j][0] = x0[j][1] = P0[j][0] = P0[j][1] = P0[j][2] = splat<Pack>(0.0);
            for (int i = 0; i < M; ++i) {
                weight[i] = transition[i][j] * mu[i] * over;
                x0[j][0] = x0[j][0] + weight[i] * x[i][0], x0[j][1] = x0[j][1] + weight[i] * x[i][1];
            }
            for (int i = 0; i < M; ++i) {
                const Pack d0 = x[i][0] - x0[j][0], d1 = x[i][1] - x0[j][1];
                P0[j][0] = P0[j][0] + weight[i] * (P[i][0] + d0 * d0);
                P0[j][1] = P0[j][1] + weight[i] * (P[i][1] + d0 * d1);
                P0[j][2] = P0[j][2] + weight[i] * (P[i][2] + d1 * d1);
            }
        }
        for (int j = 0; j < M; ++j) {
            mu[j] = predicted[j];
            for (int a = 0; a < 2; ++a) x[j][a] = x0[j][a];
            for (int a = 0; a < 3; ++a) P[j][a] = P0[j][a];
        }
    }

    void weigh(const Pack *log_weight) {
        Pack best = log_weight[0], total = splat<Pack>(0.0);
        for (int j = 1; j < M; ++j) best = larger<Pack>(best, log_weight[j]);
        for (int j = 0; j < M; ++j) mu[j] = mu[j] * exponential<Pack>(log_weight[j] - best) + 1e-100, total = total + mu[j];
        const Pack over = 1.0 / total;
        for (int j = 0; j < M; ++j) mu[j] = mu[j] * over;
    }
};

template <int M> void evaluate(const PopulationInput &in, double *errors, int threads) {
    // individuals with as many rules as each other share a pack, so that no lane waits for another
    std::vector<std::int64_t> order(in.individuals), rules(in.individuals);
    std::iota(order.begin(), order.end(), 0);
    for (auto i : order) rules[i] = std::accumulate(in.count + i * M, in.count + (i + 1) * M, std::int64_t(0));
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return rules[a] > rules[b]; });
    const std::int64_t packs = (in.individuals + lanes - 1) / lanes;
    std::atomic<std::int64_t> next{0};
    const auto work = [&] {
        Population<M> population(in);
        for (std::int64_t p; (p = next.fetch_add(1)) < packs;)
            population.run(&order[p * lanes], int(std::min<std::int64_t>(lanes, in.individuals - p * lanes)), errors);
    };
    std::vector<std::thread> pool;
    for (std::int64_t t = 1; t < std::min<std::int64_t>(threads, packs); ++t) pool.emplace_back(work);
    work();
    for (auto &thread : pool) thread.join();
}

}  // namespace

void population_errors(const PopulationInput &in, double *errors, int threads) {
    switch (in.modes) {
        case 1: return evaluate<1>(in, errors, threads);
        case 2: return evaluate<2>(in, errors, threads);
        case 3: return evaluate<3>(in, errors, threads);
        case 4: return evaluate<4>(in, errors, threads);
        default: return evaluate<5>(in, errors, threads);
    }
}

}  // namespace jink::inline JINK_LEVEL
