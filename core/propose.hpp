// Propose: which modes of a set too large to run whole are alive in a scan.
//
// A track has a few slots. `alive` says which mode each slot was in the last scan, `next` which it will be; -1 is none. If all
// modes of the set are of one motion model they differ in numbers only, and a slot takes on the numbers of its mode, lane by lane,
// so that the cost is that of the slots; else every mode has a slot of its own, and those of no lane's choice are passed over.
// From one scan to the next, sources are the modes alive before, targets those alive now (Li & Bar-Shalom, IEEE Trans. AC-41(4),
// 1996): mode i stays with its own probability, and the rest goes to those it may change to that are alive, in proportion.
//   digraph    the neighbours of the likeliest mode. Li & Bar-Shalom, 1996: digraph switching.
//   active     the likeliest modes of the next scan, as predicted over the whole graph. Li, Zwi & Zhang, IEEE Trans. AES-35(1), 1999.
//   grid       three points of an ordered set, about the mean of the last three. Jilkov, Angelova & Semerdjiev, IEEE Trans. AES-35(1), 1999.
//   dimension  constant velocity or constant acceleration, as a detector switches (variable_dimension.hpp).
#pragma once

#include "track.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> Mask<T> living(T place) { return place >= splat<T>(0.0); }

template <class T> class Proposal {
  public:
    explicit Proposal(const Composition<T> &composition) : c(composition), d(c.declared), slots(c.count), all(c.members()) {
        if (!c.proposes()) return;
        own_slots = slots == all && d.propose.kind != Propose::grid;
        taken.assign(slots, nan_of<T>());
        for (int j = 0; j < slots; ++j) {
            parameters_of.push_back(Composition<T>::numbers(d.modes[j].parameters));
            levels_of.push_back(Composition<T>::numbers(d.modes[j].level));
        }
        reached.resize(all);
    }

    const T *parameters(int j) const { return own_slots ? c.modes[j].parameters.data() : parameters_of[j].data(); }
    const T *level(int j) const { return levels_of[j].empty() ? nullptr : levels_of[j].data(); }

    // The slots' numbers for this scan; false where they are those of the last one. Between two modes (a grid's points lie
    // anywhere) in proportion.
    bool load(const TrackState<T> &s) {
        if (own_slots) return false;
        bool changed = false;
        for (int j = 0; j < slots; ++j) {
            if (all_same(s.next[j], taken[j])) continue;
            taken[j] = s.next[j], changed = true;
            for (int l = 0; l < width<T>; ++l) load_lane(j, l, lane(s.next[j], l));
        }
        return changed;
    }

    // Pi (slots x slots) over dt: from `alive` to `next`. A continuous chain changes at most once in a step.
    void transition(const TrackState<T> &s, T dt, T *pi) const {
        for (int l = 0; l < width<T>; ++l)
            for (int i = 0; i < slots; ++i) {
                double row[largest_set];
                const int from = int(lane(s.alive[i], l));
                if (from >= 0) row_of(s, l, i, from, lane(dt, l), row);
                for (int j = 0; j < slots; ++j) set_lane(pi[i * slots + j], l, from >= 0 ? row[j] : 0.0);
            }
    }

    // After a scan: `alive` is what was run, `next` what will be.
    void choose(TrackState<T> &s, Mask<T> which) {
        for (int l = 0; l < width<T>; ++l) {
            if (!lane(which, l)) continue;
            for (int j = 0; j < slots; ++j) set_lane(s.alive[j], l, lane(s.next[j], l));
            if (d.propose.kind == Propose::digraph) neighbours_of_likeliest(s, l);
            else if (d.propose.kind == Propose::active) likeliest(s, l);
            else if (d.propose.kind == Propose::grid) regrid(s, l);
        }
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
    const Composition<T> &c;
    const Declaration &d;
    int slots, all;
    bool own_slots = true;
    std::vector<std::vector<T>> parameters_of, levels_of;
    std::vector<T> taken;
    std::vector<double> reached;

    static bool all_same(T a, T b) { return jink::all(a == b); }

    void load_lane(int j, int l, double at) {
        if (at < 0) return;  // whatever was there
        const int low = int(at), high = std::min(low + 1, all - 1);
        const double above = at - low;
        const auto between = [&](const std::vector<double> &a, const std::vector<double> &b, std::vector<T> &to) {
            for (std::size_t k = 0; k < a.size(); ++k) set_lane(to[k], l, a[k] + above * (b[k] - a[k]));
        };
        between(d.modes[low].parameters, d.modes[high].parameters, parameters_of[j]);
        between(d.modes[low].level, d.modes[high].level, levels_of[j]);
    }

    // Row of source slot i in mode `from` (of a grid: in the role i), over dt.
    void row_of(const TrackState<T> &s, int l, int i, int from, double dt, double *row) const {
        const bool grid = d.propose.kind == Propose::grid;
        const int m = grid ? slots : all, origin = grid ? i : from;
        const double *declared = &d.transition[origin * m];
        double stay = dt > 0.0 ? declared[origin] : 1.0, total = 0.0;
        if (d.continuous) stay = dt > 0.0 ? std::exp(declared[origin] * dt) : 1.0;
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

    int best_slot(const TrackState<T> &s, int l) const {
        int best = 0;
        for (int j = 1; j < slots; ++j)
            if (lane(s.alive[best], l) < 0 || (lane(s.alive[j], l) >= 0 && lane(s.probability[j], l) > lane(s.probability[best], l))) best = j;
        return best;
    }

    void put(TrackState<T> &s, int l, const int *members, int count) const {
        for (int j = 0; j < slots; ++j) set_lane(s.next[j], l, -1.0);
        for (int k = 0; k < count; ++k) set_lane(s.next[own_slots ? members[k] : k], l, members[k]);
    }

    void neighbours_of_likeliest(TrackState<T> &s, int l) const {
        const auto &near = d.propose.neighbours[int(lane(s.alive[best_slot(s, l)], l))];
        put(s, l, near.data(), int(near.size()));
    }

    // numbers[0]: how many
    void likeliest(TrackState<T> &s, int l) {
        int candidates[largest_set * 8], found = 0;
        for (int i = 0; i < slots; ++i) {
            const int from = int(lane(s.alive[i], l));
            if (from < 0) continue;
            for (int to : d.propose.neighbours[from]) {
                const double row = d.continuous && to == from ? 1.0 + d.transition[from * all + to] : d.transition[from * all + to];
                if (reached[to] == 0.0 && found < largest_set * 8) candidates[found++] = to;
                reached[to] += std::max(row, 1e-300) * std::max(lane(s.probability[i], l), 1e-300);
            }
        }
        const int keep = std::min(found, int(d.propose.numbers[0]));
        std::partial_sort(candidates, candidates + keep, candidates + found, [&](int a, int b) {
            return reached[a] != reached[b] ? reached[a] > reached[b] : a < b;
        });
        std::sort(candidates, candidates + keep);
        for (int k = 0; k < found; ++k) reached[candidates[k]] = 0.0;
        put(s, l, candidates, keep);
    }

    // numbers: least distance of two points, the probability below which an outer point comes nearer, and above which it goes out
    void regrid(TrackState<T> &s, int l) const {
        const double least = d.propose.numbers[0], unlikely = d.propose.numbers[1], likely = d.propose.numbers[2];
        double at[3], p[3];
        for (int j = 0; j < 3; ++j) at[j] = lane(s.alive[j], l), p[j] = lane(s.probability[j], l);
        const double centre = p[0] * at[0] + p[1] * at[1] + p[2] * at[2];
        const auto step = [&](double before, double mine) {
            const double now = mine < unlikely ? 0.5 * before : mine > likely ? 2.0 * before : before;
            return std::max(now, least);
        };
        const double left = step(at[1] - at[0], p[0]), right = step(at[2] - at[1], p[2]), last = all - 1;
        const double middle = std::clamp(centre, least, last - least);
        set_lane(s.next[1], l, middle);
        set_lane(s.next[0], l, std::max(middle - left, 0.0));
        set_lane(s.next[2], l, std::min(middle + right, last));
    }
};

}  // namespace jink::inline JINK_LEVEL
