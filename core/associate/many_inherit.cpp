// The name of a track that has lost its target goes to the new track that has found it.
#include <unordered_map>
#include <utility>

#include "associate/many.hpp"

namespace jink::inline JINK_LEVEL {

// Heirs are tracks that have just been confirmed and whose first plot could have been the next one of an older track. Which of the two
// is how that track went on? Their scores say: what their plots and misses since then say for each. If the heir's is higher, it takes
// the id, and the other one is what it would be had it begun at the parting: mostly a track of false plots, which soon ends.
void Many::inherit(const std::vector<int> &heirs, ScanReport &report) {
    std::unordered_map<std::int64_t, int> slot_of;
    for (int s : heirs) slot_of[pool.life[s].parent] = -1;
    for (int s = 0; s < pool.slots(); ++s)
        if (pool.live(s) && pool.life[s].plots > 1)
            if (const auto found = slot_of.find(pool.life[s].id); found != slot_of.end()) found->second = s;
    for (int s : heirs) {
        Life &one = pool.life[s];
        const std::int64_t id = std::exchange(one.parent, -1), own = one.id;
        const auto found = slot_of.find(id);
        if (found->second < 0) continue;
        const int other = found->second;
        Life &elder = pool.life[other];
        const bool strangers = one.code >= 0 && elder.code >= 0 && one.code != elder.code;
        if (strangers || !(one.score > elder.score + rules.inherit)) continue;
        std::swap(one.id, elder.id), std::swap(one.begun, elder.begun), std::swap(one.age, elder.age);
        found->second = s;
        // It may be the parent of another heir itself.
        if (const auto now = slot_of.find(own); now != slot_of.end()) now->second = other;
        report.handed.push_back({id, own}), report.handed.push_back({own, id});
        const double odds = one.birth / (1.0 - one.birth) * std::exp(elder.score - one.parting);
        elder.existence = std::min(elder.existence, odds / (1.0 + odds));
        const bool ends = elder.confirmed && !(elder.existence > rules.confirm);
        report.confirmed -= ends, elder.confirmed = elder.confirmed && !ends;
    }
}

}  // namespace jink::inline JINK_LEVEL
