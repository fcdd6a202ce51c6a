// Two tracks that follow one target: after some scans within d² < 1 of each other the younger one ends.
#include <cmath>

#include "associate/many.hpp"

namespace jink::inline JINK_LEVEL {

// Position of a track, where it is at the time of the scan, and its covariance, as the mean over its modes.
void Many::place(int s) {
    const int l = s % lanes;
    const TrackState<Pack> &state = pool.packs[s / lanes].state;
    const double since = pool.now - state.time[l];
    Place at{0.0, 0.0, 0.0, 0.0, 0.0, s};
    for (int j = 0; j < c->count; ++j) {
        const Mode<Pack> &mode = c->modes[j];
        const Pack *x = &state.arena[mode.place], *P = x + mode.shape.n;
        const double w = state.probability[j][l];
        const int y = mode.shape.axes > 1 ? mode.shape.block : 0;
        at.x += w * (x[0][l] + since * x[1][l]), at.y += w * (x[y][l] + since * x[y + 1][l]);
        at.xx += w * P[packed(0, 0)][l], at.xy += w * P[packed(y, 0)][l], at.yy += w * P[packed(y, y)][l];
    }
    places.push_back(at);
}

// A scan counts if the two are within d² < merge_within, and did not have a plot each: then they are two targets.
void Many::merge(ScanReport &report) {
    places.clear();
    double widest = 0.0;
    for (int s = 0; s < pool.slots(); ++s) {
        const Life &one = pool.life[s];
        if (!pool.live(s) || !(one.existence > rules.established) || one.plots < 2) continue;
        place(s);
        widest = std::max(widest, places.back().xx);
    }
    std::sort(places.begin(), places.end(), [](const Place &a, const Place &b) { return a.x != b.x ? a.x < b.x : a.slot < b.slot; });
    std::vector<int> ended;
    found.assign(pool.slots(), {-1, 0});
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double reach = std::sqrt(rules.merge_within * (places[i].xx + widest));
        for (std::size_t j = i + 1; j < places.size() && places[j].x - places[i].x < reach; ++j) {
            const Place &a = places[i], &b = places[j];
            const double dx = b.x - a.x, dy = b.y - a.y, xx = a.xx + b.xx, xy = a.xy + b.xy, yy = a.yy + b.yy;
            if (dx * dx > rules.merge_within * xx) continue;  // one axis alone is too far
            const double det = xx * yy - xy * xy;
            if (!(yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy < rules.merge_within * det)) continue;
            const Life &one = pool.life[a.slot], &other = pool.life[b.slot];
            const auto plot = [&](const Life &each) { return sector.whole() ? each.share > 0.5 : pool.now - each.hit < sector.period; };
            if (plot(one) && plot(other)) continue;
            // The one that began first stays; ids are in the order of birth.
            const bool first = one.id < other.id;
            const Life &older = first ? one : other, &younger = first ? other : one;
            const bool again = younger.beside == older.id;
            auto &best = found[first ? b.slot : a.slot];
            const int count = again ? younger.together + 1 : 1;
            if (count > best.second) best = {older.id, count};
        }
    }
    for (const Place &at : places) {
        Life &one = pool.life[at.slot];
        one.beside = found[at.slot].first, one.together = found[at.slot].second;
        if (one.together >= rules.merge_after) ended.push_back(at.slot);
    }
    for (int s : ended) {
        report.confirmed -= pool.life[s].confirmed;
        pool.give_back(s);
    }
    report.merged = int(ended.size());
    report.dropped += report.merged;
}

}  // namespace jink::inline JINK_LEVEL
