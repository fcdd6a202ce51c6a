#include "run/candidates.hpp"

#include <memory>
#include <unordered_map>

#include "run/numbers.hpp"
#include "run/rows.hpp"
#include "run/threads.hpp"

namespace jink::inline JINK_LEVEL {

namespace {

// The filter with a candidate's numbers in each lane.
Composition<Pack> in_lanes(const Declaration &declaration, const double *const *numbers) {
    std::unordered_map<const double *, std::size_t> places;
    each_number(declaration, [&](const double &number) { places.emplace(&number, places.size()); });
    return Composition<Pack>(declaration, [&](const double &number) {
        Pack lifted = splat<Pack>(number);
        const auto place = places.find(&number);
        for (int l = 0; place != places.end() && l < lanes; ++l) lifted[l] = numbers[l][place->second];
        return lifted;
    });
}

// A pack of candidates, over track after track.
class Lanes {
  public:
    Lanes(const Composition<Pack> &composition, const BatchInput &input, const double *truth_, std::int64_t scans)
        : c(composition), in(input), step(c), combine(c), state(c), rows(in, c.declared.axes()), truth(truth_, 2 * c.declared.axes(), NAN),
          sums(3 * scans, splat<Pack>(0.0)) {}

    const std::vector<Pack> &run() {
        for (std::int64_t b = 0; b < in.tracks; ++b) {
            std::int64_t same[lanes];
            std::fill(same, same + lanes, b);
            const std::int64_t scans = rows.take(same, lanes);
            state.reset(c);
            for (std::int64_t from = 0; from < scans; from += block) {
                const int here = int(std::min<std::int64_t>(block, scans - from));
                rows.gather(from, here), truth.gather(rows.span, from, here);
                for (int k = 0; k < here; ++k) scan(from, k);
            }
            rows.verify(same, lanes);
        }
        return sums;
    }

  private:
    const Composition<Pack> &c;
    const BatchInput &in;
    Step<Pack> step;
    Combine<Pack> combine;
    TrackState<Pack> state;
    Rows rows;
    Stream truth;
    std::vector<Pack> sums;

    void scan(std::int64_t from, int k) {
        Scan<Pack> s;
        Pack known[3], x[largest_state];
        rows.read(k, s, known);
        const Mask<Pack> before = state.running;
        step.step(state, s, plain);
        const int axes = c.declared.axes();
        const Pack zero = splat<Pack>(0.0);
        if (!any(before) || all(is_nan(truth.at(k, 0)))) return;
        combine(state.arena.data(), state.probability.data(), x, nullptr);
        Pack *at = &sums[3 * (from + k)];
        for (int a = 0; a < axes; ++a) {
            const Pack p = x[a * c.reported.block] - truth.at(k, a), v = x[a * c.reported.block + 1] - truth.at(k, axes + a);
            at[0] = at[0] + select<Pack>(before, p * p, zero);
            at[1] = at[1] + select<Pack>(before & inverse(is_nan(v)), v * v, zero);
        }
        at[2] = at[2] + select<Pack>(before, splat<Pack>(1.0), zero);
    }
};

}  // namespace

void run_candidates(const Declaration &declaration, const double *numbers, std::int64_t candidates, const BatchInput &in, const double *truth,
                    std::int64_t scans, double *sums, int threads) {
    const std::size_t each = numbers_of(declaration).size();
    over_threads((candidates + lanes - 1) / lanes, threads, [&] {
        return [&](std::int64_t pack) {
            const double *of[lanes];
            const int used = int(std::min<std::int64_t>(lanes, candidates - pack * lanes));
            for (int l = 0; l < lanes; ++l) of[l] = numbers + (pack * lanes + std::min(l, used - 1)) * each;
            const Composition<Pack> composition = in_lanes(declaration, of);
            Lanes worker(composition, in, truth, scans);
            const std::vector<Pack> &found = worker.run();
            for (int l = 0; l < used; ++l)
                for (std::size_t k = 0; k < found.size(); ++k) sums[(pack * lanes + l) * found.size() + k] = lane(found[k], l);
        };
    });
}

}  // namespace jink::inline JINK_LEVEL
