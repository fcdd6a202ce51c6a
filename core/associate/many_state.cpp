// Tracks of known targets, and all tracks as numbers and back.
#include <stdexcept>

#include "associate/many.hpp"
#include "run/batch.hpp"

namespace jink::inline JINK_LEVEL {

std::int64_t Many::add(double t, const double *x, const double *P, double existence) {
    pool.now = std::isnan(time) ? t : time;
    const int slot = pool.take();
    Life &one = pool.life[slot];
    one.age = 0;
    one.id = next_id++, one.existence = existence, one.begun = one.seen = t;
    one.plots = 2, one.confirmed = existence > rules.confirm;
    TrackState<Pack> &s = pool.packs[slot / lanes].state;
    set_prior(*c, s, slot % lanes, x, P, t);
    for (int j = 0; j < c->count; ++j) s.probability[j][slot % lanes] = c->initial_probability[j][slot % lanes];
    s.settled = true;
    if (std::isnan(time)) time = t;
    return one.id;
}

namespace {

// The numbers of a track's life, in one order.
template <class One, class F> void each_of_life(One &one, F f) {
    f(one.id), f(one.code), f(one.existence), f(one.birth), f(one.begun), f(one.seen), f(one.age), f(one.plots), f(one.confirmed), f(one.plot), f(one.share), f(one.outside),
        f(one.beside), f(one.together), f(one.served), f(one.hit), f(one.score), f(one.parent), f(one.parting);
}

}  // namespace

std::vector<double> Many::save() const {
    std::vector<double> out{time, double(next_id), double(pool.slots()), double(sensors.size())};
    for (const SensorView &v : sensors) out.insert(out.end(), {v.clutter, v.undetected, v.arrivals, double(v.scans)});
    for (const Life &one : pool.life) each_of_life(one, [&](const auto &value) { out.push_back(double(value)); });
    for (int s = 0; s < pool.slots(); ++s)
        each_number(pool.packs[s / lanes].state, [&](const Pack &value) { out.push_back(value[s % lanes]); });
    return out;
}

void Many::restore(const std::vector<double> &state) {
    std::size_t at = 0;
    const auto next = [&] {
        if (at >= state.size()) throw std::invalid_argument("state: is cut short, or was saved by another tracker");
        return state[at++];
    };
    time = next(), next_id = std::int64_t(next());
    const int slots = int(next());
    if (int(next()) != int(sensors.size())) throw std::invalid_argument("state: was saved by a tracker with another number of sensors");
    for (SensorView &v : sensors) v.clutter = next(), v.undetected = next(), v.arrivals = next(), v.scans = int(next());
    // All slots are taken, then those that were free are given back, so that the same ones are free again.
    std::vector<Life> lives(slots);
    for (Life &one : lives)
        each_of_life(one, [&](auto &value) { value = static_cast<std::remove_reference_t<decltype(value)>>(next()); });
    pool = Pool(*c);
    pool.now = std::isnan(time) ? 0.0 : time;
    for (int s = 0; s < slots; ++s) pool.take();
    for (int s = 0; s < slots; ++s)
        each_number(pool.packs[s / lanes].state, [&](Pack &value) { value[s % lanes] = next(); });
    for (TrackPack &pack : pool.packs) {
        pack.state.started = pack.state.running = splat_mask<Pack>(true);
        pack.state.settled = true;
    }
    for (int s = 0; s < slots; ++s) {
        if (lives[s].id < 0) pool.give_back(s);
        else pool.life[s] = lives[s];
    }
    if (at != state.size()) throw std::invalid_argument("state: was saved by a tracker with another filter");
}

}  // namespace jink::inline JINK_LEVEL
