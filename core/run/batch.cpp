#include <memory>

#include "run/rows.hpp"
#include "run/threads.hpp"

namespace jink::inline JINK_LEVEL {

namespace {

// One thread's work: pack after pack.
class Runner {
  public:
    Runner(const Composition<Pack> &composition, const BatchInput &input, const BatchOutput &output, bool smoothed)
        : c(composition), in(input), out(output), smoothing(smoothed), step(c), combine(c), aid(c), state(c), rows(in, c.declared.axes()),
          total_rows(in.offsets[in.tracks]), x(out.x, total_rows, c.reported.n), P(out.P, total_rows, c.reported.n, true),
          some(out.covariances, total_rows), mu(out.mode_probability, total_rows, c.members()), likelihood(out.log_likelihood_scan, total_rows, 1), nis(out.nis, total_rows, 1),
          dof(out.nis_dof, total_rows, 1), pit(out.pit, total_rows, in.columns), members(c.members()) {}

    void run(const std::int64_t *tracks, int used) {
        const std::int64_t longest = rows.take(tracks, used);
        state.reset(c);
        if (in.prior_x) begin_at_prior(c, in, state, tracks, used);
        total = splat<Pack>(0.0);
        if (smoothing && records.size() < std::size_t(longest)) records.resize(longest);
        for (std::int64_t from = 0; from < longest; from += block) forward(from, int(std::min<std::int64_t>(block, longest - from)));
        rows.verify(tracks, used);
        if (smoothing && !in.until) backward(longest);
        else if (smoothing) lagged(longest);
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
    Column x, P;
    Elements some;  // of P
    Column mu, likelihood, nis, dof, pit;
    std::vector<Record<Pack>> records;
    Spare<Pack> spare;
    std::vector<Pack> members;  // probabilities of the whole set of modes
    Pack total, xs[largest_state], Ps[packed_size(largest_state)];

    void forward(std::int64_t from, int scans) {
        rows.gather(from, scans);
        Scan<Pack> scan;
        Pack input[3];
        const int detail = (nis.wanted() ? with_nis : 0) | (pit.wanted() ? with_pit : 0);
        for (int k = 0; k < scans; ++k) {
            rows.read(k, scan, input);
            const Pack before = state.time;
            const Outcome<Pack> o = step.step(state, scan, detail);
            if (aid.active() && !smoothing) aid(step, state, scan, o);
            total = total + select<Pack>(scan.active, o.log_likelihood, splat<Pack>(0.0));
            if (likelihood.wanted()) likelihood.put(k, &o.log_likelihood, scan.active);
            if (nis.wanted()) nis.put(k, &o.nis, o.scored);
            const Pack freedom = select<Pack>(o.scored, o.dof, splat<Pack>(0.0));
            if (dof.wanted()) dof.put(k, &freedom, scan.active);
            if (pit.wanted()) pit.put(k, o.pit, o.scored);
            if (out.status)
                for (int l = 0; l < lanes; ++l)
                    if (from + k < rows.span.count[l]) out.status[rows.span.start[l] + from + k] = static_cast<unsigned char>(status_of(state, o, l));
            if (smoothing) remember(from + k, scan, o, before);
            else estimate(k, state.arena.data(), state.probability.data(), state.started, state.alive);
        }
        if (!smoothing) scatter_estimates(from, scans);
        for (const Column *column : {&likelihood, &nis, &dof, &pit}) column->scatter(rows.span, from, scans);
    }

    // What smoothing needs of a scan; what it decides of those before is noted there.
    void remember(std::int64_t k, const Scan<Pack> &scan, const Outcome<Pack> &o, Pack before) {
        records[k].number = double(k);
        record(step, state, scan, o, before, records[k], spare);
        if (!c.declared.hindsight || !any(o.decided)) return;
        for (std::int64_t j = k - 1; j >= 0; --j) {
            const Mask<Pack> now = decide(records[j], o, double(k));
            if (!any(now)) break;
            for (int l = 0; out.status && l < lanes; ++l)
                if (lane(now, l)) correct_status(l, j, k, lane(o.upheld, l));
            if (in.until) continue;  // of an earlier scan it may be asked what was known then
            recall(c, records[j], splat<Pack>(double(k)));
            close(records[j], spare);
        }
    }

    void correct_status(int l, std::int64_t row, std::int64_t decided, bool upheld) {
        const std::int64_t at = rows.span.start[l] + row;
        unsigned char &status = out.status[at];
        if (in.until && in.until[at] - rows.span.start[l] < decided) return;
        if (status == static_cast<unsigned char>(Status::updated) || status == static_cast<unsigned char>(Status::gated))
            status = static_cast<unsigned char>(upheld ? Status::updated : Status::gated);
    }

    void estimate(int k, const Pack *arena, const Pack *probability, Mask<Pack> started, const std::vector<Pack> &alive) {
        if (x.wanted() || covariances()) {
            const bool known = !smoothing && !covariances() && !aid.combined.empty();
            if (known) std::copy(aid.combined.begin(), aid.combined.end(), xs);
            else combine(arena, probability, xs, covariances() ? Ps : nullptr);
            if (!smoothing) corrected(aid.correction, xs, covariances() ? Ps : nullptr);
            if (x.wanted()) x.put(k, xs, started);
            if (P.wanted()) P.put(k, Ps, started);
            some.put(k, Ps, started);
        }
        if (!mu.wanted()) return;
        if (c.proposes()) step.ahead.proposal.spread(alive, probability, members.data()), probability = members.data();
        mu.put(k, probability, started);
    }

    void scatter_estimates(std::int64_t from, int scans) {
        for (const Column *column : {&x, &P, &mu}) column->scatter(rows.span, from, scans);
        some.scatter(rows.span, from, scans);
    }

    bool covariances() const { return P.wanted() || some.wanted(); }

    // Of every scan an estimate from the rows up to in.until: each goes back from there by itself.
    void lagged(std::int64_t longest) {
        Smooth<Pack> smooth(c);
        for (std::int64_t k = 0; k < longest; ++k) {
            std::int64_t until[lanes], last = k;
            for (int l = 0; l < lanes; ++l) {
                const std::int64_t first = rows.span.start[l];
                until[l] = k < rows.span.count[l] ? in.until[first + k] - first : k;
                last = std::max(last, until[l]);
            }
            Pack known;
            for (int l = 0; l < lanes; ++l) set_lane(known, l, double(until[l]));
            for (std::int64_t j = k; j <= last; ++j) recall(c, records[j], known);
            smooth.last(records[last]);
            for (std::int64_t j = last - 1; j >= k; --j) {
                smooth.step(records[j], records[j + 1]);
                Mask<Pack> begin;
                for (int l = 0; l < lanes; ++l) set_lane(begin, l, until[l] == j);
                if (any(begin)) smooth.last(records[j], begin);
            }
            const std::int64_t from = k / block * block;
            estimate(int(k - from), smooth.arena.data(), smooth.probability.data(), records[k].started, {});
            if (k == from + block - 1 || k == longest - 1) scatter_estimates(from, int(k - from + 1));
        }
    }

    void backward(std::int64_t longest) {
        Smooth<Pack> smooth(c);
        smooth.covariances = covariances();
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
    const std::vector<std::int64_t> order = longest_first(in);
    over_threads(packs_of(in), threads, [&] {
        return [&, runner = std::make_unique<Runner>(composition, in, out, smooth)](std::int64_t pack) {
            runner->run(&order[pack * lanes], int(std::min<std::int64_t>(lanes, in.tracks - pack * lanes)));
        };
    });
}

}  // namespace jink::inline JINK_LEVEL
