// Propose: which modes of a set too large to run whole are alive in a scan.
//
// A track has a few slots (slots.hpp). `alive` says which mode each slot was in the last scan, `next` which it will be; -1 is none.
// From one scan to the next, sources are the modes alive before, targets those alive now (Li & Bar-Shalom, IEEE Trans. AC-41(4),
// 1996): mode i stays with its own probability, and the rest goes to those it may change to that are alive, in proportion.
//   digraph    the neighbours of the likeliest mode. Li & Bar-Shalom, 1996: digraph switching.
//   active     the likeliest modes of the next scan, as predicted over the whole graph. Li, Control and Dynamic Systems 76, 1996.
//   grid       three points of an ordered set, about the mean of the last three. Jilkov, Angelova & Semerdjiev, IEEE Trans. AES-35(1), 1999.
//   dimension  constant velocity or constant acceleration, as a detector switches (variable_dimension.hpp).
#pragma once

#include "scan/slots.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Proposal {
  public:
    explicit Proposal(const Composition<T> &composition);

    SlotNumbers<T> numbers;

    // Pi (slots x slots) over dt: from `alive` to `next`, in the lanes where it is not what it was. A continuous chain changes at
    // most once in a step.
    void transition(const TrackState<T> &s, T dt, T *pi) {
        Mask<T> stale = inverse(dt == seen_dt);
        for (int j = 0; j < slots && d.propose.kind != Propose::grid; ++j)  // a grid's points keep their roles
            stale = stale | inverse(s.alive[j] == seen_alive[j]) | inverse(s.next[j] == seen_next[j]);
        if (!any(stale)) return;
        seen_dt = dt, seen_alive = s.alive, seen_next = s.next;
        for (int l = 0; l < width<T>; ++l)
            for (int i = 0; lane(stale, l) && i < slots; ++i) {
                double row[largest_set];
                const int from = int(lane(s.alive[i], l));
                if (from >= 0) row_of(s, l, i, from, lane(dt, l), row);
                for (int j = 0; j < slots; ++j) set_lane(pi[i * slots + j], l, from >= 0 ? row[j] : 0.0);
            }
    }

    // After a scan: `alive` is what was run; a grid's next points are known.
    void close(TrackState<T> &s, Mask<T> which) const {
        for (int j = 0; j < slots; ++j) s.alive[j] = select<T>(which, s.next[j], s.alive[j]);
        if (d.propose.kind == Propose::grid) regrid(s, which);
    }

    // Before a scan, when the elapsed time is known: the next modes of a graph. Over no time the same stay alive.
    void choose(TrackState<T> &s, T dt) {
        if (d.propose.kind == Propose::digraph) neighbours_of_likeliest(s);
        else if (d.propose.kind == Propose::active) {
            for (int l = 0; l < width<T>; ++l) likeliest(s, l, lane(dt, l));
        } else return;
        for (int j = 0; j < slots; ++j) s.next[j] = select<T>(dt > splat<T>(0.0), chosen[j], s.alive[j]);
    }

    // Probabilities of all modes of the set, from those of the slots.
    void spread(const std::vector<T> &places, const T *probability, T *out) const {
        for (int m = 0; m < all; ++m) out[m] = splat<T>(0.0);
        for (int l = 0; l < width<T>; ++l)
            for (int j = 0; j < slots; ++j) {
                const double at = lane(places[j], l), p = lane(probability[j], l);
                if (at < 0) continue;
                const int low = int(at);
                const double above = at - low;
                set_lane(out[low], l, lane(out[low], l) + (1.0 - above) * p);
                if (above > 0.0) set_lane(out[low + 1], l, lane(out[low + 1], l) + above * p);
            }
    }

  private:
    static constexpr int largest_set = 64;  // slots
    struct Edge {
        int from, to;
        double share;  // of the declared transition
    };
    const Composition<T> &c;
    const Declaration &d;
    int slots, all;
    std::vector<T> seen_alive, seen_next, chosen;
    T centre, seen_dt;
    std::vector<Edge> edges;      // of the active digraph, to other modes, mode after mode,
    std::vector<int> first_edge;  // where each mode's begin
    std::vector<double> leaving;  // of each mode: the shares of its edges together
    std::vector<double> reached;  // probability of each mode in the next scan, -1 of those that none may change to
    std::vector<int> candidates;  // the others

    // Row of source slot i in mode `from` (of a grid: in the role i), over dt.
    void row_of(const TrackState<T> &s, int l, int i, int from, double dt, double *row) const {
        const bool grid = d.propose.kind == Propose::grid;
        const int m = grid ? slots : all, origin = grid ? i : from;
        const double *declared = &d.transition[origin * m];
        double stay = staying(declared[origin], dt), total = 0.0;
        int itself = -1, alive_now = 0;
        for (int j = 0; j < slots; ++j) {
            const int to = grid ? j : int(lane(s.next[j], l));
            row[j] = to < 0 || to == origin ? 0.0 : declared[to];
            if (to == origin) itself = j;
            alive_now += to >= 0;
            total += row[j];
        }
        if (itself < 0) stay = 0.0;
        else if (total <= 0.0) stay = 1.0;
        for (int j = 0; j < slots; ++j) {
            const int to = grid ? j : int(lane(s.next[j], l));
            if (j == itself) row[j] = stay;
            else if (total > 0.0) row[j] *= (1.0 - stay) / total;
            else if (itself < 0 && to >= 0) row[j] = 1.0 / alive_now;
        }
    }

    // From a diagonal element of the transition, or of its generator.
    double staying(double element, double dt) const {
        if (dt <= 0.0) return 1.0;
        return d.continuous ? std::exp(element * dt) : element;
    }

    void put(int l, const int *members, int count) {
        for (int j = 0; j < slots; ++j) set_lane(chosen[j], l, -1.0);
        for (int k = 0; k < count; ++k) set_lane(chosen[numbers.own() ? members[k] : k], l, members[k]);
    }

    void neighbours_of_likeliest(const TrackState<T> &s) {
        T best = splat<T>(-1.0), most = best;
        for (int j = 0; j < slots; ++j) {
            const Mask<T> better = living(s.alive[j]) & (inverse(living(best)) | (s.probability[j] > most));
            best = select<T>(better, s.alive[j], best), most = select<T>(better, s.probability[j], most);
        }
        const Mask<T> stale = inverse(best == centre);
        if (!any(stale)) return;
        centre = best;
        for (int l = 0; l < width<T>; ++l) {
            if (!lane(stale, l) || lane(best, l) < 0.0) continue;
            const auto &near = d.propose.neighbours[int(lane(best, l))];
            put(l, near.data(), int(near.size()));
        }
    }

    // numbers[0]: how many
    void likeliest(const TrackState<T> &s, int l, double dt) {
        int found = 0, kept = 0, best[largest_set];
        const auto reach = [&](int to, double share) {
            if (reached[to] < 0.0) reached[to] = 0.0, candidates[found++] = to;
            reached[to] += share;
        };
        for (int i = 0; i < slots; ++i) {
            const int from = int(lane(s.alive[i], l));
            if (from < 0) continue;
            const double p = std::max(lane(s.probability[i], l), 1e-300), stay = staying(d.transition[from * all + from], dt);
            double over = 1.0;
            if (d.continuous) over = leaving[from] > 0.0 ? (1.0 - stay) / leaving[from] : 0.0;
            reach(from, stay * p);
            for (int e = first_edge[from]; e < first_edge[from + 1]; ++e) reach(edges[e].to, over * edges[e].share * p);
        }
        const int keep = std::min(found, int(d.propose.numbers[0]));
        const auto before = [&](int a, int b) { return reached[a] != reached[b] ? reached[a] > reached[b] : a < b; };
        for (int k = 0; k < found; ++k) {
            int at = kept < keep ? kept++ : keep;
            for (; at > 0 && before(candidates[k], best[at - 1]); --at)
                if (at < keep) best[at] = best[at - 1];
            if (at < keep) best[at] = candidates[k];
        }
        for (int k = 0; k < found; ++k) reached[candidates[k]] = -1.0;
        std::sort(best, best + keep);
        put(l, best, keep);
    }

    // numbers: least distance of two points, the probability below which an outer point comes nearer, and above which it goes out
    void regrid(TrackState<T> &s, Mask<T> which) const {
        const T least = splat<T>(d.propose.numbers[0]), unlikely = splat<T>(d.propose.numbers[1]), likely = splat<T>(d.propose.numbers[2]);
        const T *at = s.alive.data(), *p = s.probability.data(), last = splat<T>(all - 1.0);
        const auto step = [&](T before, T mine) {
            return larger<T>(select<T>(mine < unlikely, 0.5 * before, select<T>(mine > likely, 2.0 * before, before)), least);
        };
        const T left = step(at[1] - at[0], p[0]), right = step(at[2] - at[1], p[2]);
        const T middle = smaller<T>(larger<T>(p[0] * at[0] + p[1] * at[1] + p[2] * at[2], least), last - least);
        const T to[3] = {larger<T>(middle - left, splat<T>(0.0)), middle, smaller<T>(middle + right, last)};
        for (int j = 0; j < 3; ++j) s.next[j] = select<T>(which, to[j], s.next[j]);
    }
};

template <class T>
Proposal<T>::Proposal(const Composition<T> &composition)
    : numbers(composition), c(composition), d(c.declared), slots(c.count), all(c.members()) {
    if (!c.proposes()) return;
    const T unknown = nan_of<T>();
    chosen.assign(slots, unknown), centre = seen_dt = unknown;
    seen_alive.assign(slots, unknown), seen_next.assign(slots, unknown);
    if (d.propose.kind != Propose::active) return;
    reached.assign(all, -1.0), leaving.assign(all, 0.0), candidates.resize(all);
    for (int i = 0; i < all; ++i)
        for (int to : d.propose.neighbours[i]) {
            if (to != i) edges.push_back({i, to, d.transition[i * all + to]});
            if (to != i) leaving[i] += edges.back().share;
        }
    for (int i = 0, e = 0; i <= all; first_edge.push_back(e), ++i)
        while (e < int(edges.size()) && edges[e].from < i) ++e;
}

}  // namespace jink::inline JINK_LEVEL
