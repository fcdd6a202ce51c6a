// Slots: what runs, where a scan's modes are chosen from a larger set (propose.hpp).
//
// If all modes of the set are of one motion model they differ in numbers only, and a slot takes on the numbers of its mode, lane by
// lane, so that the cost is that of the slots; else every mode has a slot of its own, and those of no lane's choice are passed over.
#pragma once

#include "scan/track.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> Mask<T> living(T place) { return place >= splat<T>(0.0); }

template <class T> class SlotNumbers {
  public:
    explicit SlotNumbers(const Composition<T> &composition) : c(composition) {
        const auto &modes = c.declared.modes;
        if (!c.proposes() || own()) return;
        taken.assign(c.count, nan_of<T>());
        level_at = int(modes[0].parameters.size());
        std::size_t levels = 0;
        for (const auto &m : modes) levels = std::max(levels, m.level.size());
        fields = level_at + int(levels);
        table.assign(modes.size() * fields, 0.0);
        for (std::size_t m = 0; m < modes.size(); ++m) {
            std::copy(modes[m].parameters.begin(), modes[m].parameters.end(), &table[m * fields]);
            std::copy(modes[m].level.begin(), modes[m].level.end(), &table[m * fields + level_at]);
        }
        for (int k = 0; k < c.count * fields; ++k) numbers.push_back(splat<T>(table[k]));
    }

    // Has every mode a slot of its own? A grid's points lie between modes, so they never have.
    bool own() const { return c.count == c.members() && c.declared.propose.kind != Propose::grid; }

    const T *parameters(int j) const { return own() ? c.modes[j].parameters.data() : &numbers[j * fields]; }
    const T *level(int j) const {
        if (own()) return c.modes[j].level.empty() ? nullptr : c.modes[j].level.data();
        return fields > level_at ? &numbers[j * fields + level_at] : nullptr;
    }

    // Slot j takes on the numbers of its next mode, in the lanes where that is another one than before; false if in none. Between
    // two modes in proportion.
    bool load(const TrackState<T> &s, int j) {
        if (own()) return false;
        const Mask<T> stale = inverse(s.next[j] == taken[j]);
        if (!any(stale)) return false;
        taken[j] = s.next[j];
        for (int l = 0; l < width<T>; ++l) {
            const double at = lane(taken[j], l);
            if (!lane(stale, l) || at < 0.0) continue;  // of a slot without a mode whatever was there
            const int low = int(at), high = std::min(low + 1, c.members() - 1);
            const double above = at - low, *a = &table[low * fields], *b = &table[high * fields];
            for (int k = 0; k < fields; ++k) set_lane(numbers[j * fields + k], l, a[k] + above * (b[k] - a[k]));
        }
        return true;
    }

  private:
    const Composition<T> &c;
    int fields = 0, level_at = 0;  // numbers of a mode: its parameters, then its level
    std::vector<double> table;     // of every mode
    std::vector<T> numbers;        // of every slot
    std::vector<T> taken;          // the mode that each slot's numbers are of
};

}  // namespace jink::inline JINK_LEVEL
