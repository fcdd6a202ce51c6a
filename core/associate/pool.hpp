// The tracks that live: packs of slots that are taken and given back, the lowest first, so that packs stay full.
#pragma once

#include <functional>
#include <queue>

#include "scan/step.hpp"

namespace jink::inline JINK_LEVEL {

// One track as the life cycle sees it; its state is lane `slot % lanes` of pack `slot / lanes`.
struct Life {
    std::int64_t id = -1;         // -1: the slot is free
    std::int64_t code = -1;       // identity that its plots have told, -1 for none
    double existence = 0.0;
    double birth = 0.0;           // its existence when it began
    double begun = 0.0, seen = 0.0;  // times of the first and of the last plot
    int age = -1;                 // scans since birth; -1 until the scan of its birth is over
    int plots = 0;                // scans in which it had a plot
    bool confirmed = false;
    bool outside = false;         // of every field of view
    int plot = -1;                // its most probable plot of the last scan, as a row of that scan, or -1
    double share = 0.0;           // probability that it had one of the plots
    std::int64_t beside = -1;     // id of an older track that seems to follow the same target
    int together = 0;             // scans in a row in which it does
    double served = -INFINITY;    // when a sectored antenna last did its sector, or it had a plot
    double hit = -INFINITY;       // when it last had a plot
    double score = 0.0;           // log of what its plots and misses say for it, against their being false; goes on from the parent's
    std::int64_t parent = -1;     // id of the confirmed track whose next plot its first one could have been; until it is confirmed
    double parting = 0.0;         // the parent's score before that plot
    bool due = true;              // this scan looks where it is, and it is not served yet
};

// Only differences of scores matter, from where a branch has parted on: most tracks that begin need none.
inline bool scored(const Life &one) { return one.confirmed || one.plots > 2 || one.parent >= 0; }

struct TrackPack {
    TrackState<Pack> state;
    std::vector<Pack> predicted, prior;  // of the scan that is being worked on
    std::vector<Pack> carry;             // what modes adapt by, as it was before the scan
    Pack dt = splat<Pack>(0.0);          // since the scan before

    explicit TrackPack(const Composition<Pack> &c)
        : state(c), predicted(c.arena_size, splat<Pack>(0.0)), prior(c.count, splat<Pack>(0.0)) {
        // Kernels run over free lanes too, so their numbers must be usable.
        predicted = state.arena, prior = state.probability, carry = state.carry;
    }
};

// Every number of a lane's state, in one order.
template <class State, class F> void each_number(State &s, F f) {
    for (auto *values : {&s.arena, &s.probability, &s.carry, &s.alive, &s.next, &s.memory})
        for (auto &value : *values) f(value);
    f(s.time), f(s.last_accepted), f(s.last_height), f(s.rejections), f(s.first_time);
    for (auto &value : s.first) f(value);
    for (auto &value : s.first_P) f(value);
}

// The numbers of one lane into another.
inline void copy_lane(TrackState<Pack> &from, int a, TrackState<Pack> &to, int b) {
    std::vector<double> numbers;
    each_number(from, [&](const Pack &value) { numbers.push_back(value[a]); });
    auto next = numbers.begin();
    each_number(to, [&](Pack &value) { value[b] = *next++; });
}

class Pool {
  public:
    explicit Pool(const Composition<Pack> &composition) : c(&composition) {}

    std::vector<Life> life;
    std::vector<TrackPack> packs;
    double now = 0.0;  // of the scan that is being worked on

    int slots() const { return int(life.size()); }
    bool live(int slot) const { return life[slot].id >= 0; }
    int living() const { return alive; }

    int take() {
        if (free.empty()) {
            for (int l = 0; l < lanes; ++l) free.push(slots() + l);
            life.resize(life.size() + lanes);
            packs.emplace_back(*c);
            packs.back().state.time = splat<Pack>(now);
        }
        const int slot = free.top();
        free.pop();
        ++alive;
        return slot;
    }
    void give_back(int slot) {
        life[slot] = Life();
        free.push(slot);
        --alive;
    }

    // A second track in the same state, in the midst of a scan.
    int twin(int slot) {
        const int to = take();
        TrackPack &a = packs[slot / lanes], &b = packs[to / lanes];
        const int la = slot % lanes, lb = to % lanes;
        copy_lane(a.state, la, b.state, lb);
        for (std::size_t k = 0; k < a.predicted.size(); ++k) b.predicted[k][lb] = a.predicted[k][la];
        for (std::size_t k = 0; k < a.prior.size(); ++k) b.prior[k][lb] = a.prior[k][la];
        for (std::size_t k = 0; k < a.carry.size(); ++k) b.carry[k][lb] = a.carry[k][la];
        b.dt[lb] = a.dt[la];
        set_lane(b.state.started, lb, true), set_lane(b.state.running, lb, true);
        life[to] = life[slot];
        return to;
    }

    // Packs at the end without a living track go.
    void shrink() {
        std::size_t used = packs.size();
        const auto empty = [&](std::size_t p) {
            return std::none_of(life.begin() + p * lanes, life.begin() + (p + 1) * lanes, [](const Life &one) { return one.id >= 0; });
        };
        while (used > 0 && empty(used - 1)) --used;
        if (used == packs.size()) return;
        packs.erase(packs.begin() + used, packs.end()), life.resize(used * lanes);
        free = Free();
        for (int s = 0; s < slots(); ++s)
            if (!live(s)) free.push(s);
    }

  private:
    using Free = std::priority_queue<int, std::vector<int>, std::greater<int>>;
    const Composition<Pack> *c;
    Free free;
    int alive = 0;
};

}  // namespace jink::inline JINK_LEVEL
