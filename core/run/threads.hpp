// Work over threads: items are taken one after the other by whoever is free.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <numeric>
#include <system_error>
#include <thread>
#include <vector>

#include "run/batch.hpp"

namespace jink::inline JINK_LEVEL {

// make() gives each thread its worker; worker(item) does one of `items`. The last exception is thrown again.
template <class Make> void over_threads(std::int64_t items, int threads, Make make) {
    std::atomic<std::int64_t> next{0};
    std::exception_ptr failure;
    std::mutex failing;
    const auto work = [&] {
        try {
            auto worker = make();
            for (std::int64_t item; (item = next.fetch_add(1)) < items;) worker(item);
        } catch (...) {
            const std::lock_guard lock(failing);
            failure = std::current_exception();
        }
    };
    // More threads than this only wait for one another. The system may refuse to start some: the others do their work.
    const int most = 4 * std::max(1, int(std::thread::hardware_concurrency()));
    const int helpers = int(std::min<std::int64_t>({threads, items, most})) - 1;
    std::vector<std::thread> pool;
    try {
        for (int t = 0; t < helpers; ++t) pool.emplace_back(work);
    } catch (const std::system_error &) {
    }
    work();
    for (auto &thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

// The tracks, longest first, so that those of a pack are about as long.
inline std::vector<std::int64_t> longest_first(const BatchInput &in) {
    std::vector<std::int64_t> order(in.tracks);
    std::iota(order.begin(), order.end(), 0);
    const auto length = [&](std::int64_t b) { return in.offsets[b + 1] - in.offsets[b]; };
    const auto longer = [&](std::int64_t a, std::int64_t b) { return length(a) > length(b); };
    if (!std::is_sorted(order.begin(), order.end(), longer)) std::stable_sort(order.begin(), order.end(), longer);
    return order;
}

inline std::int64_t packs_of(const BatchInput &in) { return (in.tracks + lanes - 1) / lanes; }

}  // namespace jink::inline JINK_LEVEL
