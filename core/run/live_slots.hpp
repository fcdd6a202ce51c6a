// Live targets that come and go: each has a slot, and a slot is used again when its target has gone.
//
// A slot is the numbers of one track. Rows of different slots are taken into the lanes of a pack, stepped, and put back, so that a
// row costs a lane of a pack whichever targets come together.
#pragma once

#include <algorithm>

#include "run/live.hpp"

namespace jink::inline JINK_LEVEL {

class Slots : public Live<Pack> {
  public:
    explicit Slots(std::shared_ptr<const Composition<Pack>> composition)
        : Live<Pack>(std::move(composition), lanes, 0), size(numbers()), fresh(size) {
        exchange(states[0], 0, fresh.data(), false);
    }

    // New targets start from this state instead of their first positions.
    void begin_all(const double *x, const double *P) {
        set_prior(*c, states[0], 0, x, P, NAN);
        exchange(states[0], 0, fresh.data(), false);
    }

    int take() {
        int slot = int(used.size());
        if (unused.empty()) used.push_back(1), store.resize(store.size() + size);
        else slot = unused.back(), unused.pop_back(), used[slot] = 1;
        std::copy(fresh.begin(), fresh.end(), &store[std::size_t(slot) * size]);
        return slot;
    }

    void release(int slot) { used[slot] = 0, unused.push_back(slot); }
    bool taken(int slot) const { return slot >= 0 && slot < int(used.size()) && used[slot]; }
    int in_use() const { return int(used.size() - unused.size()); }

    // Up to `lanes` rows of different slots.
    void step_rows(const std::int32_t *slot, int rows, const double *time, const double *z, Snapshot<Pack> &out) {
        n = rows;
        TrackState<Pack> &s = states[0];
        for (int l = 0; l < rows; ++l) {
            exchange(s, l, &store[std::size_t(slot[l]) * size], true);
            if (lane(s.started, l) && time[l] < lane(s.time, l))
                throw std::invalid_argument("t: lies before the slot's last update; updates must come in the order of time");
        }
        s.settled = all(s.running);
        update(0, {time, false, z}, with_nis, out);
        for (int l = 0; l < rows; ++l) exchange(s, l, &store[std::size_t(slot[l]) * size], false);
    }

  private:
    std::size_t size;
    std::vector<double> fresh, store;
    std::vector<char> used;
    std::vector<int> unused;
};

}  // namespace jink::inline JINK_LEVEL
