// Numbers as text: the shortest that reads back as the same number, bit for bit.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace jink::inline JINK_LEVEL::text {

inline constexpr int longest_number = 40;

template <class N> char *put_whole(char *to, N n) { return std::to_chars(to, to + longest_number, n).ptr; }

// A finite number, with a point or an exponent: 1.0, 0.00012, 1e-7, 1.5e+22. Writes up to 40 bytes.
template <class Real> char *put_real(char *to, Real value) {
    if (value == 0) return std::signbit(value) ? std::memcpy(to, "-0.0", 4), to + 4 : (std::memcpy(to, "0.0", 3), to + 3);
    constexpr int longest = sizeof(Real) == 8 ? 16 : 13, least = sizeof(Real) == 8 ? -5 : -6;
    if (value < 0) *to++ = '-', value = -value;
    // d.ddd e ±dd
    char text[longest_number], *end = std::to_chars(text, text + longest_number, value, std::chars_format::scientific).ptr;
    char *mark = end - 3;
    while (*mark != 'e') --mark;
    int exponent = 0;
    std::from_chars(mark + (mark[1] == '+' ? 2 : 1), end, exponent);
    const int point = exponent + 1;  // digits before the point
    int count = std::max(int(mark - text) - 1, 1);
    if (count > 1) text[1] = text[0];
    const char *digits = count > 1 ? text + 1 : text;
    if (least < point && point <= 0) {
        std::memcpy(to, "0.000000", 8), to += 2 - point;
        return std::memcpy(to, digits, std::size_t(count)), to + count;
    }
    if (0 < point && point <= longest) {
        const int before = std::min(count, point);
        to = std::copy_n(digits, before, to);
        to = std::fill_n(to, point - before, '0');
        *to++ = '.';
        if (count <= point) return *to = '0', to + 1;
        return std::copy_n(digits + point, count - point, to);
    }
    *to++ = digits[0];
    if (count > 1) *to++ = '.', to = std::copy_n(digits + 1, count - 1, to);
    *to++ = 'e', *to++ = point > 0 ? '+' : '-';
    return put_whole(to, std::abs(point - 1));
}

}  // namespace jink::inline JINK_LEVEL::text
