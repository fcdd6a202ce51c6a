// What updates of many live tracks leave, as rows of NumPy's arrays.
#pragma once

#include "bindings/bindings.hpp"
#include "run/live.hpp"

namespace jink::inline JINK_LEVEL {

// Of every mode of the set, of which a track may run a few.
template <class T> std::vector<T> set_probability(const Composition<T> &c, const Snapshot<T> &s) {
    if (!c.proposes()) return s.probability;
    std::vector<T> all(c.members());
    Proposal<T>(c).spread(s.alive, s.probability.data(), all.data());
    return all;
}

// x, P, mode probability, log-likelihood, NIS, its degrees of freedom, time (null where not wanted) and status of `used` lanes,
// the first of which is row `first`.
inline void write_results(const Composition<Pack> &c, const Snapshot<Pack> &s, Combine<Pack> &combine, int first, int used, double *const *to,
                          unsigned char *status) {
    const int n = c.reported.n, m = c.members();
    Pack x[largest_state], P[packed_size(largest_state)];
    if (to[0] || to[1]) combine(s.arena.data(), s.probability.data(), x, to[1] ? P : nullptr);
    if (to[0] || to[1]) corrected(s.correction, x, to[1] ? P : nullptr);
    const std::vector<Pack> probability = set_probability(c, s);
    for (int l = 0; l < used; ++l) {
        const std::size_t at = std::size_t(first) + l;
        const bool live = lane(s.started, l);
        const Outcome<Pack> &o = s.outcome;
        for (int r = 0; r < n && to[0]; ++r) to[0][at * n + r] = live ? x[r][l] : NAN;
        for (int r = 0; r < n && to[1]; ++r)
            for (int q = 0; q < n; ++q) to[1][(at * n + r) * n + q] = live ? P[packed(r, q)][l] : NAN;
        for (int j = 0; j < m && to[2]; ++j) to[2][at * m + j] = live ? probability[j][l] : NAN;
        const bool scored = lane(o.scored, l);
        if (to[3]) to[3][at] = o.log_likelihood[l];
        if (to[4]) to[4][at] = scored ? o.nis[l] : NAN;
        if (to[5]) to[5][at] = scored ? o.dof[l] : 0.0;
        if (to[6]) to[6][at] = s.time[l];
        status[at] = static_cast<unsigned char>(!live ? Status::none
                     : lane(o.initialised, l) ? (lane(o.restarted, l) ? Status::restarted : Status::initialised)
                     : lane(o.gated, l) ? Status::gated
                     : lane(o.measured, l) ? Status::updated : Status::predicted);
    }
}

}  // namespace jink::inline JINK_LEVEL
