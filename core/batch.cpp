#include "batch.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

namespace jink::inline JINK_LEVEL {

namespace {

constexpr int block = 16;  // scans gathered and scattered at a time, so that both read and write runs of memory
using Lane = double[lanes];

// The rows of one pack of tracks, a block of scans at a time, lane by lane beside each other.
class Rows {
  public:
    Rows(const BatchInput &batch, int state_axes)
        : in(batch), axes(state_axes), noise_terms(!in.noise ? 0 : in.full_noise ? packed_size(in.columns) : in.columns),
          buffer(block * (1 + in.columns + noise_terms + (in.input ? axes : 0)) * lanes), sensors(block * lanes) {}

    void take(const std::int64_t *first, const std::int64_t *length) {
        for (int l = 0; l < lanes; ++l) start[l] = first[l], count[l] = length[l];
    }

    void gather(std::int64_t from, int scans) {
        const int stride = int(buffer.size() / block);
        begun = from;
        for (int l = 0; l < lanes; ++l)
            for (int k = 0; k < scans; ++k) {
                double *to = &buffer[k * stride + l];
                const bool live = from + k < count[l];
                const std::int64_t row = start[l] + (live ? from + k : std::max<std::int64_t>(count[l] - 1, 0));
                if (count[l] == 0) {
                    for (int f = 0; f < stride; f += lanes) to[f] = f == 0 ? 0.0 : f <= in.columns * lanes ? NAN : 1.0;
                    sensors[k * lanes + l] = 0;
                    continue;
                }
                *to = in.time[row], to += lanes;
                for (int r = 0; r < in.columns; ++r, to += lanes) *to = live ? in.z[row * in.columns + r] : NAN;
                if (noise_terms) {
                    const double *R = in.noise + row * in.columns * (in.full_noise ? in.columns : 1);
                    if (in.full_noise)
                        for (int r = 0; r < in.columns; ++r)
                            for (int q = 0; q <= r; ++q, to += lanes) *to = R[r * in.columns + q];
                    else
                        for (int r = 0; r < in.columns; ++r, to += lanes) *to = R[r];
                }
                if (in.input)
                    for (int a = 0; a < axes; ++a, to += lanes) *to = in.input[row * axes + a];
                sensors[k * lanes + l] = in.sensor ? in.sensor[row] : 0;
            }
    }

    // The k-th scan of the block.
    void read(int k, Scan<Pack> &scan, Pack *input) const {
        const double *from = &buffer[k * (buffer.size() / block)];
        scan.time = load<Pack>(from), from += lanes;
        for (int r = 0; r < in.columns; ++r, from += lanes) scan.z[r] = load<Pack>(from);
        scan.own_noise = noise_terms > 0, scan.own_full = in.full_noise;
        for (int t = 0; t < noise_terms; ++t, from += lanes) scan.R[t] = load<Pack>(from);
        if (in.input)
            for (int a = 0; a < axes; ++a, from += lanes) input[a] = load<Pack>(from);
        scan.input = in.input ? input : nullptr;
        scan.mixed_sensors = false;
        for (int l = 0; l < lanes; ++l) {
            set_lane(scan.active, l, begun + k < count[l]);
            scan.sensor[l] = sensors[k * lanes + l];
            scan.mixed_sensors = scan.mixed_sensors || scan.sensor[l] != scan.sensor[0];
        }
    }

    std::int64_t start[lanes], count[lanes];

  private:
    const BatchInput &in;
    int axes, noise_terms;
    std::int64_t begun = 0;
    std::vector<double> buffer;
    std::vector<std::int32_t> sensors;
};

// One kind of result on its way out: a block of scans in lanes, then run by run into the rows of each track.
class Column {
  public:
    Column(double *to, int values, bool symmetric = false)
        : dest(to), width_in(symmetric ? packed_size(values) : values), n(values), square(symmetric),
          buffer(to ? std::size_t(block) * width_in * lanes : 0) {}

    bool wanted() const { return dest != nullptr; }
    void put(int k, int c, Pack value) { store(&buffer[(k * width_in + c) * lanes], value); }
    void put(int k, const Pack *values, Mask<Pack> valid) {
        for (int c = 0; c < width_in; ++c) put(k, c, select<Pack>(valid, values[c], nan_of<Pack>()));
    }

    void scatter(const Rows &rows, std::int64_t from, int scans) const {
        if (!dest) return;
        for (int l = 0; l < lanes; ++l) {
            const int live = int(std::clamp<std::int64_t>(rows.count[l] - from, 0, scans));
            const double *source = &buffer[l];
            if (!square) {
                double *to = dest + (rows.start[l] + from) * n;
                for (int k = 0; k < live * n; ++k) to[k] = source[k * lanes];
                continue;
            }
            double *to = dest + (rows.start[l] + from) * n * n;
            for (int k = 0; k < live; ++k, source += width_in * lanes, to += n * n)
                for (int r = 0, p = 0; r < n; ++r)
                    for (int q = 0; q <= r; ++q, ++p) to[r * n + q] = to[q * n + r] = source[p * lanes];
        }
    }

  private:
    double *dest;
    int width_in, n;
    bool square;
    std::vector<double> buffer;
};

// One thread's work: pack after pack.
class Runner {
  public:
    Runner(const Composition<Pack> &composition, const BatchInput &input, const BatchOutput &output, bool smoothed)
        : c(composition), in(input), out(output), smoothing(smoothed), step(c), combine(c), state(c), rows(in, c.declared.axes()),
          x(out.x, c.reported.n), P(out.P, c.reported.n, true), mu(out.mode_probability, c.count),
          likelihood(out.log_likelihood_scan, 1), nis(out.nis, 1), dof(out.nis_dof, 1), pit(out.pit, in.columns) {}

    void run(const std::int64_t *tracks, int used) {
        std::int64_t first[lanes], length[lanes], longest = 0;
        for (int l = 0; l < lanes; ++l) {
            const std::int64_t b = tracks[std::min(l, used - 1)];
            first[l] = in.offsets[b];
            length[l] = l < used ? in.offsets[b + 1] - in.offsets[b] : 0;
            longest = std::max(longest, length[l]);
        }
        rows.take(first, length);
        state.reset(c);
        if (in.prior_x) begin_at_prior(tracks, used, length);
        total = splat<Pack>(0.0);
        if (smoothing && records.size() < std::size_t(longest)) records.resize(longest);
        for (std::int64_t from = 0; from < longest; from += block) forward(from, int(std::min<std::int64_t>(block, longest - from)));
        if (smoothing) backward(longest);
        if (out.log_likelihood)
            for (int l = 0; l < used; ++l) out.log_likelihood[tracks[l]] = total[l];
    }

  private:
    const Composition<Pack> &c;
    const BatchInput &in;
    const BatchOutput &out;
    bool smoothing;
    Step<Pack> step;
    Combine<Pack> combine;
    TrackState<Pack> state;
    Rows rows;
    Column x, P, mu, likelihood, nis, dof, pit;
    std::vector<Record<Pack>> records;
    Pack total, xs[largest_state], Ps[packed_size(largest_state)];

    void begin_at_prior(const std::int64_t *tracks, int used, const std::int64_t *length) {
        const int n = c.reported.n;
        for (int l = 0; l < used; ++l)
            if (length[l]) set_prior(c, state, l, in.prior_x + tracks[l] * n, in.prior_P + tracks[l] * n * n, in.time[in.offsets[tracks[l]]]);
        state.settled = all(state.running);
    }

    void forward(std::int64_t from, int scans) {
        rows.gather(from, scans);
        Scan<Pack> scan;
        Pack input[3];
        const int detail = (nis.wanted() ? with_nis : 0) | (pit.wanted() ? with_pit : 0);
        for (int k = 0; k < scans; ++k) {
            rows.read(k, scan, input);
            const Pack before = state.time;
            const Outcome<Pack> o = step.step(state, scan, detail);
            total = total + select<Pack>(scan.active, o.log_likelihood, splat<Pack>(0.0));
            const Mask<Pack> scored = o.measured & state.started & inverse(o.initialised);
            if (likelihood.wanted()) likelihood.put(k, 0, o.log_likelihood);
            if (nis.wanted()) nis.put(k, 0, select<Pack>(scored, o.nis, nan_of<Pack>()));
            if (dof.wanted()) dof.put(k, 0, select<Pack>(scored, o.dof, splat<Pack>(0.0)));
            if (pit.wanted()) pit.put(k, o.pit, scored);
            if (out.status)
                for (int l = 0; l < lanes; ++l)
                    if (from + k < rows.count[l]) out.status[rows.start[l] + from + k] = static_cast<unsigned char>(status_of(state, o, l));
            if (smoothing) record(step, state, scan, o, before, records[from + k]);
            else estimate(k, state.arena.data(), state.probability.data(), state.started);
        }
        if (!smoothing) scatter_estimates(from, scans);
        for (const Column *column : {&likelihood, &nis, &dof, &pit}) column->scatter(rows, from, scans);
    }

    void estimate(int k, const Pack *arena, const Pack *probability, Mask<Pack> started) {
        if (x.wanted() || P.wanted()) {
            combine(arena, probability, xs, P.wanted() ? Ps : nullptr);
            if (x.wanted()) x.put(k, xs, started);
            if (P.wanted()) P.put(k, Ps, started);
        }
        if (mu.wanted()) mu.put(k, probability, started);
    }

    void scatter_estimates(std::int64_t from, int scans) {
        for (const Column *column : {&x, &P, &mu}) column->scatter(rows, from, scans);
    }

    void backward(std::int64_t longest) {
        Smooth<Pack> smooth(c);
        for (std::int64_t k = longest - 1; k >= 0; --k) {
            if (k == longest - 1) smooth.last(records[k]);
            else smooth.step(records[k], records[k + 1]);
            const std::int64_t from = k / block * block;
            estimate(int(k - from), smooth.arena.data(), smooth.probability.data(), records[k].started);
            if (k == from) scatter_estimates(from, int(std::min<std::int64_t>(block, longest - from)));
        }
    }
};

}  // namespace

void run_batch(const Composition<Pack> &composition, const BatchInput &in, const BatchOutput &out, bool smooth, int threads) {
    std::vector<std::int64_t> order(in.tracks);
    std::iota(order.begin(), order.end(), 0);
    const auto length = [&](std::int64_t b) { return in.offsets[b + 1] - in.offsets[b]; };
    const auto longer = [&](std::int64_t a, std::int64_t b) { return length(a) > length(b); };
    if (!std::is_sorted(order.begin(), order.end(), longer)) std::stable_sort(order.begin(), order.end(), longer);
    const std::int64_t packs = (in.tracks + lanes - 1) / lanes;
    std::atomic<std::int64_t> next{0};
    std::exception_ptr failure;
    std::mutex failing;
    const auto work = [&] {
        try {
            Runner runner(composition, in, out, smooth);
            for (std::int64_t p; (p = next.fetch_add(1)) < packs;)
                runner.run(&order[p * lanes], int(std::min<std::int64_t>(lanes, in.tracks - p * lanes)));
        } catch (...) {
            const std::lock_guard lock(failing);
            failure = std::current_exception();
        }
    };
    const int helpers = int(std::min<std::int64_t>(threads, packs)) - 1;
    std::vector<std::thread> pool;
    for (int t = 0; t < helpers; ++t) pool.emplace_back(work);
    work();
    for (auto &thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace jink::inline JINK_LEVEL
