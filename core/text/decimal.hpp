// Numbers as text: the shortest that reads back as the same number, bit for bit.
//
// Raffaello Giulietti, "The Schubfach way to render doubles" (2020): of the decimals that lie in the interval which rounds to x, one of the fewest
// digits, of these the closest to x. Most numbers need only powers of five that 128 bits hold. The standard library takes twice as long, and does the
// rest.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace jink::inline JINK_LEVEL::text {

inline constexpr int longest_number = 40;

template <class N> char *put_whole(char *to, N n) { return std::to_chars(to, to + longest_number, n).ptr; }

using Wide = unsigned __int128;

// 5^k 2^e for every k that 128 bits can hold, with such an e that the first of them is set.
inline constexpr auto fives = [] {
    std::array<Wide, 56> out{1};
    for (std::size_t k = 1; k < out.size(); ++k) out[k] = 5 * out[k - 1];
    for (Wide &five : out)
        while (!(five >> 127)) five <<= 1;
    return out;
}();

struct Decimal {  // digits 10^exponent
    std::uint64_t digits;
    int exponent;
};

// n five / 2^128, whose last bit also stands for all that is cut off.
inline std::uint64_t round_to_odd(Wide five, std::uint64_t n) {
    const Wide low = Wide(std::uint64_t(five)) * n, high = (five >> 64) * n + (low >> 64);
    return std::uint64_t(high >> 64) | ((std::uint64_t(high) | std::uint64_t(low)) != 0);
}

inline bool has_shortest(double value) { return 1e-38 < value && value < 0x1p53; }
inline bool has_shortest(float) { return false; }  // few columns have them

// The shortest decimal of a number that has_shortest.
inline Decimal shortest(double value) {
    constexpr std::uint64_t first_bit = 1ull << 52;
    const auto bits = std::bit_cast<std::uint64_t>(value), c = (bits & (first_bit - 1)) | first_bit;
    const int q = int(bits >> 52) - 1075;  // the number is c 2^q
    if (q > -53 && (c & ((1ull << -q) - 1)) == 0) return {c >> -q, 0};

    const bool odd = c & 1, uneven = c == first_bit;            // the number below is half as far as the one above
    const int k = (q * 1262611 - (uneven ? 524031 : 0)) >> 22;  // floor of log10 of the interval's width
    const int shift = q + ((-k * 1741647) >> 19) + 1;
    const Wide five = fives[std::size_t(-k)];
    // quarters of 10^k: the interval, and the number in it
    const std::uint64_t from = round_to_odd(five, (4 * c - 2 + uneven) << shift) + odd, to = round_to_odd(five, (4 * c + 2) << shift) - odd;
    const std::uint64_t middle = round_to_odd(five, (4 * c) << shift), s = middle / 4, tenth = s / 10, half = 4 * s + 2;
    const bool tenth_below = from <= 40 * tenth, tenth_above = 40 * tenth + 40 <= to, below = from <= 4 * s, above = 4 * s + 4 <= to;
    // without branches, which nobody could predict
    const bool fewer = (tenth_below != tenth_above) & (s >= 10), nearer = (middle > half) | ((middle == half) & (s & 1));
    const bool up = ((below == above) & nearer) | (above & !below);
    const std::uint64_t mask = 0 - std::uint64_t(fewer);
    return {((tenth + tenth_above) & mask) | ((s + up) & ~mask), k + fewer};
}

// The shortest decimal of any number above 0.
template <class Real> Decimal shortest_by_library(Real value) {
    char text[longest_number], *end = std::to_chars(text, text + longest_number, value, std::chars_format::scientific).ptr;
    char *const mark = std::find(text, end, 'e');
    const bool point = mark > text + 1;
    Decimal out{};
    std::from_chars(mark + (mark[1] == '+' ? 2 : 1), end, out.exponent);
    if (point) text[1] = text[0], out.exponent -= int(mark - text) - 2;
    std::from_chars(text + point, mark, out.digits);
    return out;
}

// Sixteen digits, the first in the lowest byte.
inline Wide digits_of(std::uint64_t n) {
    using Eights = std::uint64_t __attribute__((vector_size(16)));
    using Fours = std::uint32_t __attribute__((vector_size(16)));
    using Twos = std::uint16_t __attribute__((vector_size(16)));
    const Eights eights{n / 100'000'000, n % 100'000'000};
    const auto fours = std::bit_cast<Fours>((eights << 32) - eights / 10'000 * ((10'000ull << 32) - 1));
    const auto twos = std::bit_cast<Twos>((fours << 16) - fours / 100 * ((100u << 16) - 1));
    return std::bit_cast<Wide>((twos << 8) - twos / 10 * std::uint16_t((10 << 8) - 1));
}

// A finite number, with a point or an exponent: 1.0, 0.00012, 1e-7, 1.5e+22. Writes up to 40 bytes.
template <class Real> char *put_real(char *to, Real value) {
    *to = '-', to += std::signbit(value), value = std::abs(value);
    if (value == 0) return std::memcpy(to, "0.0", 3), to + 3;
    auto [digits, exponent] = has_shortest(value) ? shortest(value) : shortest_by_library(value);
    constexpr std::uint64_t tens = 10'000'000'000'000'000, zeros = 0x3030303030303030;
    // 17 digits, which most numbers have but for one
    const bool all = digits >= tens;
    digits += 9 * digits & (std::uint64_t(all) - 1), exponent -= !all;
    for (; digits < tens; --exponent) digits *= 10;
    const int point = exponent + 17;  // digits before the point
    const char first = char('0' + digits / tens);
    Wide rest = digits_of(digits % tens);
    const auto low = std::uint64_t(rest), high = std::uint64_t(rest >> 64);
    const int count = 17 - (high ? std::countl_zero(high) : 64 + std::countl_zero(low)) / 8;  // without zeros at the end
    rest |= Wide(zeros) << 64 | zeros;

    constexpr int longest = sizeof(Real) == 8 ? 16 : 13, least = sizeof(Real) == 8 ? -5 : -6;
    if (least < point && point <= 0) {
        std::memcpy(to, "0.000000", 8), to += 2 - point;
        *to = first, std::memcpy(to + 1, &rest, sizeof rest);
        return to + count;
    }
    const bool plain = 0 < point && point <= longest;
    const int before = plain ? 8 * (point - 1) : 0;  // bits of the rest before the point
    const Wide whole = (Wide(1) << before) - 1, pointed = (rest & whole) | Wide('.') << before | (rest & ~whole) << 8;
    *to = first, std::memcpy(to + 1, &pointed, sizeof pointed), to[17] = char(rest >> 120);
    if (plain) return to + 1 + std::max(count, point + 1);
    to += count > 1 ? count + 1 : 1;
    *to++ = 'e', *to++ = point > 0 ? '+' : '-';
    return put_whole(to, std::abs(point - 1));
}

}  // namespace jink::inline JINK_LEVEL::text
