// Sugeno rules over a residual and its change: the variance of the process noise they call for.
//
// Rule i fires with exp(-((r - c1)/s1)^2/2 - ((dr - c2)/s2)^2/2) and says w; the answer is the mean of the w's weighted by the
// firing strengths, so it lies between the least and the largest w. Far from every centre all strengths underflow to 0/0; here
// they are taken relative to the strongest, in logarithms, and the nearest rule decides.
#pragma once

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int fuzzy_fields = 5;  // per rule: c1, 1/s1, c2, 1/s2, w
inline constexpr int rules_kept = 64;   // whose firing strengths are not computed twice

template <class T> JINK_INLINE T log_firing(const T *rule, T r, T dr) {
    const T a = (r - rule[0]) * rule[1], b = (dr - rule[2]) * rule[3];
    return -0.5 * (a * a + b * b);
}

// A lane that has fewer rules than `rules` fills its table with rules at `nowhere`. A missing residual (NaN) gives NaN.
inline constexpr double nowhere[fuzzy_fields] = {1e150, 1.0, 0.0, 1.0, 0.0};

template <class T> JINK_INLINE T fuzzy_variance(int rules, const T *table, T r, T dr) {
    if (rules == 1) return select<T>(is_nan(r), r, table[4]);
    T kept[rules_kept], strongest = log_firing<T>(table, r, dr);
    kept[0] = strongest;
    for (int i = 1; i < rules; ++i) {
        const T fires = log_firing<T>(table + i * fuzzy_fields, r, dr);
        if (i < rules_kept) kept[i] = fires;
        strongest = larger<T>(strongest, fires);
    }
    T weight = splat<T>(0.0), sum = splat<T>(0.0);
    for (int i = 0; i < rules; ++i) {
        const T *rule = table + i * fuzzy_fields;
        const T fires = exponential<T>((i < rules_kept ? kept[i] : log_firing<T>(rule, r, dr)) - strongest);
        weight = weight + fires;
        sum = sum + fires * rule[4];
    }
    return sum / weight;
}

}  // namespace jink::inline JINK_LEVEL
