// Dates and moments as ISO 8601 writes them.
#pragma once

#include "text/decimal.hpp"

namespace jink::inline JINK_LEVEL::text {

inline char *put_two(char *to, std::int64_t n) { return to[0] = char('0' + n / 10), to[1] = char('0' + n % 10), to + 2; }

inline std::int64_t floor_divided(std::int64_t n, std::int64_t by) { return n / by - (n % by < 0); }

// A day, counted from 1970-01-01, of the Gregorian calendar (Howard Hinnant, "chrono-compatible low-level date algorithms", 2013). Years have four
// digits; others than 0 to 9999 a sign as well.
inline char *put_date(char *to, std::int64_t days) {
    days += 719468;  // from the first of March of the year 0
    const std::int64_t era = floor_divided(days, 146097), day = days - era * 146097;
    const std::int64_t year = (day - day / 1460 + day / 36524 - day / 146096) / 365, day_of_year = day - (365 * year + year / 4 - year / 100);
    const std::int64_t from_march = (5 * day_of_year + 2) / 153, month = from_march < 10 ? from_march + 3 : from_march - 9;
    const std::int64_t full_year = year + era * 400 + (month <= 2);
    if (full_year < 0 || full_year > 9999) *to++ = full_year < 0 ? '-' : '+';
    const std::int64_t shown = std::abs(full_year);
    to = shown > 9999 ? put_whole(to, shown) : put_two(put_two(to, shown / 100), shown % 100), *to++ = '-';
    to = put_two(to, month), *to++ = '-';
    return put_two(to, day_of_year - (153 * from_march + 2) / 5 + 1);
}

// A moment in UTC, `unit` to a second, counted from 1970, to the microsecond below.
inline char *put_time(char *to, std::int64_t value, std::int64_t unit) {
    const std::int64_t seconds = floor_divided(value, unit), days = floor_divided(seconds, 86400), second = seconds - days * 86400;
    const std::int64_t rest = value % unit, micro = (rest < 0 ? rest + unit : rest) * 1'000'000 / unit;
    to = put_date(to, days), *to++ = 'T';
    to = put_two(to, second / 3600), *to++ = ':';
    to = put_two(to, second / 60 % 60), *to++ = ':';
    to = put_two(to, second % 60), *to++ = '.';
    to = put_two(put_two(put_two(to, micro / 10000), micro / 100 % 100), micro % 100);
    return *to++ = 'Z', to;
}

}  // namespace jink::inline JINK_LEVEL::text
