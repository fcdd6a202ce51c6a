#include "rows.hpp"

#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

namespace jink::inline JINK_LEVEL {

namespace {

// One thread's work: pack after pack.
class Runner {
  public:
    Runner(const Composition<Pack> &composition, const BatchInput &input, const BatchOutput &output, bool smoothed)
        : c(composition), in(input), out(output), smoothing(smoothed), step(c), combine(c), aid(c), state(c), rows(in, c.declared.axes()),
          total_rows(in.offsets[in.tracks]), x(out.x, total_rows, c.reported.n), P(out.P, total_rows, c.reported.n, true),
          mu(out.mode_probability, total_rows, c.members()), likelihood(out.log_likelihood_scan, total_rows, 1), nis(out.nis, total_rows, 1),
          dof(out.nis_dof, total_rows, 1), pit(out.pit, total_rows, in.columns), members(c.members()) {}

    void run(const std::int64_t *tracks, int used) {
        std::int64_t longest = 0;
        auto &[first, length] = rows.span;
        for (int l = 0; l < lanes; ++l) {
            const std::int64_t b = tracks[std::min(l, used - 1)];
            first[l] = in.offsets[b];
            length[l] = l < used ? in.offsets[b + 1] - in.offsets[b] : 0;
            longest = std::max(longest, length[l]);
        }
        state.reset(c);
        suspect = splat_mask<Pack>(false), latest = splat<Pack>(-std::numeric_limits<double>::max());
        if (in.prior_x) begin_at_prior(tracks, used, length);
        total = splat<Pack>(0.0);
        if (smoothing && records.size() < std::size_t(longest)) records.resize(longest);
        for (std::int64_t from = 0; from < longest; from += block) forward(from, int(std::min<std::int64_t>(block, longest - from)));
        if (any(suspect))
            for (int l = 0; l < used; ++l) complain(tracks[l]);
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
    Aid<Pack> aid;
    TrackState<Pack> state;
    Rows rows;
    std::int64_t total_rows;
    Column x, P, mu, likelihood, nis, dof, pit;
    std::vector<Record<Pack>> records;
    std::vector<Pack> members;  // probabilities of the whole set of modes
    Mask<Pack> suspect;
    Pack latest, total, xs[largest_state], Ps[packed_size(largest_state)];

    // Times must not go back within a track, and infinite measurements mean nothing.
    void look_at(const Scan<Pack> &scan) {
        const Pack most = splat<Pack>(std::numeric_limits<double>::max());
        suspect = suspect | (scan.active & inverse((scan.time >= latest) & (scan.time <= most)));
        for (int r = 0; r < in.columns; ++r) suspect = suspect | (magnitude(scan.z[r]) > most);
        latest = scan.time;
    }

    // The row that is wrong, in words.
    void complain(std::int64_t track) const {
        const std::int64_t from = in.offsets[track], to = in.offsets[track + 1];
        for (std::int64_t k = from; k < to; ++k) {
            const std::string row = "row " + std::to_string(k);
            if (!std::isfinite(in.time[k])) throw std::invalid_argument("time: " + row + " of track " + std::to_string(track) + " is not a time");
            if (k > from && in.time[k] < in.time[k - 1])
                throw std::invalid_argument("time: " + row + " of track " + std::to_string(track) +
                                            " lies before the row before it; rows of a track must be in the order of time");
            for (int r = 0; r < in.columns; ++r)
                if (std::isinf(in.z[k * in.columns + r]))
                    throw std::invalid_argument("z: " + row + " is infinite; a missing component is NaN or None");
        }
    }

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
            look_at(scan);
            const Pack before = state.time;
            const Outcome<Pack> o = step.step(state, scan, detail);
            if (aid.active()) aid(step, state, scan, o);
            total = total + select<Pack>(scan.active, o.log_likelihood, splat<Pack>(0.0));
            if (likelihood.wanted()) likelihood.put(k, &o.log_likelihood, scan.active);
            if (nis.wanted()) nis.put(k, &o.nis, o.scored);
            const Pack freedom = select<Pack>(o.scored, o.dof, splat<Pack>(0.0));
            if (dof.wanted()) dof.put(k, &freedom, scan.active);
            if (pit.wanted()) pit.put(k, o.pit, o.scored);
            if (out.status)
                for (int l = 0; l < lanes; ++l)
                    if (from + k < rows.span.count[l]) out.status[rows.span.start[l] + from + k] = static_cast<unsigned char>(status_of(state, o, l));
            if (smoothing) record(step, state, scan, o, before, records[from + k]);
            else estimate(k, state.arena.data(), state.probability.data(), state.started, state.alive);
        }
        if (!smoothing) scatter_estimates(from, scans);
        for (const Column *column : {&likelihood, &nis, &dof, &pit}) column->scatter(rows.span, from, scans);
    }

    void estimate(int k, const Pack *arena, const Pack *probability, Mask<Pack> started, const std::vector<Pack> &alive) {
        if (x.wanted() || P.wanted()) {
            combine(arena, probability, xs, P.wanted() ? Ps : nullptr);
            for (int i = 0; aid.active() && i < c.reported.n; ++i) xs[i] = xs[i] + aid.correction[i];
            if (x.wanted()) x.put(k, xs, started);
            if (P.wanted()) P.put(k, Ps, started);
        }
        if (!mu.wanted()) return;
        if (c.proposes()) step.ahead.proposal.spread(alive, probability, members.data()), probability = members.data();
        mu.put(k, probability, started);
    }

    void scatter_estimates(std::int64_t from, int scans) {
        for (const Column *column : {&x, &P, &mu}) column->scatter(rows.span, from, scans);
    }

    void backward(std::int64_t longest) {
        Smooth<Pack> smooth(c);
        for (std::int64_t k = longest - 1; k >= 0; --k) {
            if (k == longest - 1) smooth.last(records[k]);
            else smooth.step(records[k], records[k + 1]);
            const std::int64_t from = k / block * block;
            estimate(int(k - from), smooth.arena.data(), smooth.probability.data(), records[k].started, {});
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
