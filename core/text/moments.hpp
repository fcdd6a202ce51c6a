// Dates and moments as ISO 8601 writes them.
#pragma once

#include "text/decimal.hpp"

namespace jink::text {

// A number of so many digits at least.
inline char *put_padded(char *to, std::uint64_t n, int digits) {
    char text[24];
    const int count = int(put_whole(text, n) - text);
    for (; digits > count; --digits) *to++ = '0';
    return std::memcpy(to, text, 24), to + count;
}

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
    to = put_padded(to, std::uint64_t(std::abs(full_year)), 4), *to++ = '-';
    to = put_padded(to, std::uint64_t(month), 2), *to++ = '-';
    return put_padded(to, std::uint64_t(day_of_year - (153 * from_march + 2) / 5 + 1), 2);
}

// A moment in UTC, `unit` to a second, counted from 1970, to the microsecond below.
inline char *put_time(char *to, std::int64_t value, std::int64_t unit) {
    const std::int64_t seconds = floor_divided(value, unit), days = floor_divided(seconds, 86400), second = seconds - days * 86400;
    to = put_date(to, days), *to++ = 'T';
    to = put_padded(to, std::uint64_t(second / 3600), 2), *to++ = ':';
    to = put_padded(to, std::uint64_t(second / 60 % 60), 2), *to++ = ':';
    to = put_padded(to, std::uint64_t(second % 60), 2), *to++ = '.';
    to = put_padded(to, std::uint64_t((value - seconds * unit) * 1'000'000 / unit), 6);
    return *to++ = 'Z', to;
}

}  // namespace jink::text
